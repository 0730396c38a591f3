// The points of a surface that are closest to places of the mesh.
#pragma once

#include <array>
#include <vector>

#include "common/mesh/render_surface.h"
#include "precompute/embedding/box_tree.h"

namespace tremolo {

// The point of the surface that is closest to a place. weights: of the triangle's corners.
struct SurfaceContact {
  std::size_t triangle = 0;
  Eigen::Vector3d weights = Eigen::Vector3d::Zero();
};

std::array<Eigen::Vector3d, 3> corners_of(const RenderSurface& surface, std::size_t triangle);

// Refers to the surface, which must have triangles.
class SurfaceContacts {
 public:
  explicit SurfaceContacts(const RenderSurface& surface);
  SurfaceContact at(const Eigen::Vector3d& x) const;

 private:
  const RenderSurface& surface_;
  BoxTree tree_;
};

}  // namespace tremolo
