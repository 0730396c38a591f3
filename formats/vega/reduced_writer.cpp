#include <bit>
#include <cstdint>
#include <cstring>
#include <limits>

#include "common/packed_index.h"
#include "formats/vega/reduced_files.h"

namespace tremolo {
namespace {

static_assert(std::endian::native == std::endian::little, "values are written as they lie");

constexpr std::size_t kMost = std::numeric_limits<std::int32_t>::max();

void append_count(std::string& bytes, std::size_t count) {
  const auto value = static_cast<std::int32_t>(count);
  char raw[sizeof(value)];
  std::memcpy(raw, &value, sizeof(value));
  bytes.append(raw, sizeof(raw));
}

void append_numbers(std::string& bytes, const double* values, std::size_t count) {
  bytes.append(reinterpret_cast<const char*>(values), count * sizeof(double));
}

}  // namespace

ReducedForces reduced_forces(const Eigen::VectorXd& lambda, std::span<const double> cubic,
                             std::span<const double> quartic) {
  ReducedForces forces;
  const auto r = forces.size = static_cast<std::size_t>(lambda.size());
  forces.linear.assign(r * r, 0.0);
  for (std::size_t i = 0; i < r; ++i)
    forces.linear[i * r + i] = lambda[static_cast<Eigen::Index>(i)];
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
  const auto r = static_cast<Eigen::Index>(forces.size);
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
    append_numbers(bytes, values->data(), values->size());
  return bytes;
}

Result<std::string> basis_matrix_bytes(const Eigen::MatrixXd& basis) {
  const auto rows = static_cast<std::size_t>(basis.rows());
  const auto columns = static_cast<std::size_t>(basis.cols());
  if (rows > kMost || columns > kMost)
    return content_error("a basis of " + std::to_string(rows) +
                         " rows: a .U file counts with 32 bits");
  std::string bytes;
  bytes.reserve(8 + sizeof(double) * rows * columns);
  append_count(bytes, rows);
  append_count(bytes, columns);
  append_numbers(bytes, basis.data(), rows * columns);
  return bytes;
}

}  // namespace tremolo
