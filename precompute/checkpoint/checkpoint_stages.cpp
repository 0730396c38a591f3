#include "precompute/checkpoint/checkpoint_stages.h"

#include <deque>

#include "common/packed_index.h"
#include "precompute/reduction/third_derivatives.h"
#include "precompute/system/failure.h"

namespace tremolo {
namespace {

constexpr Eigen::Index kAnyRows = -1;

// Collects named values for a file. The values and the writer must outlive the result of arrays().
class StageWriter {
 public:
  void operator()(const char* name, const double& value) {
    arrays_.push_back(named_array(name, std::span(&value, 1), 1));
  }
  void operator()(const char* name, const int& value) { add(name, value); }
  void operator()(const char* name, const Eigen::Index& value) { add(name, value); }
  void operator()(const char* name, const std::string& text) {
    arrays_.push_back(named_array(name, std::string_view(text)));
  }
  void operator()(const char* name, const std::vector<double>& values, Eigen::Index) {
    arrays_.push_back(named_array(name, values, values.size()));
  }
  void operator()(const char* name, const Eigen::VectorXd& values, Eigen::Index) {
    add(name, values.data(), values.rows(), 1);
  }
  void operator()(const char* name, const Columns& values, Eigen::Index, Eigen::Index) {
    add(name, values.data(), values.rows(), values.cols());
  }
  // Stored as the columns of its transpose.
  void operator()(const char* name, const BasisRows& values, Eigen::Index, Eigen::Index) {
    add(name, values.data(), values.cols(), values.rows());
  }
  void add(const char* name, const double* values, Eigen::Index rows, Eigen::Index columns) {
    arrays_.push_back(named_array(name, std::span(values, static_cast<std::size_t>(rows * columns)),
                                  rows, columns));
  }
  const std::vector<NamedArray>& arrays() const { return arrays_; }

 private:
  void add(const char* name, std::int64_t value) {
    integers_.push_back(value);
    arrays_.push_back(named_array(name, std::span<const std::int64_t>(&integers_.back(), 1)));
  }

  std::deque<std::int64_t> integers_;
  std::vector<NamedArray> arrays_;
};

// Reads the same names from a file and checks their shapes. Throws Failure.
class StageReader {
 public:
  explicit StageReader(const CheckpointFile& file) : file_(file) {}

  void operator()(const char* name, double& value) { value = shaped(name, 1, 1)(0); }
  void operator()(const char* name, int& value) { value = static_cast<int>(integer(name)); }
  void operator()(const char* name, Eigen::Index& value) { value = integer(name); }
  void operator()(const char* name, std::string& text) { text = unwrap(file_.text(name)); }
  void operator()(const char* name, std::vector<double>& values, Eigen::Index rows) {
    const Eigen::MatrixXd matrix = shaped(name, rows, 1);
    values.assign(matrix.data(), matrix.data() + matrix.size());
  }
  void operator()(const char* name, Eigen::VectorXd& values, Eigen::Index rows) {
    values = shaped(name, rows, 1);
  }
  void operator()(const char* name, Columns& values, Eigen::Index rows, Eigen::Index columns) {
    values = shaped(name, rows, columns);
  }
  void operator()(const char* name, BasisRows& values, Eigen::Index rows, Eigen::Index columns) {
    values = shaped(name, columns, rows).transpose();
  }

 private:
  [[noreturn]] static void refuse(const char* name) {
    throw Failure(content_error(std::string("'") + name + "' has another size than the stage's"));
  }
  // Returns an integer that fits an int, as all stored counts do.
  std::int64_t integer(const char* name) const {
    const std::vector<std::int64_t> values = unwrap(file_.integers(name));
    if (values.size() != 1 || values[0] != static_cast<int>(values[0])) refuse(name);
    return values[0];
  }
  Eigen::MatrixXd shaped(const char* name, Eigen::Index rows, Eigen::Index columns) const {
    Eigen::MatrixXd values = unwrap(file_.matrix(name));
    if ((rows != kAnyRows && values.rows() != rows) || values.cols() != columns) refuse(name);
    return values;
  }

