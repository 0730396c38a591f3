// Shapes as triangles: colliders, and the surface where a distance is zero.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "common/distance/distance_grid.h"
#include "common/result.h"
#include "runtime/contact/collider.h"

namespace tremolo {

// Triangles that are drawn as they are: colliders, the ground, hands. positions, m, and unit
// normals: one per vertex. triangles: three indices each, counter-clockwise seen from outside.
struct TriangleShape {
  std::vector<Eigen::Vector3f> positions;
  std::vector<Eigen::Vector3f> normals;
  std::vector<std::uint32_t> triangles;

  std::uint32_t add(const Eigen::Vector3d& position, const Eigen::Vector3d& normal) {
    positions.push_back(position.cast<float>());
    normals.push_back(normal.cast<float>());
    return static_cast<std::uint32_t>(positions.size() - 1);
  }
  void add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    triangles.insert(triangles.end(), {a, b, c});
  }
};

// The surface of a grid of distances, for display. The zero surface of the grid's spline, by
// marching tetrahedra on its nodes; on large grids on every second, third ... node, so that at most
// kMostIsoCells cells are sampled along an axis. Vertices are where the linear interpolant along an
// edge is zero; normals are the spline's gradients. In the frame of the grid, m. Walls thinner than
// a cell may have holes.
inline constexpr int kMostIsoCells = 96;
TriangleShape iso_surface(const DistanceGrid& grid);

// A ball with its centre at the origin. radius: m.
TriangleShape ball_shape(double radius);

// A disc in the plane z = 0 that faces up. radius: m.
TriangleShape disc_shape(double radius);

// The shape's surface; of a plane a disc of radius `plane_radius`, m; of a grid the surface where
// its distance is zero (iso_surface()), since a collider file keeps no triangles.
TriangleShape collider_shape(const Collider& collider, double plane_radius);

}  // namespace tremolo
