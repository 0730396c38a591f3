#include "runtime/io/exchange/morph_targets.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Geometry>

namespace tremolo {
namespace {

using Eigen::Index;
using Eigen::Map;
using Eigen::Matrix3Xd;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

// Below this ratio of a normal's length to that at rest, the first order has no useful direction;
// the vertex keeps the normal of the rest shape.
constexpr double kShortNormal = 1e-3;

std::size_t group(const AnimatedShape& shape, VertexId vertex) {
  const std::size_t v = vertex;
  return shape.smooth_groups.empty() ? v : shape.smooth_groups[v];
}

// Gives each vertex the sum of its group.
void spread(const AnimatedShape& shape, Matrix3Xd& sums) {
  if (shape.smooth_groups.empty()) return;
  const Matrix3Xd of_groups = sums;
  for (Index v = 0; v < sums.cols(); ++v)
    sums.col(v) = of_groups.col(group(shape, static_cast<VertexId>(v)));
}

// Sums of (b - a) x (c - a) over the triangles of each vertex; x: 3 x s.
Matrix3Xd area_normals(const AnimatedShape& shape, const Matrix3Xd& x) {
  Matrix3Xd sums = Matrix3Xd::Zero(3, x.cols());
  for (const Triangle& t : shape.surface.triangles) {
    const Vector3d a = x.col(t[1]) - x.col(t[0]), b = x.col(t[2]) - x.col(t[0]);
    for (const VertexId corner : t) sums.col(group(shape, corner)) += a.cross(b);
  }
  spread(shape, sums);
  return sums;
}

// Derivatives of the normals along u, 3 x s, at x.
Matrix3Xd normal_rates(const AnimatedShape& shape, const Matrix3Xd& x, const Matrix3Xd& u) {
  Matrix3Xd sums = Matrix3Xd::Zero(3, x.cols());
  for (const Triangle& t : shape.surface.triangles) {
    const Vector3d a = x.col(t[1]) - x.col(t[0]), b = x.col(t[2]) - x.col(t[0]);
    const Vector3d da = u.col(t[1]) - u.col(t[0]), db = u.col(t[2]) - u.col(t[0]);
    const Vector3d rate = da.cross(b) + a.cross(db);
    for (const VertexId corner : t) sums.col(group(shape, corner)) += rate;
  }
  spread(shape, sums);
  return sums;
}

Matrix3Xd rest_of(const AnimatedShape& shape) {
  const std::vector<Vector3d>& rest = shape.surface.vertices;
  return Map<const Matrix3Xd>(rest[0].data(), 3, static_cast<Index>(rest.size()));
}

Matrix3Xd mode_of(const AnimatedShape& shape, Index coordinate) {
  const VectorXd column = shape.modes.col(coordinate);
  return Map<const Matrix3Xd>(column.data(), 3, column.size() / 3);
}

// Divides all vertices by the length of the base's normals, so that these become unit vectors.
void fill_normals(const AnimatedShape& shape, const TargetRanges& ranges, Eigen::MatrixXf& out) {
  const Matrix3Xd rest = rest_of(shape);
  Matrix3Xd base = area_normals(shape, rest);
  const Eigen::RowVectorXd length = base.colwise().norm();
  for (Index i = 0; i < ranges.low.size(); ++i)
    if (ranges.low[i] != 0.0) base += ranges.low[i] * normal_rates(shape, rest, mode_of(shape, i));
  const Matrix3Xd at_rest = area_normals(shape, rest);
  Eigen::RowVectorXd factor = Eigen::RowVectorXd::Zero(base.cols());
  for (Index v = 0; v < base.cols(); ++v) {
    const double now = base.col(v).norm();
    if (length[v] > 0.0 && now > kShortNormal * length[v]) {
      factor[v] = 1.0 / now;
      base.col(v) *= factor[v];
    } else {
      base.col(v) = length[v] > 0.0 ? Vector3d(at_rest.col(v) / length[v]) : Vector3d::UnitZ();
    }
  }
  out.resize(3 * base.cols(), static_cast<Index>(ranges.targets.size()) + 1);
  out.col(0) = Map<const VectorXd>(base.data(), base.size()).cast<float>();
  for (std::size_t k = 0; k < ranges.targets.size(); ++k) {
    const TargetRange& range = ranges.targets[k];
    const Matrix3Xd rate = normal_rates(shape, rest, mode_of(shape, range.coordinate));
    const Matrix3Xd delta = rate * (range.width * factor).asDiagonal();
    out.col(static_cast<Index>(k) + 1) =
        Map<const VectorXd>(delta.data(), delta.size()).cast<float>();
  }
}

double degrees_between(const Vector3d& a, const Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) * 180.0 / std::numbers::pi;
}

// One frame of one body.
struct FrameError {
  double position = 0.0;
  double normal_sum = 0.0;
  double normal_max = 0.0;
  std::size_t normals = 0;
};

// further: weights of the normals' columns behind those of the ranges.
FrameError frame_error(const AnimatedShape& shape, const VectorXd& q, const TargetRanges& ranges,
                       const MorphTargets& targets, const Eigen::VectorXf& further) {
  FrameError error;
  std::vector<float> weights = target_weights(q, ranges);
  weights.insert(weights.end(), further.begin(), further.end());
  const auto evaluated = [&weights](const Eigen::MatrixXf& columns) {
    const Map<const Eigen::VectorXf> w(weights.data(), columns.cols() - 1);
    const Eigen::VectorXf sum = columns.col(0) + columns.rightCols(w.size()) * w;
    return Matrix3Xd(Map<const Eigen::Matrix3Xf>(sum.data(), 3, sum.size() / 3).cast<double>());
  };
  Matrix3Xd exact = rest_of(shape);
  if (q.size() > 0) {
    const VectorXd moved = shape.modes * q;
    exact += Map<const Matrix3Xd>(moved.data(), 3, moved.size() / 3);
  }
  error.position = (evaluated(targets.positions) - exact).colwise().norm().maxCoeff();
  if (targets.normals.cols() == 0) return error;
  const Matrix3Xd bent = area_normals(shape, exact), shown = evaluated(targets.normals);
  for (Index v = 0; v < bent.cols(); ++v) {
    if (bent.col(v).isZero(0.0)) continue;
    const double angle = degrees_between(bent.col(v), shown.col(v));
    error.normal_sum += angle;
    error.normal_max = std::max(error.normal_max, angle);
    ++error.normals;
  }
  return error;
}

}  // namespace

