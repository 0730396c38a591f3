#include "common/rayleigh.h"

#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "common/decimal.h"
#include "common/number_text.h"

namespace tremolo {
namespace {

// The numbers between the separators; false if there are others.
bool read_four(std::string_view text, std::array<double, 4>& numbers) {
  constexpr std::string_view kSeparators = ":,:";
  for (std::size_t n = 0; n < 4; ++n) {
    const std::size_t end = n < 3 ? text.find(kSeparators[n]) : text.size();
    if (end == std::string_view::npos) return false;
    const auto [stop, error] = read_decimal(text.data(), text.data() + end, numbers[n]);
    if (error != std::errc{} || stop != text.data() + end) return false;
    text.remove_prefix(n < 3 ? end + 1 : end);
  }
  return true;
}

}  // namespace

Result<RayleighDamping> parse_damping_ratios(std::string_view text) {
  const std::string shown = "damping ratios " + std::string(text) + ": ";
  std::array<double, 4> numbers{};
  if (!read_four(text, numbers))
    return Error{ErrorKind::kUsage,
                 shown +
                     "expected F1:Z1,F2:Z2, two frequencies in Hz and the ratio at each, as in "
                     "1:0.02,30:0.05"};
  const auto [f1, z1, f2, z2] = numbers;
  for (const double f : {f1, f2})
    if (!(f > 0) || !std::isfinite(f))
      return content_error(shown + "a frequency must be positive and finite");
  if (f1 == f2) return content_error(shown + "two different frequencies are needed");
  for (const double z : {z1, z2})
    if (!(z >= 0) || !(z < 1))
      return content_error(shown + "a ratio is a fraction of critical damping, from 0 to below 1");
  const double w1 = 2 * std::numbers::pi * f1, w2 = 2 * std::numbers::pi * f2;
  const double determinant = w2 * w2 - w1 * w1;
  RayleighDamping damping{2 * w1 * w2 * (z1 * w2 - z2 * w1) / determinant,
                          2 * (z2 * w2 - z1 * w1) / determinant};
  // Rounding of ratios that need only one of the two.
  const double rounding = 1e-14 * (z1 + z2);
  if (damping.alpha < 0 && damping.alpha > -rounding * (w1 + w2)) damping.alpha = 0;
  if (damping.beta < 0 && damping.beta > -rounding / (w1 + w2)) damping.beta = 0;
  if (damping.alpha >= 0 && damping.beta >= 0) return damping;
  return content_error(shown + "the ratio at " + number_text(f2) + " Hz must be between " +
                       number_text(z1 * std::min(f1 / f2, f2 / f1)) + " and " +
                       number_text(z1 * std::max(f1 / f2, f2 / f1)) +
                       ": mass and stiffness damping, neither of them negative, give no other");
}

}  // namespace tremolo
