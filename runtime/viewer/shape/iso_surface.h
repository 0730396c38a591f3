// The surface of a grid of distances, for the eye.
#pragma once

#include "common/distance/distance_grid.h"
#include "runtime/viewer/shape/triangle_shape.h"

namespace tremolo {

// Where the spline through the grid's values is zero, by marching tetrahedra on its nodes, of large
// grids on every second, third ... so that at most kMostIsoCells are looked at along an axis.
// Vertices lie where the values along an edge are zero on a straight line; normals are the spline's
// gradients. In the frame of the grid, m. Walls thinner than a cell may have holes.
inline constexpr int kMostIsoCells = 96;
TriangleShape iso_surface(const DistanceGrid& grid);

}  // namespace tremolo
