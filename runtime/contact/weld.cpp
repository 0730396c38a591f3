#include "runtime/contact/weld.h"

#include <algorithm>
#include <limits>

#include <Eigen/Eigenvalues>

namespace tremolo {
namespace {

using Eigen::Vector3d;

// A position that is nearer to a point than this fraction of the next one's distance is that point.
constexpr double kSamePlace = 1e-6;
// Directions in which the points extend by less than this fraction are those that they do not span.
constexpr double kFlat = 0.1;
constexpr double kMostWeight = 1.5;  // beyond it a position is far outside of the points

// The numbers of the nearest points, the nearest first.
WeldPlace nearest_points(std::span<const Vector3d> points, const Vector3d& position) {
  WeldPlace place;
  std::array<double, 4> distances;
  distances.fill(std::numeric_limits<double>::infinity());
  for (std::size_t k = 0; k < points.size(); ++k) {
    const double distance = (points[k] - position).squaredNorm();
    if (!(distance < distances.back())) continue;
    std::size_t at = 3;
    for (; at > 0 && distance < distances[at - 1]; --at) {
      distances[at] = distances[at - 1];
      place.points[at] = place.points[at - 1];
    }
    distances[at] = distance;
    place.points[at] = {k, 0.0};
    place.count = std::min<std::size_t>(place.count + 1, 4);
  }
  if (place.count > 1 && distances[0] <= kSamePlace * kSamePlace * distances[1]) place.count = 1;
  return place;
}

}  // namespace

// The weights of least norm that have the sum 1 and, in the directions that the points span, the
// position as their mean.
WeldPlace weld_place(std::span<const Vector3d> points, const Vector3d& position) {
  WeldPlace place = nearest_points(points, position);
  const auto n = static_cast<Eigen::Index>(place.count);
  Eigen::Matrix3Xd arms(3, n);
  for (Eigen::Index k = 0; k < n; ++k)
    arms.col(k) = points[place.points[static_cast<std::size_t>(k)].number];
  const Vector3d mean = arms.rowwise().mean();
  arms.colwise() -= mean;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> spread(arms * arms.transpose());
  Vector3d by_spread = Vector3d::Zero();
  for (int axis = 0; axis < 3; ++axis)
    if (const double size = spread.eigenvalues()[axis];
        size > kFlat * kFlat * spread.eigenvalues()[2]) {
      const Vector3d along = spread.eigenvectors().col(axis);
      by_spread += along.dot(position - mean) / size * along;
    }
  Eigen::VectorXd weights = arms.transpose() * by_spread;
  weights.array() += 1.0 / static_cast<double>(n);
  if (weights.cwiseAbs().maxCoeff() > kMostWeight) {
    place.count = 1;
    weights[0] = 1.0;
  }
  Vector3d there = Vector3d::Zero();
  for (std::size_t k = 0; k < place.count; ++k) {
    place.points[k].weight = weights[static_cast<Eigen::Index>(k)];
    there += place.points[k].weight * points[place.points[k].number];
  }
  place.offset = position - there;
  return place;
}

}  // namespace tremolo
