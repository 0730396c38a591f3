// tremolo_curve_*: the points and bifurcations of a curve.
#include "runtime/c/c_api_curve.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "runtime/response/orbit.h"

using tremolo::CurvePoint;
using tremolo::Status;
using tremolo::Success;
using tremolo::usage_error;
using tremolo::c_api::at_index;

void tremolo_curve_destroy(tremolo_curve* curve) {
  delete curve;
}

size_t tremolo_curve_points(const tremolo_curve* curve) {
  return curve == nullptr ? 0 : curve->points.size();
}

size_t tremolo_curve_bifurcations(const tremolo_curve* curve) {
  return curve == nullptr ? 0 : curve->bifurcations.size();
}

uint32_t tremolo_curve_probe(const tremolo_curve* curve) {
  return curve == nullptr ? TREMOLO_ANY_VERTEX : static_cast<uint32_t>(curve->probe);
}

tremolo_curve_end tremolo_curve_reached(const tremolo_curve* curve) {
  return curve == nullptr ? TREMOLO_CURVE_STUCK : static_cast<tremolo_curve_end>(curve->curve.end);
}

const char* tremolo_curve_reason(const tremolo_curve* curve) {
  return curve == nullptr ? "the curve is NULL" : curve->reason.c_str();
}

tremolo_status tremolo_curve_point_at(const tremolo_curve* curve, size_t index,
                                      tremolo_curve_point* point) {
  return tremolo::c_api::with_all({{curve, "the curve"}, {point, "the place for the point"}}, [&] {
    return at_index(curve->points, index, "point", [&](const tremolo_curve_point& at) -> Status {
      *point = at;
      return Success{};
    });
  });
}

tremolo_status tremolo_curve_bifurcation_at(const tremolo_curve* curve, size_t index,
                                            tremolo_bifurcation* bifurcation) {
  return tremolo::c_api::with_all(
      {{curve, "the curve"}, {bifurcation, "the place for the bifurcation"}}, [&] {
        return at_index(curve->bifurcations, index, "bifurcation",
                        [&](const tremolo_bifurcation& at) -> Status {
                          *bifurcation = at;
                          return Success{};
                        });
      });
}

tremolo_status tremolo_curve_motion(const tremolo_curve* curve, size_t index, double* out,
                                    size_t length) {
  return tremolo::c_api::with_all({{curve, "the curve"}, {out, "the buffer"}}, [&] {
    return at_index(curve->curve.points, index, "point", [&](const CurvePoint& at) -> Status {
      const auto needed = static_cast<std::size_t>(at.motion.size());
      if (Status s = tremolo::c_api::need_buffer(out, length, needed); !s) return s;
      std::copy_n(at.motion.data(), needed, out);
      return Success{};
    });
  });
}

tremolo_status tremolo_curve_state(const tremolo_curve* curve, size_t index, double fraction,
                                   double* q, double* p, size_t length) {
  return tremolo::c_api::with_all({{curve, "the curve"}, {q, "the buffer"}}, [&] {
    return at_index(curve->curve.points, index, "point", [&](const CurvePoint& at) -> Status {
      if (!std::isfinite(fraction)) return usage_error("the fraction of the period is not finite");
      return tremolo::c_api::copy_state(orbit_state(at, 2.0 * std::numbers::pi * fraction), q, p,
                                        length);
    });
  });
}
