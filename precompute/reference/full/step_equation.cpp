#include "precompute/reference/full/step_equation.h"

#include <algorithm>
#include <cmath>

namespace tremolo {

double first_minimum(double slope, double curvature, double slope_half, double slope_one,
                     double most) {
  const double whole = slope_one - slope - curvature;
  const double half = slope_half - slope - 0.5 * curvature;
  const double cubic = 2.0 * whole - 8.0 * half, square = 8.0 * half - whole;
  const auto at = [&](double t) { return slope + t * (curvature + t * (square + t * cubic)); };
  // Between neighbouring extrema the slope changes its sign at most once.
  std::vector<double> ends = {0.0};
  const double discriminant = square * square - 3.0 * cubic * curvature;
  if (discriminant > 0) {
    const double q = -(square + std::copysign(std::sqrt(discriminant), square));
    for (const double t : {q == 0 ? most : curvature / q, cubic == 0 ? most : q / (3.0 * cubic)})
      if (t > 0 && t < most) ends.push_back(t);
  }
  std::sort(ends.begin(), ends.end());
  ends.push_back(most);
  for (std::size_t i = 1; i < ends.size(); ++i) {
    double low = ends[i - 1], high = ends[i];
    if (!(at(high) > 0)) continue;
    for (int k = 0; k < 60; ++k) {
      const double middle = 0.5 * (low + high);
      (at(middle) > 0 ? high : low) = middle;
    }
    return high;
  }
  return most;
}

void move_along(const std::function<Vector(const Vector&)>& gradient, const Direction& direction,
                Vector& d, Vector& g) {
  constexpr double kEnough = 0.5;
  constexpr double kFarthest = 16.0;
  const double slope = g.dot(direction.step);
  Vector end = d + direction.step;
  Vector end_gradient = gradient(end);
  const double end_slope = end_gradient.dot(direction.step);
  if (!(direction.curvature > 0 && std::abs(end_slope) <= kEnough * std::abs(slope))) {
    const double half_slope = gradient(d + 0.5 * direction.step).dot(direction.step);
    end = d + first_minimum(slope, direction.curvature, half_slope, end_slope, kFarthest) *
                  direction.step;
    end_gradient = gradient(end);
  }
  d = std::move(end);
  g = std::move(end_gradient);
}

}  // namespace tremolo
