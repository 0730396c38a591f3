#include "precompute/embedding/closest_point.h"

#include <algorithm>

namespace tremolo {
namespace {

ClosestPoint at_weights(const Eigen::Vector3d& x, const std::array<Eigen::Vector3d, 3>& corners,
                        const Eigen::Vector3d& weights) {
  const Eigen::Vector3d point =
      weights[0] * corners[0] + weights[1] * corners[1] + weights[2] * corners[2];
  return {weights, (x - point).squaredNorm()};
}

ClosestPoint closest_on_edge(const Eigen::Vector3d& x,
                             const std::array<Eigen::Vector3d, 3>& corners, std::size_t a,
                             std::size_t b) {
  const Eigen::Vector3d edge = corners[b] - corners[a];
  const double length = edge.squaredNorm();
  const double along = length > 0.0 ? (x - corners[a]).dot(edge) / length : 0.0;
  Eigen::Vector3d weights = Eigen::Vector3d::Zero();
  weights[b] = std::clamp(along, 0.0, 1.0);
  weights[a] = 1.0 - weights[b];
  return at_weights(x, corners, weights);
}

}  // namespace

ClosestPoint closest_on_triangle(const Eigen::Vector3d& x,
                                 const std::array<Eigen::Vector3d, 3>& corners) {
  // The foot of the perpendicular: the normal equations of x = a + s e + t f.
  const Eigen::Vector3d e = corners[1] - corners[0], f = corners[2] - corners[0];
  const Eigen::Vector3d d = x - corners[0];
  const double ee = e.squaredNorm(), ef = e.dot(f), ff = f.squaredNorm();
  const double determinant = ee * ff - ef * ef;
  if (determinant > 1e-14 * ee * ff) {
    const double s = (ff * e.dot(d) - ef * f.dot(d)) / determinant;
    const double t = (ee * f.dot(d) - ef * e.dot(d)) / determinant;
    if (s >= 0.0 && t >= 0.0 && s + t <= 1.0) return at_weights(x, corners, {1.0 - s - t, s, t});
  }
  ClosestPoint best = closest_on_edge(x, corners, 0, 1);
  for (const ClosestPoint& other :
       {closest_on_edge(x, corners, 1, 2), closest_on_edge(x, corners, 2, 0)})
    if (other.squared_distance < best.squared_distance) best = other;
  return best;
}

}  // namespace tremolo