  const CheckpointFile& file_;
};

// Returns `found` if it is a valid number of columns for `asked`. Throws Failure.
Eigen::Index in_range(Eigen::Index found, Eigen::Index asked) {
  if (found < asked || found > asked + kMostAdded)
    throw Failure(content_error(std::to_string(found) + " columns where " + std::to_string(asked) +
                                " were asked for"));
  return found;
}

// One list of names for reading and writing. asked, dofs: for the reader; the writer ignores
// shapes.
template <class Archive, class Value>
void describe_modes(Archive& archive, Value& whole, Eigen::Index dofs, Eigen::Index asked) {
  auto& modes = whole.modes;
  archive("squared_frequencies", modes.squared_frequencies, kAnyRows);
  const Eigen::Index count =
      asked == kAnyRows ? asked : in_range(modes.squared_frequencies.size(), asked);
  archive("vectors", modes.vectors, dofs, count);
  archive("residuals", modes.residuals, count);
  archive("left_out", modes.left_out, kAnyRows);
  archive("scaled_residual", modes.scaled_residual);
  archive("next_squared_frequency", modes.next_squared_frequency);
  archive("cancellation", modes.cancellation);
  archive("shift", modes.shift);
  archive("solves", modes.solves);
  archive("solver", modes.solver);
  archive("factorisation", modes.factorisation);
  archive("note", whole.note);
}

template <class Archive, class Value>
void describe_certificate(Archive& archive, Value& certificate) {
  archive("bound", certificate.bound);
  archive("expected", certificate.expected);
  archive("counted", certificate.counted);
  archive("solver", certificate.solver);
}

template <class Archive, class Value>
void describe_basis(Archive& archive, Value& finished, Eigen::Index rows, Eigen::Index asked) {
  archive("lambda", finished.basis.lambda, kAnyRows);
  const Eigen::Index r = asked == kAnyRows ? asked : in_range(finished.basis.lambda.size(), asked);
  archive("rows", finished.rows, rows, r);
  archive("singular_values", finished.basis.singular_values, kAnyRows);
  archive("orthonormality_error", finished.basis.orthonormality_error);
  archive("diagonality_error", finished.basis.diagonality_error);
  archive("cut_first", finished.basis.cut.first);
  archive("cut_count", finished.basis.cut.count);
  archive("derivative_residual", finished.derivative_residual);
}

template <class Archive, class Value>
void describe_coefficients(Archive& archive, Value& finished, Eigen::Index r) {
  const std::size_t count = r;
  archive("cubic", finished.cubic, triple_count(count));
  archive("quartic", finished.quartic, quad_count(count));
  archive("strain_gram", finished.strain_gram, pair_count(strain_terms(count)));
  archive("polynomial_error", finished.polynomial_error);
}

template <class Describe>
void keep(Checkpoint& checkpoint, const char* stage, const Describe& describe) {
  StageWriter writer;
  describe(writer);
  checkpoint.keep(stage, writer.arrays());
}

template <class Value, class Describe>
std::optional<Value> find(Checkpoint& checkpoint, const char* stage, const Describe& describe) {
  Value value;
  const bool found = checkpoint.find(stage, [&](const CheckpointFile& file) {
    StageReader reader(file);
    describe(reader, value);
  });
  if (!found) return std::nullopt;
  return value;
}

}  // namespace

void keep_modes(Checkpoint& checkpoint, const WholeModes& whole) {
  keep(checkpoint, "modes",
       [&](auto& archive) { describe_modes(archive, whole, kAnyRows, kAnyRows); });
}

std::optional<WholeModes> find_modes(Checkpoint& checkpoint, Eigen::Index dofs,
                                     Eigen::Index count) {
  return find<WholeModes>(checkpoint, "modes", [&](auto& archive, WholeModes& whole) {
    describe_modes(archive, whole, dofs, count);
  });
}

void keep_derivatives(Checkpoint& checkpoint, const ModalDerivatives& derivatives) {
  keep(checkpoint, "derivatives", [&](auto& archive) {
    const auto vectors = derivatives.vectors();
    archive("count", vectors.cols());
    archive.add("vectors", vectors.data(), vectors.rows(), vectors.cols());
    archive("residual", derivatives.residual);
  });
}

namespace {

// Throws Failure unless k modes have so many derivatives, with or without those of third order.
void require_derivatives(Eigen::Index k, Eigen::Index count) {
  const Eigen::Index thirds = count - static_cast<Eigen::Index>(pair_count(k));
  if (thirds != std::ssize(third_orders_of(k, k + count)))
    throw Failure(
        content_error(std::to_string(count) + " derivatives of " + std::to_string(k) + " modes"));
}

}  // namespace

std::optional<ModalDerivatives> find_derivatives(Checkpoint& checkpoint, const Columns& modes) {
  return find<ModalDerivatives>(checkpoint, "derivatives",
                                [&](auto& archive, ModalDerivatives& derivatives) {
                                  Eigen::Index count = 0;
                                  archive("count", count);
                                  Columns vectors;
                                  require_derivatives(modes.cols(), count);
                                  archive("vectors", vectors, modes.rows(), count);
                                  archive("residual", derivatives.residual);
                                  derivatives.modes = modes.cols();
                                  derivatives.columns.resize(modes.rows(), modes.cols() + count);
                                  derivatives.columns << modes, vectors;
                                });
}

void keep_certificate(Checkpoint& checkpoint, const InertiaCertificate& certificate) {
  keep(checkpoint, "certificate",
       [&](auto& archive) { describe_certificate(archive, certificate); });
}

std::optional<InertiaCertificate> find_certificate(Checkpoint& checkpoint) {
  return find<InertiaCertificate>(checkpoint, "certificate",
                                  [](auto& archive, InertiaCertificate& certificate) {
                                    describe_certificate(archive, certificate);
                                  });
}

void keep_basis(Checkpoint& checkpoint, const FinishedBasis& finished) {
  keep(checkpoint, "basis",
       [&](auto& archive) { describe_basis(archive, finished, kAnyRows, kAnyRows); });
  checkpoint.drop("derivatives");
}

std::optional<FinishedBasis> find_basis(Checkpoint& checkpoint, Eigen::Index rows, Eigen::Index r) {
  return find<FinishedBasis>(checkpoint, "basis", [&](auto& archive, FinishedBasis& finished) {
    describe_basis(archive, finished, rows, r);
  });
}

void keep_coefficients(Checkpoint& checkpoint, const FinishedCoefficients& finished) {
  keep(checkpoint, "coefficients",
       [&](auto& archive) { describe_coefficients(archive, finished, 0); });
}

std::optional<FinishedCoefficients> find_coefficients(Checkpoint& checkpoint, Eigen::Index r) {
  return find<FinishedCoefficients>(checkpoint, "coefficients",
                                    [&](auto& archive, FinishedCoefficients& finished) {
                                      describe_coefficients(archive, finished, r);
                                    });
}

}  // namespace tremolo
