// Units of length by their names.
#pragma once

#include <charconv>
#include <cmath>
#include <string>
#include <string_view>
#include <utility>

#include "common/result.h"

namespace tremolo {

// "mm", "cm", "m", "in", "ft", or a positive number: metres in one unit. kUsage otherwise.
inline Result<double> parse_length_unit(const std::string& text) {
  constexpr std::pair<std::string_view, double> kUnits[] = {
      {"mm", 1e-3}, {"cm", 1e-2}, {"m", 1.0}, {"in", 0.0254}, {"ft", 0.3048}};
  for (const auto& [name, metres] : kUnits)
    if (text == name) return metres;
  double value = 0.0;
  const char* end = text.data() + text.size();
  const auto [stop, code] = std::from_chars(text.data(), end, value);
  if (code == std::errc{} && stop == end && std::isfinite(value) && value > 0.0) return value;
  return Error{ErrorKind::kUsage, "unit '" + text +
                                      "': expected mm, cm, m, in, ft or a positive number, the "
                                      "metres in one unit"};
}

}  // namespace tremolo
