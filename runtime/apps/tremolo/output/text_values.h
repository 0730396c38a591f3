// Values in the texts that the programs write: cells of a CSV line, numbers as JSON.
#pragma once

#include <algorithm>
#include <cmath>
#include <string_view>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

#include "formats/file/scanner.h"
#include "runtime/math/state.h"

namespace tremolo {

// The line without the return that Windows puts at its end.
inline std::string_view without_return(std::string_view line) {
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  return line;
}

// One cell at least; the views are into `line`.
inline std::vector<std::string_view> cells_of(std::string_view line) {
  line = without_mark(without_return(line));
  std::vector<std::string_view> cells;
  for (std::size_t at = 0; at <= line.size();) {
    const std::size_t end = std::min(line.find(',', at), line.size());
    cells.push_back(line.substr(at, end - at));
    at = end + 1;
  }
  return cells;
}

// Numbers as JSON, which has no infinity: values that are not finite become null.
inline nlohmann::ordered_json number_or_null(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
}

inline nlohmann::ordered_json vector_json(const Eigen::Vector3d& v) {
  return {number_or_null(v.x()), number_or_null(v.y()), number_or_null(v.z())};
}

inline nlohmann::ordered_json quaternion_json(const Eigen::Quaterniond& q) {
  return {number_or_null(q.w()), number_or_null(q.x()), number_or_null(q.y()),
          number_or_null(q.z())};
}

// Adds the momenta at the start and at the end of a run.
inline void add_momenta(const Momenta& start, const Momenta& end, nlohmann::ordered_json& json) {
  json["linear_momentum_initial"] = vector_json(start.linear);
  json["linear_momentum_final"] = vector_json(end.linear);
  json["angular_momentum_initial"] = vector_json(start.angular);
  json["angular_momentum_final"] = vector_json(end.angular);
}

}  // namespace tremolo
