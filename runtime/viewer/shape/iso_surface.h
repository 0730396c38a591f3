// The surface of a grid of distances, for display.
#pragma once

#include "common/distance/distance_grid.h"
#include "runtime/viewer/shape/triangle_shape.h"

namespace tremolo {

// The zero surface of the grid's spline, by marching tetrahedra on its nodes; on large grids on
// every second, third ... node, so that at most kMostIsoCells cells are sampled along an axis.
// Vertices are where the linear interpolant along an edge is zero; normals are the spline's
// gradients. In the frame of the grid, m. Walls thinner than a cell may have holes.
inline constexpr int kMostIsoCells = 96;
TriangleShape iso_surface(const DistanceGrid& grid);

}  // namespace tremolo
