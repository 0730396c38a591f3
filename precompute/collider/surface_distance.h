// The exact signed distance of points to a closed surface.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "common/mesh/winding_number.h"
#include "precompute/collider/closed_surface.h"
#include "precompute/embedding/box_tree.h"

namespace tremolo {

// The distance is that to the nearest triangle; the sign is that of the winding number minus one
// half, which no crossing of triangles confuses. Safe to use from several threads.
class SurfaceDistance {
 public:
  // Copies the data that it needs.
  explicit SurfaceDistance(const ClosedSurface& closed);

  // m, not negative.
  double magnitude(const Eigen::Vector3d& x) const;
  bool is_inside(const Eigen::Vector3d& x) const { return winding_.at(x) > 0.5; }
  // m, negative inside.
  double at(const Eigen::Vector3d& x) const;

  // The triangles that bound the solid.
  std::size_t triangle_count() const { return facets_.size(); }
  const std::array<Eigen::Vector3d, 3>& corners(std::size_t triangle) const {
    return facets_[triangle].corners;
  }

 private:
  // normal: of length 1, or zero. offset: the plane is normal . x = offset.
  struct Facet {
    std::array<Eigen::Vector3d, 3> corners;
    Eigen::Vector3d normal;
    double offset;
  };
  static std::vector<Facet> facets_of(const ClosedSurface& closed);

  std::vector<Facet> facets_;
  BoxTree tree_;
  WindingNumber winding_;
};

}  // namespace tremolo
