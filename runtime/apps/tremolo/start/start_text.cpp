#include <charconv>
#include <cmath>

#include "runtime/apps/tremolo/start/start_state.h"

namespace tremolo {

Result<Eigen::Vector3d> parse_force(const std::string& text) {
  Eigen::Vector3d vector;
  const char* at = text.data();
  const char* const end = at + text.size();
  bool good = true;
  for (int axis = 0; axis < 3 && good; ++axis) {
    const auto [next, error] = std::from_chars(at, end, vector[axis]);
    good = error == std::errc{} && (axis == 2 ? next == end : next != end && *next == ',');
    at = next + 1;
  }
  if (good && vector.allFinite()) return vector;
  return Error{ErrorKind::kUsage,
               "force '" + text + "': expected three finite numbers, X,Y,Z in N"};
}

// WHERE=X,Y,Z; a selector may hold the sign as well.
std::optional<StartDisplacement> start_displacement(const std::string& text) {
  const std::size_t equals = text.rfind('=');
  if (equals == std::string::npos || equals == 0) return std::nullopt;
  const Result<Eigen::Vector3d> by = parse_force(text.substr(equals + 1));
  if (!by) return std::nullopt;
  return StartDisplacement{text.substr(0, equals), *by};
}

// The text after the last @ is a time only if it is a number.
StartRow start_row(const std::string& text) {
  const std::size_t at = text.rfind('@');
  double time = 0.0;
  if (at != std::string::npos) {
    const char* end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data() + at + 1, end, time);
    if (error == std::errc{} && stop == end && std::isfinite(time))
      return {text.substr(0, at), time};
  }
  return {text, std::nullopt};
}

std::string file_of_start(const std::string& text) {
  return text.empty() || text == kStaticStart || start_displacement(text) ? ""
                                                                          : start_row(text).path;
}

std::string selector_of_start(const std::string& text) {
  const auto displacement = start_displacement(text);
  return displacement ? displacement->where : "";
}

}  // namespace tremolo
