// Units that people use: lengths of files, hertz.
#pragma once

#include <cmath>
#include <cstdlib>
#include <numbers>
#include <string>
#include <utility>

#include "common/result.h"

namespace tremolo {

// Units that people's files are in.
inline constexpr const char* kLengthUnits =
    "um, mm, cm, m, km, in, ft, or metres a unit as a number";

// "mm" -> 0.001. Errors: kUsage for a text that is neither a unit nor a positive finite number.
inline Result<double> metres_per_unit(const std::string& text) {
  constexpr std::pair<const char*, double> kUnits[] = {{"um", 1e-6},  {"mm", 1e-3}, {"cm", 1e-2},
                                                       {"m", 1.0},    {"km", 1e3},  {"in", 0.0254},
                                                       {"ft", 0.3048}};
  for (const auto& [name, metres] : kUnits)
    if (text == name) return metres;
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != '\0' || !std::isfinite(value) || !(value > 0))
    return Error{ErrorKind::kUsage,
                 "'" + text + "' is no unit of length; there are " + kLengthUnits};
  return value;
}

// The frequency in Hz of a squared angular frequency, (rad/s)^2.
inline double hertz(double squared_frequency) {
  return std::sqrt(squared_frequency) / (2.0 * std::numbers::pi);
}

// A unit as the user wrote it.
struct LengthUnit {
  std::string text;
  double metres = 1;
};

inline Result<LengthUnit> parse_length_unit(const std::string& text) {
  const Result<double> metres = metres_per_unit(text);
  if (!metres) return metres.error();
  return LengthUnit{text, *metres};
}

}  // namespace tremolo
