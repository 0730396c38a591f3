#include "runtime/bodies/reduced/bones/bone_weights.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "common/text.h"

namespace tremolo {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

double smooth_share(double x) {
  x = std::clamp(x, 0.0, 1.0);
  return x * x * (3.0 - 2.0 * x);
}

}  // namespace

std::string weights_problem(const BoneWeights& weights) {
  for (Index row = 0; row < weights.rows(); ++row) {
    const auto of_row = weights.row(row);
    const std::string where = "row " + std::to_string(row + 1) + ": ";
    if (!of_row.allFinite()) return where + "a weight is not finite";
    if (of_row.minCoeff() < 0.0)
      return where + "a weight is " + number_text(of_row.minCoeff()) + ", must not be negative";
    if (!(std::abs(of_row.sum() - 1.0) <= kWeightSlack))
      return where + "the weights sum to " + number_text(of_row.sum()) + ", must sum to 1";
  }
  return {};
}

double BoneSegment::distance(const Vector3d& x) const {
  const Vector3d along = tail - head;
  const double length2 = along.squaredNorm();
  const double share = length2 > 0.0 ? std::clamp((x - head).dot(along) / length2, 0.0, 1.0) : 0.0;
  return (x - head - share * along).norm();
}

BoneWeights weights_near(std::span<const Vector3d> points, std::span<const BoneSegment> bones,
                         double blend) {
  BoneWeights weights(std::ssize(points), std::ssize(bones));
  for (std::size_t p = 0; p < points.size(); ++p) {
    auto row = weights.row(p);
    for (std::size_t b = 0; b < bones.size(); ++b) row[b] = bones[b].distance(points[p]);
    const double nearest = row.minCoeff();
    for (double& weight : row) weight = smooth_share(1.0 - (weight - nearest) / blend);
    row /= row.sum();
  }
  return weights;
}

// The search starts at the point's index in the order of x and goes outwards, until x alone is too
// far.
BoneWeights weights_of_nearest(std::span<const Vector3d> points, std::span<const Vector3d> known,
                               const BoneWeights& weights) {
  std::vector<std::size_t> order(known.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return known[a].x() < known[b].x(); });
  BoneWeights found(std::ssize(points), weights.cols());
  for (std::size_t p = 0; p < points.size(); ++p) {
    const Vector3d& x = points[p];
    const auto from = std::partition_point(order.begin(), order.end(),
                                           [&](std::size_t k) { return known[k].x() < x.x(); });
    double least = std::numeric_limits<double>::infinity();
    std::size_t best = order.front();
    // False once all further points are farther away.
    const auto look = [&](std::size_t k) {
      const double by_x = known[k].x() - x.x();
      if (by_x * by_x > least) return false;
      const double far = (known[k] - x).squaredNorm();
      if (far < least || (far == least && k < best)) {
        least = far;
        best = k;
      }
      return true;
    };
    for (auto k = from; k != order.end() && look(*k); ++k) {
    }
    for (auto k = from; k != order.begin() && look(*(k - 1)); --k) {
    }
    found.row(p) = weights.row(best);
  }
  return found;
}

}  // namespace tremolo
