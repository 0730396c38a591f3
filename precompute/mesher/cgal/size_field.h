// How finely a solid is cut: coarse inside, finer where walls are thin.
#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>

#include "common/mesh/surface_mesh.h"
#include "precompute/mesher/surface/triangle_tree.h"

namespace tremolo {

// A point of the surface and how thick the solid is behind it. area: what the sample stands for.
struct WallSample {
  Eigen::Vector3d point;
  double thickness = 0;
  double area = 0;
};

// Whether a point lies in the solid.
using Inside = std::function<bool(const Eigen::Vector3d&)>;

// About `count` samples spread by area; those behind which no wall is found are left out. `inside`
// tells walls of the solid from triangles within it; none: the surface is closed and has no others.
// The same surface gives the same samples.
std::vector<WallSample> wall_samples(const SurfaceMesh& surface, const TriangleTree& tree,
                                     const Inside& inside, std::size_t count);

// Wanted edge length: at most `coarse`, at a wall its thickness but not below `fine`, growing by a
// half of the way from there.
class SizeField {
 public:
  SizeField(const BoundingBox& box, const std::vector<WallSample>& walls, double coarse,
            double fine);
  double at(const Eigen::Vector3d& x) const;
  double coarsest() const { return coarse_; }

 private:
  Eigen::Vector3d low_;
  double step_ = 0;
  double coarse_ = 0;
  Eigen::Vector3i count_;
  std::vector<float> values_;  // x fastest
};

// The size everywhere with which a compact solid of that volume becomes so many tetrahedra.
double size_for_count(double volume, double count);

// Tetrahedra that a solid of that volume would be cut into, to a factor of two or so.
double estimated_count(const std::vector<WallSample>& walls, double volume, double coarse,
                       double fine);

}  // namespace tremolo
