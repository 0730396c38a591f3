// The point of a triangle that is closest to a given one.
#pragma once

#include <array>

#include <Eigen/Core>

namespace tremolo {

// weights: of the three corners, at least 0, their sum 1. squared_distance: m^2.
struct ClosestPoint {
  Eigen::Vector3d weights;
  double squared_distance;
};

// A triangle without area is the segment or the point that it is.
ClosestPoint closest_on_triangle(const Eigen::Vector3d& x,
                                 const std::array<Eigen::Vector3d, 3>& corners);

}  // namespace tremolo
