#include <cstdint>
#include <limits>

#include "common/packed_index.h"
#include "formats/file/stored_values.h"
#include "formats/vega/reduced_files.h"

namespace tremolo {
namespace {

constexpr std::size_t kMost = std::numeric_limits<std::int32_t>::max();

void append_count(std::string& bytes, std::size_t count) {
  append_bytes(bytes, static_cast<std::int32_t>(count));
}

}  // namespace

ReducedForces reduced_forces(const Eigen::VectorXd& lambda, std::span<const double> cubic,
                             std::span<const double> quartic) {
  ReducedForces forces;
  const auto r = forces.size = lambda.size();
  forces.linear.assign(r * r, 0.0);
  for (std::size_t i = 0; i < r; ++i) forces.linear[i * r + i] = lambda[i];
  forces.quadratic.assign(r * pair_count(r), 0.0);
  forces.cubic.assign(r * triple_count(r), 0.0);
  if (cubic.empty()) return forces;
  // d/dq_i of a tensor of order d is d times the tensor with one index i; its monomials collect
  // the orderings of the other indices.
  double* quadratic = forces.quadratic.data();
  double* third = forces.cubic.data();
  for (std::size_t i = 0; i < r; ++i)
    for (std::size_t j = 0; j < r; ++j)
      for (std::size_t k = j; k < r; ++k) {
        *quadratic++ = 3.0 * (j == k ? 1.0 : 2.0) * cubic[triple_index_any(i, j, k)];
        for (std::size_t l = k; l < r; ++l)
          *third++ = 4.0 * orderings(j, k, l) * quartic[quad_index_any(i, j, k, l)];
      }
  return forces;
}

Eigen::VectorXd evaluate(const ReducedForces& forces, const Eigen::VectorXd& q) {
  const Eigen::Index r = forces.size;
  Eigen::VectorXd result = Eigen::VectorXd::Zero(r);
  const double* linear = forces.linear.data();
  const double* quadratic = forces.quadratic.data();
  const double* cubic = forces.cubic.data();
  for (Eigen::Index i = 0; i < r; ++i)
    for (Eigen::Index j = 0; j < r; ++j) {
      double sum = *linear++;
      for (Eigen::Index k = j; k < r; ++k) {
        double inner = *quadratic++;
        for (Eigen::Index l = k; l < r; ++l) inner += *cubic++ * q[l];
        sum += inner * q[k];
      }
      result[i] += sum * q[j];
    }
  return result;
}

Result<std::string> cub_bytes(const ReducedForces& forces) {
  const std::size_t r = forces.size;
  if (r == 0 || r > kMost || r * triple_count(r) > kMost)
    return content_error(std::to_string(r) +
                         " coordinates: VegaFEM's .cub holds from 1 to 336, since it counts "
                         "coefficients with 32 bits");
  std::string bytes;
  bytes.reserve(16 + sizeof(double) *
                         (forces.linear.size() + forces.quadratic.size() + forces.cubic.size()));
  for (std::size_t count : {r, r, pair_count(r), triple_count(r)}) append_count(bytes, count);
  for (const auto* values : {&forces.linear, &forces.quadratic, &forces.cubic})
    append_bytes(bytes, values->data(), values->size());
  return bytes;
}

Result<std::string> basis_matrix_bytes(const Eigen::MatrixXd& basis) {
  const std::size_t rows = basis.rows();
  const std::size_t columns = basis.cols();
  if (rows > kMost || columns > kMost)
    return content_error("a basis of " + std::to_string(rows) +
                         " rows: a .U file counts with 32 bits");
  std::string bytes;
  bytes.reserve(8 + sizeof(double) * rows * columns);
  append_count(bytes, rows);
  append_count(bytes, columns);
  append_bytes(bytes, basis.data(), rows * columns);
  return bytes;
}

}  // namespace tremolo