std::vector<Vector3d> smooth_normals(const AnimatedShape& shape,
                                     const std::vector<Vector3d>& places) {
  const Matrix3Xd sums = area_normals(
      shape, Map<const Matrix3Xd>(places[0].data(), 3, static_cast<Index>(places.size())));
  std::vector<Vector3d> normals;
  for (Index v = 0; v < sums.cols(); ++v) normals.emplace_back(sums.col(v).normalized());
  return normals;
}

TargetRanges target_ranges(const Animation& animation, std::size_t shape, bool plain) {
  const Index r = animation.shapes[shape].modes.cols();
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  VectorXd low = VectorXd::Constant(r, kInfinite), high = VectorXd::Constant(r, -kInfinite);
  for (const AnimatedBody& body : animation.bodies) {
    if (body.shape != shape) continue;
    for (std::size_t frame = 0; frame < animation.frames(); ++frame) {
      const auto q = coordinates_at(animation, body, frame);
      low = low.cwiseMin(q);
      high = high.cwiseMax(q);
    }
  }
  TargetRanges ranges;
  ranges.low = VectorXd::Zero(r);
  for (Index i = 0; i < r; ++i) {
    if (!(low[i] <= high[i])) continue;  // a shape that no body has
    if (plain) {
      if (low[i] != 0.0 || high[i] != 0.0) ranges.targets.push_back({i, 0.0, 1.0});
      continue;
    }
    ranges.low[i] = low[i];
    if (high[i] > low[i]) ranges.targets.push_back({i, low[i], high[i] - low[i]});
  }
  return ranges;
}

MorphTargets morph_targets(const AnimatedShape& shape, const TargetRanges& ranges, bool normals) {
  MorphTargets targets;
  const Matrix3Xd rest = rest_of(shape);
  VectorXd base = Map<const VectorXd>(rest.data(), rest.size());
  if (ranges.low.size() > 0) base += shape.modes * ranges.low;
  targets.positions.resize(base.size(), static_cast<Index>(ranges.targets.size()) + 1);
  targets.positions.col(0) = base.cast<float>();
  for (std::size_t k = 0; k < ranges.targets.size(); ++k)
    targets.positions.col(static_cast<Index>(k) + 1) =
        (ranges.targets[k].width * shape.modes.col(ranges.targets[k].coordinate)).cast<float>();
  if (normals) fill_normals(shape, ranges, targets.normals);
  return targets;
}

std::vector<float> target_weights(const VectorXd& q, const TargetRanges& ranges) {
  std::vector<float> weights;
  weights.reserve(ranges.targets.size());
  for (const TargetRange& range : ranges.targets)
    weights.push_back(static_cast<float>((q[range.coordinate] - range.low) / range.width));
  return weights;
}

MorphError morph_error(const Animation& animation, std::size_t shape, const TargetRanges& ranges,
                       const MorphTargets& targets, std::span<const Eigen::MatrixXf> further) {
  constexpr std::size_t kFrames = 64;
  MorphError error;
  FrameError all;
  const std::size_t looks = std::min(kFrames, animation.frames());
  for (std::size_t b = 0; b < animation.bodies.size(); ++b) {
    const AnimatedBody& body = animation.bodies[b];
    if (body.shape != shape) continue;
    for (std::size_t k = 0; k < looks; ++k) {
      const std::size_t frame = looks < 2 ? 0 : k * (animation.frames() - 1) / (looks - 1);
      const Eigen::VectorXf more = further.empty() || further[b].size() == 0
                                       ? Eigen::VectorXf()
                                       : Eigen::VectorXf(further[b].col(static_cast<Index>(frame)));
      const FrameError one = frame_error(
          animation.shapes[shape], coordinates_at(animation, body, frame), ranges, targets, more);
      all.position = std::max(all.position, one.position);
      all.normal_max = std::max(all.normal_max, one.normal_max);
      all.normal_sum += one.normal_sum;
      all.normals += one.normals;
    }
  }
  const double size = largest_extent(animation.shapes[shape]);
  error.position = size > 0.0 ? all.position / size : 0.0;
  error.normal_max = all.normal_max;
  if (all.normals > 0) error.normal_mean = all.normal_sum / static_cast<double>(all.normals);
  return error;
}

}  // namespace tremolo
