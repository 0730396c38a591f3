#include <cmath>
#include <cstdint>
#include <limits>

#include "common/packed_index.h"
#include "formats/basis/basis_layout.h"
#include "formats/file/scanner.h"
#include "formats/vega/reduced_files.h"

namespace tremolo {
namespace {

Result<std::size_t> read_count(ByteScanner& scanner, const std::string& what, std::uint64_t low,
                               std::uint64_t high) {
  std::int32_t count = 0;
  if (!scanner.read(count, what)) return scanner.error();
  if (std::cmp_greater_equal(count, low) && std::cmp_less_equal(count, high))
    return std::size_t(count);
  const std::string range = low == high
                                ? std::to_string(low)
                                : "from " + std::to_string(low) + " to " + std::to_string(high);
  return scanner.problem("expected " + what + " " + range + ", found " + std::to_string(count));
}

// All that is left of the file must be `count` numbers. count: a product that fits 64 bits.
Status require_rest(ByteScanner& scanner, std::size_t count) {
  if (!scanner.fits(count, sizeof(double), "numbers")) return scanner.error();
  if (scanner.remaining() == count * sizeof(double)) return Success{};
  return scanner.problem(
      "expected " + std::to_string(count) + " numbers behind the counts, found " +
      std::to_string(scanner.remaining()) + " bytes, " +
      std::to_string(scanner.remaining() - count * sizeof(double)) + " too many");
}

Status read_numbers(ByteScanner& scanner, std::size_t count, double* values) {
  for (std::size_t i = 0; i < count; ++i) {
    if (!scanner.read(values[i], "a number")) return scanner.error();
    if (!std::isfinite(values[i]))
      return scanner.problem("expected a finite number, found one that is not");
  }
  return Success{};
}

}  // namespace

Result<ReducedForces> read_cub(std::string_view bytes, const std::string& path) {
  ByteScanner scanner(bytes, path, 0, kSwapsLittleEndian);
  const Result<std::size_t> size =
      read_count(scanner, "r, the number of coordinates,", 1, basis_layout::kMaxModes);
  if (!size) return size.error();
  const std::size_t r = *size;
  // At r = 4 096 the largest, r x C, is 5e13: no product overflows, but a count need not fit 32
  // bits, and then no file has it.
  std::size_t total = 0;
  for (const auto& [name, count] : {std::pair{"L = r, linear terms,", r},
                                    {"Q = r(r+1)/2, quadratic terms,", pair_count(r)},
                                    {"C = r(r+1)(r+2)/6, cubic terms,", triple_count(r)}}) {
    if (Result<std::size_t> found = read_count(scanner, name, count, count); !found)
      return found.error();
    total += r * count;
  }
  if (Status status = require_rest(scanner, total); !status) return status.error();
  ReducedForces forces;
  forces.size = r;
  for (const auto& [values, count] : {std::pair{&forces.linear, r},
                                      {&forces.quadratic, pair_count(r)},
                                      {&forces.cubic, triple_count(r)}}) {
    values->resize(r * count);
    if (Status status = read_numbers(scanner, values->size(), values->data()); !status)
      return status.error();
  }
  return forces;
}

Result<Eigen::MatrixXd> read_basis_matrix(std::string_view bytes, const std::string& path) {
  ByteScanner scanner(bytes, path, 0, kSwapsLittleEndian);
  constexpr std::uint64_t kMost = std::numeric_limits<std::int32_t>::max();
  const Result<std::size_t> rows = read_count(scanner, "a number of rows", 1, kMost);
  if (!rows) return rows.error();
  const Result<std::size_t> columns =
      read_count(scanner, "a number of columns", 1, basis_layout::kMaxModes);
  if (!columns) return columns.error();
  if (Status status = require_rest(scanner, *rows * *columns); !status) return status.error();
  Eigen::MatrixXd basis(*rows, *columns);
  if (Status status = read_numbers(scanner, *rows * *columns, basis.data()); !status)
    return status.error();
  return basis;
}

}  // namespace tremolo
