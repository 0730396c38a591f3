// The requested edge length over a solid: coarse inside, finer where walls are thin.
#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>

#include "common/mesh/surface_mesh.h"
#include "precompute/mesher/surface/surface_geometry.h"

namespace tremolo {

// A point of the surface and the thickness of the solid behind it. area: the part of the surface
// that the sample represents.
struct WallSample {
  Eigen::Vector3d point;
  double thickness = 0;
  double area = 0;
};

// True if a point is in the solid.
using Inside = std::function<bool(const Eigen::Vector3d&)>;

// About `count` samples distributed by area; samples without a wall behind them are left out.
// `inside` distinguishes walls of the solid from triangles within it; none: the surface is closed
// and has no others. The same surface gives the same samples.
std::vector<WallSample> wall_samples(const SurfaceMesh& surface, const TriangleTree& tree,
                                     const Inside& inside, std::size_t count);

// Wanted edge length on a grid, trilinear between its nodes: at most `coarse`, at a wall the wall's
// thickness but not below `fine`, and growing by half of the distance from there.
class SizeField {
 public:
  SizeField(const BoundingBox& box, const std::vector<WallSample>& walls, double coarse,
            double fine);
  double at(const Eigen::Vector3d& x) const;
  double coarsest() const { return coarse_; }

 private:
  std::size_t index(const Eigen::Vector3i& node) const {
    const auto at = [](int i) -> std::size_t { return i; };
    return (at(node[2]) * at(count_[1]) + at(node[1])) * at(count_[0]) + at(node[0]);
  }

  Eigen::Vector3d low_;
  double step_ = 0;
  double coarse_ = 0;
  Eigen::Vector3i count_;
  std::vector<float> values_;  // x fastest
};

// The uniform edge length with which a compact solid of that volume becomes so many tetrahedra.
double size_for_count(double volume, double count);

// Tetrahedra that a solid of that volume would be cut into, to a factor of two or so.
double estimated_count(const std::vector<WallSample>& walls, double volume, double coarse,
                       double fine);

}  // namespace tremolo
