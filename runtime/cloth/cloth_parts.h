// The parts of a cloth: particles, springs of three kinds, triangles.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "common/mesh/surface_mesh.h"
#include "common/result.h"
#include "runtime/cloth/cloth_scene.h"
#include "runtime/sparse/block_matrix.h"

namespace tremolo {

// Springs of one kind.
struct ClothSprings {
  SpringLaw law;
  std::vector<NodePair> pairs;  // the two particles of each spring
  std::vector<double> rest;     // their rest lengths, m
};

// The parts of a cloth of n particles.
struct ClothParts {
  Eigen::VectorXd x;                // 3n, m, at rest
  Eigen::VectorXd mass;             // n, kg
  std::vector<Triangle> triangles;  // the wind acts on them, and they are drawn
  ClothSprings structural, shear, bend;
  double drag = 0.0;  // kg/m^3
};

// Sets the rest lengths of the pairs to those at x. Error (kContent): two particles at one
// position; the message names them and `kind`.
Status measure_springs(const Eigen::VectorXd& x, const char* kind, ClothSprings& springs);

// The index of a particle is row * columns + column. Structural springs join neighbours, shear
// springs the diagonals of each cell, bend springs second neighbours. A cell's mass is divided
// equally among its four corners. The diagonal that divides cells into triangles alternates from
// cell to cell.
Result<ClothParts> make_grid_cloth(const SceneCloth& cloth);

// Accepts any triangles. Structural springs are the edges. Over each edge of two triangles a shear
// and a bend spring join the opposite vertices; they resist shear of the two triangles to first
// order and bending to second. A triangle's mass is divided among its corners. Errors (kContent):
// vertices without a triangle, edges with more than two, triangles without an area.
Result<ClothParts> make_mesh_cloth(const SceneCloth& cloth, const SurfaceMesh& mesh);

// Makes the grid's or the file's cloth. Errors also as for read_surface_triangles().
Result<ClothParts> make_cloth_parts(const SceneCloth& cloth);

// Returns x with each particle displaced along each axis by up to `share` of the mean length of its
// structural springs, by random numbers of a fixed seed. Particles whose flag is not 0 are not
// displaced.
Eigen::VectorXd crumpled(const ClothParts& parts, double share,
                         const std::vector<std::uint8_t>& stays);

}  // namespace tremolo
