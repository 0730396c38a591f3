#include "common/mesh/surface_mesh.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include <Eigen/Geometry>

#include "common/mesh/tet_faces.h"

namespace tremolo {

BoundarySurface boundary_surface(const TetMesh& mesh) {
  std::vector<std::size_t> outer;
  for_each_face(mesh, [&](std::span<const std::size_t> sides) {
    if (sides.size() == 1) outer.push_back(sides.front());
  });
  std::sort(outer.begin(), outer.end());

  BoundarySurface surface;
  std::vector<VertexId> position(mesh.vertices.size(), -1);
  const auto face = [&](std::size_t side) { return tet_face(mesh.tetrahedra[side / 4], side % 4); };
  for (std::size_t side : outer)
    for (VertexId id : face(side)) position[id] = 0;
  for (std::size_t id = 0; id < position.size(); ++id) {
    if (position[id] < 0) continue;
    position[id] = static_cast<VertexId>(surface.vertex_ids.size());
    surface.vertex_ids.push_back(static_cast<VertexId>(id));
  }
  for (std::size_t side : outer) {
    const auto [a, b, c] = face(side);
    surface.triangles.push_back({position[a], position[b], position[c]});
  }
  return surface;
}

SurfaceMesh boundary_mesh(const TetMesh& mesh) {
  BoundarySurface boundary = boundary_surface(mesh);
  SurfaceMesh surface;
  for (const VertexId id : boundary.vertex_ids) surface.vertices.push_back(mesh.vertices[id]);
  surface.triangles = std::move(boundary.triangles);
  return surface;
}

std::vector<double> area_shares(std::span<const VertexId> chosen,
                                std::span<const VertexId> vertex_ids,
                                std::span<const Triangle> triangles,
                                std::span<const Eigen::Vector3d> rest) {
  std::vector<double> area(vertex_ids.size(), 0.0);
  std::vector<bool> is_chosen(vertex_ids.size(), false);
  const auto row_of = [&](VertexId id) {
    return std::lower_bound(vertex_ids.begin(), vertex_ids.end(), id) - vertex_ids.begin();
  };
  const auto is_there = [&](std::ptrdiff_t row, VertexId id) {
    return static_cast<std::size_t>(row) < vertex_ids.size() && vertex_ids[row] == id;
  };
  for (const VertexId id : chosen)
    if (const std::ptrdiff_t row = row_of(id); is_there(row, id)) is_chosen[row] = true;
  double total = 0.0;
  for (const Triangle& t : triangles) {
    if (!is_chosen[t[0]] || !is_chosen[t[1]] || !is_chosen[t[2]]) continue;
    const double twice = (rest[t[1]] - rest[t[0]]).cross(rest[t[2]] - rest[t[0]]).norm();
    for (const VertexId corner : t) area[corner] += twice / 6.0;
    total += twice / 2.0;
  }
  std::vector<double> shares(chosen.size(), 1.0 / static_cast<double>(chosen.size()));
  if (!(total > 0.0)) return shares;
  for (std::size_t n = 0; n < chosen.size(); ++n) {
    const std::ptrdiff_t row = row_of(chosen[n]);
    shares[n] = is_there(row, chosen[n]) ? area[row] / total : 0.0;
  }
  return shares;
}

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Twice the area that the polygon encloses, along its normal (Newell).
Vector3d area_vector(std::span<const Vector3d> corners) {
  Vector3d sum = Vector3d::Zero();
  for (std::size_t i = 1; i + 1 < corners.size(); ++i)
    sum += (corners[i] - corners[0]).cross(corners[i + 1] - corners[0]);
  return sum;
}

double cross(const Vector2d& a, const Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

// The corners seen against the normal: counter-clockwise.
std::vector<Vector2d> in_plane(std::span<const Vector3d> corners, const Vector3d& normal) {
  const Vector3d u = normal.unitOrthogonal();
  const Vector3d v = normal.cross(u);
  std::vector<Vector2d> points;
  points.reserve(corners.size());
  for (const Vector3d& x : corners)
    points.emplace_back(u.dot(x - corners[0]), v.dot(x - corners[0]));
  return points;
}

// The polygon that is left, as a ring of its corners.
class Ring {
 public:
  explicit Ring(std::vector<Vector2d> points) : points_(std::move(points)), left_(points_.size()) {
    double size = 0.0;
    for (const Vector2d& x : points_) size = std::max(size, x.norm());
    least_ = 1e-14 * size * size;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      next_.push_back((i + 1) % points_.size());
      before_.push_back((i + points_.size() - 1) % points_.size());
    }
    for (std::size_t i = 0; i < points_.size(); ++i)
      if (turn(i) <= least_) bent_.push_back(i);
  }

  // True if every corner turns left, with one full rotation in all.
  bool convex() const {
    if (!bent_.empty()) return false;
    double angle = 0.0;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const Vector2d in = points_[i] - points_[before_[i]], out = points_[next_[i]] - points_[i];
      angle += std::atan2(cross(in, out), in.dot(out));
    }
    return angle < 7.0;  // 2 pi, and 4 pi of the next one that closes
  }

