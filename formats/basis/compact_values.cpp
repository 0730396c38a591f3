#include "formats/basis/compact_values.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace tremolo {
namespace {

constexpr double kLargest = 32767.0;

Error not_finite(const char* name) {
  return content_error(std::string("basis data: a value of '") + name + "' is not finite");
}

}  // namespace

Result<ScaledFloats> to_scaled_floats(std::span<const double> values, const char* name) {
  double largest = 0.0;
  for (const double value : values) {
    if (!std::isfinite(value)) return not_finite(name);
    largest = std::max(largest, std::abs(value));
  }
  ScaledFloats scaled;
  // Coefficients carry kg^-3/2 and kg^-2: those of a crumb would not fit the range of f32.
  if (largest > 0.0) scaled.scale = std::ldexp(1.0, std::clamp(std::ilogb(largest), -1000, 1000));
  scaled.values.reserve(values.size());
  for (const double value : values)
    scaled.values.push_back(static_cast<float>(value / scaled.scale));
  return scaled;
}

Result<std::vector<double>> column_scales(std::span<const NamedRows> blocks, std::size_t r) {
  std::vector<double> scales(r, 1.0);
  for (const auto& [rows, name] : blocks)
    if (!rows->allFinite()) return not_finite(name);
  std::vector<double> largest(r, 0.0);
  for (const auto& [rows, name] : blocks)
    for (Eigen::Index row = 0; row < rows->rows(); ++row)
      for (std::size_t i = 0; i < r; ++i)
        largest[i] = std::max(largest[i], std::abs((*rows)(row, static_cast<Eigen::Index>(i))));
  for (std::size_t i = 0; i < r; ++i) {
    if (largest[i] / kLargest > 0.0) scales[i] = largest[i] / kLargest;
    if (!is_scale(scales[i])) return content_error("basis data: a basis row is too large");
  }
  return scales;
}

std::vector<std::int16_t> to_scaled_integers(const BasisRows& rows,
                                             std::span<const double> scales) {
  std::vector<std::int16_t> integers;
  integers.reserve(static_cast<std::size_t>(rows.size()));
  for (Eigen::Index row = 0; row < rows.rows(); ++row)
    for (Eigen::Index i = 0; i < rows.cols(); ++i) {
      const double rounded = std::nearbyint(rows(row, i) / scales[static_cast<std::size_t>(i)]);
      integers.push_back(static_cast<std::int16_t>(std::clamp(rounded, -kLargest, kLargest)));
    }
  return integers;
}

bool is_scale(double scale) {
  return scale > 0.0 && std::isfinite(32768.0 * scale);
}

}  // namespace tremolo
