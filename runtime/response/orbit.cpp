#include "runtime/response/orbit.h"

#include <algorithm>
#include <cmath>

namespace tremolo {

State orbit_state(const CurvePoint& point, double theta) {
  const Eigen::Index H = point.harmonics();
  return {point.motion * fourier_row(H, theta),
          point.omega * point.motion * fourier_slope_row(H, theta)};
}

CurvePoint at_amplitude(const MotionCurve& curve, double amplitude) {
  const std::vector<CurvePoint>& points = curve.points;
  const auto reached = std::find_if(points.begin(), points.end(), [&](const CurvePoint& point) {
    return point.amplitude >= amplitude;
  });
  if (reached == points.end())
    return *std::max_element(
        points.begin(), points.end(),
        [](const CurvePoint& a, const CurvePoint& b) { return a.amplitude < b.amplitude; });
  CurvePoint found = *reached;
  found.amplitude = amplitude;
  if (reached == points.begin()) {
    found.motion *= amplitude / reached->amplitude;
    return found;
  }
  const CurvePoint& before = *(reached - 1);
  const double part = (amplitude - before.amplitude) / (reached->amplitude - before.amplitude);
  if (part < 0.5) found = before;
  found.amplitude = amplitude;
  const Eigen::Index H = std::max(before.harmonics(), reached->harmonics());
  found.motion =
      (1.0 - part) * with_harmonics(before.motion, H) + part * with_harmonics(reached->motion, H);
  found.omega = (1.0 - part) * before.omega + part * reached->omega;
  return found;
}

}  // namespace tremolo
