// The object behind tremolo_curve.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "common/text.h"
#include "runtime/c/c_api.h"
#include "runtime/response/response.h"

// NOLINTBEGIN(readability-identifier-naming): the name of the C header
struct tremolo_curve {
  tremolo::Model::Pointer model;
  tremolo::VibratingSystem system;
  tremolo::CurveOptions options;
  std::optional<tremolo::ResponseRequest> request;  // of tremolo_response alone
  double load_scale = 0.0;                          // of points whose load has the factor 1
  tremolo::VertexId probe = 0;
  tremolo::MotionCurve curve = {};
  std::vector<tremolo_curve_point> points = {};
  std::vector<tremolo_bifurcation> bifurcations = {};
  std::string reason = {};  // empty: as requested
};
// NOLINTEND(readability-identifier-naming)

namespace tremolo::c_api {

// Runs action(number `index` of the list) -> Status.
template <class List, class Action>
Status at_index(const List& list, std::size_t index, const char* what, const Action& action) {
  if (index < list.size()) return action(list[index]);
  return usage_error("the curve has no " + std::string(what) + " " + std::to_string(index) +
                     ": it has " + std::to_string(list.size()));
}

}  // namespace tremolo::c_api
