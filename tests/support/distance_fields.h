// Distances to simple surfaces, by formula and on a grid.
#pragma once

#include <cmath>
#include <functional>
#include <utility>
#include <vector>

#include "common/distance/distance_grid.h"

namespace tremolo::testing {

using DistanceFormula = std::function<double(const Eigen::Vector3d&)>;

inline DistanceFormula sphere_formula(double radius) {
  return [radius](const Eigen::Vector3d& x) { return x.norm() - radius; };
}

// Around the z axis; ring: distance of the tube's middle from it.
inline DistanceFormula torus_formula(double ring, double tube) {
  return [ring, tube](const Eigen::Vector3d& x) {
    return std::hypot(std::hypot(x.x(), x.y()) - ring, x.z()) - tube;
  };
}

inline DistanceFormula box_formula(const Eigen::Vector3d& half) {
  return [half](const Eigen::Vector3d& x) {
    const Eigen::Vector3d beyond = x.cwiseAbs() - half;
    return beyond.cwiseMax(0.0).norm() + std::min(0.0, beyond.maxCoeff());
  };
}

// `cells` along each side of a cube of the given half side around the origin, a little off it, so
// that nothing falls on nodes by luck.
inline GridNodes cube_of_nodes(double half_side, std::uint32_t cells) {
  const Eigen::Vector3d low =
      Eigen::Vector3d::Constant(-half_side) - half_side * Eigen::Vector3d(0.013, 0.007, 0.0031);
  return {low, 2.0 * half_side / cells, {cells + 1, cells + 1, cells + 1}};
}

inline std::vector<float> values_at_nodes(const GridNodes& nodes, const DistanceFormula& formula) {
  std::vector<float> values;
  values.reserve(nodes.size());
  for (std::size_t k = 0; k < nodes.counts[2]; ++k)
    for (std::size_t j = 0; j < nodes.counts[1]; ++j)
      for (std::size_t i = 0; i < nodes.counts[0]; ++i)
        values.push_back(static_cast<float>(formula(nodes.at(i, j, k))));
  return values;
}

// Throws if the values are refused.
inline DistanceGrid grid_of(const GridNodes& nodes, const DistanceFormula& formula) {
  return std::move(DistanceGrid::create(nodes, values_at_nodes(nodes, formula)).value());
}

}  // namespace tremolo::testing
