#include "runtime/bodies/reduced/surface/surface_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "common/mesh/median_split.h"
#include "common/processor.h"

namespace tremolo {
namespace {

using Eigen::Index;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr float kInfinity = std::numeric_limits<float>::infinity();

float below(double x) {
  return std::nextafter(static_cast<float>(x), -kInfinity);
}
float above(double x) {
  return std::nextafter(static_cast<float>(x), kInfinity);
}

// c q and sum_i |q_i| e_i.
struct Bent {
  float x = 0.0F, y = 0.0F, z = 0.0F, spread = 0.0F;
};

TREMOLO_CLONES Bent bend(const float* bounds, const float* q, const float* size,
                         std::size_t modes) {
  const float *cx = bounds, *cy = cx + modes, *cz = cy + modes, *e = cz + modes;
  float x = 0.0F, y = 0.0F, z = 0.0F, spread = 0.0F;
#pragma omp simd reduction(+ : x, y, z, spread)
  for (std::size_t i = 0; i < modes; ++i) {
    x += cx[i] * q[i];
    y += cy[i] * q[i];
    z += cz[i] * q[i];
    spread += e[i] * size[i];
  }
  return {x, y, z, spread};
}

// Distance at which the ray enters the box, 0 if it starts inside; infinity if it misses. A box
// with a coordinate that is not a number counts as hit.
double entry(const Vector3d& low, const Vector3d& high, const Vector3d& origin,
             const Vector3d& direction) {
  double from = 0.0, to = std::numeric_limits<double>::infinity();
  for (Index axis = 0; axis < 3; ++axis) {
    if (direction[axis] == 0.0) {
      if (origin[axis] < low[axis] || origin[axis] > high[axis])
        return std::numeric_limits<double>::infinity();
      continue;
    }
    const double inverse = 1.0 / direction[axis];
    const double a = (low[axis] - origin[axis]) * inverse;
    const double b = (high[axis] - origin[axis]) * inverse;
    if (std::min(a, b) > from) from = std::min(a, b);
    if (std::max(a, b) < to) to = std::max(a, b);
  }
  return from > to ? std::numeric_limits<double>::infinity() : from;
}

// Axes in which a ray runs along the third one, by a shear.
class AlongRay {
 public:
  explicit AlongRay(const Vector3d& direction) {
    direction.cwiseAbs().maxCoeff(&z_);
    x_ = (z_ + 1) % 3;
    y_ = (z_ + 2) % 3;
    length_ = direction[z_];
    shear_x_ = direction[x_] / length_;
    shear_y_ = direction[y_] / length_;
  }

  // A place relative to the ray's origin: across the ray, and along it.
  Vector3d turned(const Vector3d& place) const {
    return {place[x_] - shear_x_ * place[z_], place[y_] - shear_y_ * place[z_],
            place[z_] / length_};
  }

