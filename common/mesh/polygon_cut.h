// Polygons in space -> triangles.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace tremolo {

// Appends the n - 2 triangles of a polygon of n corners, each as three indices into `corners`; none
// for fewer than three corners. A convex polygon becomes a fan from its first corner. Other
// polygons are divided at ears in the plane of their mean normal, so that the triangles cover the
// region inside; one that crosses itself or has no area is divided as far as it has ears, and then
// as a fan.
void cut_polygon(std::span<const Eigen::Vector3d> corners,
                 std::vector<std::array<std::size_t, 3>>& triangles);

}  // namespace tremolo
