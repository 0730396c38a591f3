#include "tests/lab/bench/orbit_text.h"

#include <bit>
#include <charconv>
#include <cstdint>

#include <fmt/format.h>

namespace tremolo::bench {

std::string orbit_text(const Eigen::MatrixXd& q) {
  std::string text;
  text.reserve(16 * static_cast<std::size_t>(q.size()));
  for (const double value : q.reshaped())
    fmt::format_to(std::back_inserter(text), "{:016x}", std::bit_cast<std::uint64_t>(value));
  return text;
}

Eigen::MatrixXd orbit_from_text(std::string_view text, Eigen::Index rows) {
  const auto count = static_cast<Eigen::Index>(text.size() / 16);
  if (rows < 1 || text.size() % 16 != 0 || count % rows != 0) return {};
  Eigen::MatrixXd q(rows, count / rows);
  for (double& value : q.reshaped()) {
    std::uint64_t bits = 0;
    const auto read = std::from_chars(text.data(), text.data() + 16, bits, 16);
    if (read.ptr != text.data() + 16) return {};
    value = std::bit_cast<double>(bits);
    text.remove_prefix(16);
  }
  return q;
}

}  // namespace tremolo::bench