 private:
  Index x_ = 0, y_ = 0, z_ = 0;
  double shear_x_ = 0.0, shear_y_ = 0.0, length_ = 0.0;
};

// Edge functions in the plane across the ray (Woop, Benthin & Wald 2013, "Watertight ray/triangle
// intersection", JCGT 2): the two triangles of an edge see the same numbers, so that no ray slips
// between them. corners: a column each, as AlongRay::turned.
std::optional<SurfaceTree::Hit> meet_corners(std::size_t triangle, const Eigen::Matrix3d& corners,
                                             double most) {
  const auto edge = [&corners](Index a, Index b) {
    return corners(0, a) * corners(1, b) - corners(1, a) * corners(0, b);
  };
  const Vector3d weights(edge(2, 1), edge(0, 2), edge(1, 0));
  if ((weights.array() < 0.0).any() && (weights.array() > 0.0).any()) return std::nullopt;
  const double sum = weights.sum();
  if (sum == 0.0) return std::nullopt;
  const double distance = weights.dot(corners.row(2)) / sum;
  if (!(distance >= 0.0 && distance < most)) return std::nullopt;
  return SurfaceTree::Hit{triangle, weights / sum, distance};
}

}  // namespace

SurfaceTree::SurfaceTree(const std::vector<Vector3d>& rest, const BasisRows& rows,
                         const std::vector<Triangle>& triangles)
    : rest_(rest),
      rows_(rows),
      triangles_(triangles),
      modes_(static_cast<std::size_t>(rows.cols())),
      order_(triangles.size()) {
  std::iota(order_.begin(), order_.end(), std::uint32_t{0});
  for (const auto& [a, b, c] : triangles) middles_.push_back((rest[a] + rest[b] + rest[c]) / 3.0);
  if (!triangles.empty()) build(0, triangles.size());
  middles_ = {};
}

// The node of order_[first, first + count) and all below it. Halves by the longest side: the depth
// is at most 2 + log2 of the triangles.
std::size_t SurfaceTree::build(std::size_t first, std::size_t count) {
  const std::size_t node = nodes_.size();
  nodes_.emplace_back();
  bounds_.resize(nodes_.size() * 4 * modes_);
  if (count <= kLeaf) {
    nodes_[node].first = static_cast<std::uint32_t>(first);
    nodes_[node].count = static_cast<std::uint32_t>(count);
    bound_leaf(node);
    return node;
  }
  const std::size_t half =
      split_at_median(std::span(order_).subspan(first, count),
                      [this](std::uint32_t triangle) { return middles_[triangle]; });
  const std::size_t left = build(first, half);
  const std::size_t right = build(first + half, count - half);
  nodes_[node].first = static_cast<std::uint32_t>(right);
  bound_parent(node, left, right);
  return node;
}

// Computes e from the exact spread, with a margin for sums in float.
void SurfaceTree::round_up(std::size_t node, const VectorXd& spread) {
  const double rounding = 1.2e-7 * static_cast<double>(modes_ + 8);
  float* c = bounds(node);
  for (std::size_t i = 0; i < modes_; ++i) {
    const double size = std::hypot(c[i], c[modes_ + i], c[2 * modes_ + i]);
    const double e = spread[i];
    c[3 * modes_ + i] = above(e + rounding * (size + e));
  }
}

void SurfaceTree::bound_leaf(std::size_t node) {
  const Index r = modes_;
  Eigen::Matrix3Xd low_rows, high_rows;
  Vector3d low = Vector3d::Constant(std::numeric_limits<double>::infinity()), high = -low;
  const auto each_corner = [&](const auto& use) {
    const std::size_t first = nodes_[node].first;
    for (std::size_t k = first; k < first + nodes_[node].count; ++k)
      for (const VertexId corner : triangles_[order_[k]]) use(static_cast<std::size_t>(corner));
  };
  low_rows.setConstant(3, r, std::numeric_limits<double>::infinity());
  high_rows = -low_rows;
  each_corner([&](std::size_t corner) {
    const auto rows = rows_.middleRows<3>(3 * corner);
    low = low.cwiseMin(rest_[corner]);
    high = high.cwiseMax(rest_[corner]);
    low_rows = low_rows.cwiseMin(rows);
    high_rows = high_rows.cwiseMax(rows);
  });
  float* c = bounds(node);
  for (Index axis = 0; axis < 3; ++axis) {
    nodes_[node].low[axis] = below(low[axis]);
    nodes_[node].high[axis] = above(high[axis]);
    for (Index i = 0; i < r; ++i)
      c[axis * r + i] = static_cast<float>(0.5 * (low_rows(axis, i) + high_rows(axis, i)));
  }
  VectorXd spread = VectorXd::Zero(r);
  each_corner([&](std::size_t corner) {
    const auto rows = rows_.middleRows<3>(3 * corner);
    for (Index i = 0; i < r; ++i) {
      const Vector3d middle(c[i], c[r + i], c[2 * r + i]);
      spread[i] = std::max(spread[i], (rows.col(i) - middle).norm());
    }
  });
  round_up(node, spread);
}

void SurfaceTree::bound_parent(std::size_t node, std::size_t left, std::size_t right) {
  const float *a = bounds(left), *b = bounds(right);
  float* c = bounds(node);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    nodes_[node].low[axis] = std::min(nodes_[left].low[axis], nodes_[right].low[axis]);
    nodes_[node].high[axis] = std::max(nodes_[left].high[axis], nodes_[right].high[axis]);
  }
  for (std::size_t k = 0; k < 3 * modes_; ++k) c[k] = 0.5F * (a[k] + b[k]);
  VectorXd spread = VectorXd::Zero(modes_);
  for (std::size_t i = 0; i < modes_; ++i)
    for (const float* child : {a, b}) {
      const Vector3d way(double{child[i]} - c[i], double{child[modes_ + i]} - c[modes_ + i],
                         double{child[2 * modes_ + i]} - c[2 * modes_ + i]);
      double& widest = spread[i];
      widest = std::max(widest, way.norm() + child[3 * modes_ + i]);
    }
  round_up(node, spread);
}

