// Nearest points and ray intersections of a set of triangles, by CGAL's AABB tree.
#pragma once

#include <cstddef>
#include <memory>

#include <Eigen/Core>

#include "common/mesh/surface_mesh.h"

namespace tremolo {

struct NearestPoint {
  Eigen::Vector3d point;  // on the triangle
  std::size_t triangle = 0;
  double distance = 0;
};

struct Hit {
  double distance = 0;
  std::size_t triangle = 0;
};

// Copies the triangles, of which none may be degenerate. Queries may run in
// several threads.
class TriangleTree {
 public:
  explicit TriangleTree(const SurfaceMesh& surface);
  ~TriangleTree();
  TriangleTree(TriangleTree&&) noexcept;
  TriangleTree& operator=(TriangleTree&&) noexcept;

  // The tree must not be empty.
  NearestPoint nearest(const Eigen::Vector3d& x) const;
  // The first hit of the ray from `x` along `direction` (a unit vector), without the triangle
  // `skipped`; at infinity if there is none.
  Hit first_hit(const Eigen::Vector3d& x, const Eigen::Vector3d& direction,
                std::size_t skipped) const;

 private:
  struct Contents;
  std::unique_ptr<Contents> contents_;
};

}  // namespace tremolo
