// Corners, areas, volumes, spread points and distances of triangulated surfaces.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <random>

#include <Eigen/Core>

#include "common/mesh/surface_mesh.h"

namespace tremolo {

// Nearest points and ray intersections of a set of triangles, by CGAL's AABB tree.

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

inline std::array<Eigen::Vector3d, 3> corners(const SurfaceMesh& surface, const Triangle& t) {
  const auto at = [&surface](VertexId v) { return surface.vertices[v]; };
  return {at(t[0]), at(t[1]), at(t[2])};
}

// Twice the area of a triangle times its normal.
Eigen::Vector3d doubled_area(const SurfaceMesh& surface, const Triangle& triangle);

// Areas of all triangles together.
double area(const SurfaceMesh& surface);

// Signed volume between a triangle and the origin; over a closed surface they sum to its volume.
double volume_below(const SurfaceMesh& surface, const Triangle& triangle);

// Draws a point of a triangle, each with the same likelihood.
Eigen::Vector3d random_point(const SurfaceMesh& surface, const Triangle& triangle,
                             std::mt19937_64& random);

// A point of a surface, and the unit normal of its triangle.
struct SurfacePoint {
  Eigen::Vector3d point;
  Eigen::Vector3d normal;
  std::size_t triangle = 0;
};

// Random points, uniform by area; the same surface gives the same points. CGAL's
// sample_triangle_soup() does not return the triangle of a point.
std::vector<SurfacePoint> spread_points(const SurfaceMesh& surface, std::size_t count);

// The largest distance from a point of `from` to the triangles in `to` (the one-sided Hausdorff
// distance), over all vertices and about `samples` points spread by area: a lower bound that
// misses at most the distance between neighbouring samples.
double distance_from(const SurfaceMesh& from, const TriangleTree& to, std::size_t samples);

}  // namespace tremolo