SurfaceTree::Box SurfaceTree::bent_box(std::size_t node, const float* q, const float* size) const {
  const Bent bent = bend(bounds(node), q, size, modes_);
  const Node& at = nodes_[node];
  const Vector3d low(at.low[0], at.low[1], at.low[2]), high(at.high[0], at.high[1], at.high[2]);
  const Vector3d shift(bent.x, bent.y, bent.z);
  // A small margin for the rounding of positions.
  const double wider =
      1.00001 * bent.spread + 1e-12 * (low.norm() + high.norm() + shift.norm()) + 1e-300;
  return {low + shift - Vector3d::Constant(wider), high + shift + Vector3d::Constant(wider)};
}

std::optional<SurfaceTree::Hit> SurfaceTree::meet(std::size_t triangle, const Vector3d& origin,
                                                  const Vector3d& direction, const VectorXd& q,
                                                  double most) const {
  const AlongRay along(direction);
  Eigen::Matrix3d corners;
  for (Index k = 0; k < 3; ++k) {
    const std::size_t vertex = triangles_[triangle][k];
    Vector3d place = rest_[vertex] - origin;
    for (Index axis = 0; axis < 3; ++axis)
      place[axis] += rows_.row(static_cast<Index>(3 * vertex) + axis).dot(q);
    corners.col(k) = along.turned(place);
  }
  return meet_corners(triangle, corners, most);
}

std::optional<SurfaceTree::Hit> SurfaceTree::nearest(const Vector3d& origin,
                                                     const Vector3d& direction,
                                                     const VectorXd& q) const {
  if (nodes_.empty() || !origin.allFinite() || !direction.allFinite() || !q.allFinite())
    return std::nullopt;
  // q and |q|.
  std::array<float, 2 * kMostModes> room;
  std::vector<float> more;
  float* coordinates = room.data();
  if (modes_ > kMostModes) {
    more.resize(2 * modes_);
    coordinates = more.data();
  }
  float* size = coordinates + modes_;
  for (std::size_t i = 0; i < modes_; ++i) {
    coordinates[i] = static_cast<float>(q[i]);
    size[i] = std::abs(coordinates[i]);
  }
  struct Waiting {
    std::size_t node;
    double distance;
  };
  std::array<Waiting, 80> stack;
  std::size_t waiting = 0;
  const auto distance_to = [&](std::size_t node) {
    const Box box = bent_box(node, coordinates, size);
    return entry(box.low, box.high, origin, direction);
  };
  std::optional<Hit> best;
  double most = std::numeric_limits<double>::infinity();
  if (const double root = distance_to(0); root < most) stack[waiting++] = {0, root};
  while (waiting > 0) {
    const auto [node, distance] = stack[--waiting];
    if (distance > most) continue;
    const Node& at = nodes_[node];
    for (std::size_t k = at.first; k < std::size_t{at.first} + at.count; ++k)
      if (const auto hit = meet(order_[k], origin, direction, q, most)) {
        best = hit;
        most = hit->distance;
      }
    if (at.count != 0) continue;
    Waiting near{node + 1, distance_to(node + 1)}, far{at.first, distance_to(at.first)};
    if (far.distance < near.distance) std::swap(near, far);
    if (far.distance < most) stack[waiting++] = far;
    if (near.distance < most) stack[waiting++] = near;
  }
  return best;
}

std::optional<SurfaceTree::Hit> nearest_of_all(const std::vector<Triangle>& triangles,
                                               std::span<const double> places,
                                               const Vector3d& origin, const Vector3d& direction) {
  const AlongRay along(direction);
  std::optional<SurfaceTree::Hit> best;
  double most = std::numeric_limits<double>::infinity();
  Eigen::Matrix3d corners;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (Index k = 0; k < 3; ++k) {
      const double* place = places.data() + 3 * static_cast<std::size_t>(triangles[t][k]);
      corners.col(k) = along.turned(Eigen::Map<const Vector3d>(place) - origin);
    }
    if (const auto hit = meet_corners(t, corners, most)) {
      best = hit;
      most = hit->distance;
    }
  }
  return best;
}

}  // namespace tremolo