  std::size_t left() const { return left_; }
  std::size_t next(std::size_t i) const { return next_[i]; }
  std::array<std::size_t, 3> triangle(std::size_t i) const { return {before_[i], i, next_[i]}; }

  // True if the triangle at corner i is inside the polygon: no part of the outline reaches into it.
  bool is_ear(std::size_t i) const {
    if (turn(i) <= least_) return false;
    const Vector2d &a = points_[before_[i]], &b = points_[i], &c = points_[next_[i]];
    return std::none_of(bent_.begin(), bent_.end(), [&](std::size_t k) {
      const Vector2d& x = points_[k];
      if (x == a || x == b || x == c) return false;
      return cross(b - a, x - a) >= -least_ && cross(c - b, x - b) >= -least_ &&
             cross(a - c, x - c) >= -least_;
    });
  }

  void remove(std::size_t i) {
    const std::size_t a = before_[i], c = next_[i];
    next_[a] = c;
    before_[c] = a;
    --left_;
    // Cutting an ear can only make the corners next to it more convex.
    std::erase_if(
        bent_, [&](std::size_t k) { return k == i || ((k == a || k == c) && turn(k) > least_); });
  }

 private:
  double turn(std::size_t i) const {
    const Vector2d& b = points_[i];
    return cross(b - points_[before_[i]], points_[next_[i]] - b);
  }

  std::vector<Vector2d> points_;
  std::vector<std::size_t> next_, before_;
  std::vector<std::size_t> bent_;  // corners that do not turn left
  std::size_t left_ = 0;
  double least_ = 0.0;  // twice an area that counts as none
};

}  // namespace

void cut_polygon(std::span<const Vector3d> corners,
                 std::vector<std::array<std::size_t, 3>>& triangles) {
  const std::size_t n = corners.size();
  const auto add_fan = [&] {
    for (std::size_t k = 1; k + 1 < n; ++k) triangles.push_back({0, k, k + 1});
  };
  if (n <= 3) return add_fan();
  const Vector3d normal = area_vector(corners).stableNormalized();
  if (!normal.allFinite() || normal.norm() < 0.5) return add_fan();
  Ring ring(in_plane(corners, normal));
  if (ring.convex()) return add_fan();
  std::size_t at = 0, tried = 0;
  while (ring.left() > 3 && tried < ring.left()) {
    if (ring.is_ear(at)) {
      triangles.push_back(ring.triangle(at));
      ring.remove(at);
      tried = 0;
      // Behind the next corner, so that not all triangles meet in one.
      at = ring.next(ring.next(at));
    } else {
      at = ring.next(at);
      ++tried;
    }
  }
  // The last triangle, or a polygon without ears, becomes a fan.
  while (ring.left() >= 3) {
    const std::size_t i = ring.next(at);
    triangles.push_back(ring.triangle(i));
    ring.remove(i);
  }
}

}  // namespace tremolo
