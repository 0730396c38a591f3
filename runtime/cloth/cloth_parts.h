// The parts of a cloth: particles, springs of three kinds, triangles.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "common/mesh/render_surface.h"
#include "common/mesh/surface_mesh.h"
#include "common/result.h"
#include "runtime/cloth/cloth_scene.h"
#include "runtime/sparse/block_matrix.h"

namespace tremolo {

// pairs: the two particles of each spring. rest: their rest lengths, m.
struct ClothSprings {
  SpringLaw law;
  std::vector<NodePair> pairs;
  std::vector<double> rest;
};

// x: 3n, m, at rest. mass: n, kg. triangles: what the wind blows on and what is drawn. drag:
// kg/m^3.
struct ClothParts {
  Eigen::VectorXd x;
  Eigen::VectorXd mass;
  std::vector<Triangle> triangles;
  ClothSprings structural, shear, bend;
  double drag = 0.0;
  // Of a file: its surface as its author made it, moved by the cloth's position; null: a grid.
  std::shared_ptr<const RenderSurface> drawn;
  // Of a file of which vertices were joined: the particle of each of the file's vertices; else
  // empty, and the numbers are the same.
  std::vector<VertexId> particle_of;
  std::size_t joined = 0;  // vertices of the file that have no particle of their own

  std::size_t particles() const { return static_cast<std::size_t>(x.size()) / 3; }
  // Numbers of vertices in the file or of grid points, as scenes have them, and of particles.
  std::size_t vertices() const { return particle_of.empty() ? particles() : particle_of.size(); }
  std::size_t particle_of_vertex(std::size_t vertex) const {
    return particle_of.empty() ? vertex : static_cast<std::size_t>(particle_of[vertex]);
  }
  std::size_t vertex_of_particle(std::size_t particle) const;  // the first one
};

// The drawn surface of a file where the particles are at x, 3n; its normals are those at rest.
RenderSurface drawn_at(const ClothParts& parts, const Eigen::VectorXd& x);

// Rest lengths of the pairs as they lie at x. Errors (kContent): of two particles in one place,
// naming them and `kind`.
Status measure_springs(const Eigen::VectorXd& x, const char* kind, ClothSprings& springs);

// Particle row * columns + column. Structural springs join neighbours, shear springs the diagonals
// of each cell, bend springs second neighbours; a cell's mass is shared by its four corners. The
// diagonal by which cells become triangles changes from each to the next.
Result<ClothParts> make_grid_cloth(const SceneCloth& cloth);

// Any triangles. Structural springs are the edges; over each edge that two triangles share a shear
// and a bend spring join the vertices opposite of it, which resist shear of the two to first order
// and their bending to second. A triangle's mass is shared by its corners. Errors (kContent):
// vertices without a triangle, edges with more than two, triangles without an area.
Result<ClothParts> make_mesh_cloth(const SceneCloth& cloth, const SurfaceMesh& mesh);

// The grid's or the file's. Of a file vertices of the border that are at one place are joined: an
// exporter splits a sheet where texture coordinates or normals differ. Errors also as of
// read_polygons() and triangles_of().
Result<ClothParts> make_cloth_parts(const SceneCloth& cloth);

// x, each particle moved by up to `share` of the mean length of its structural springs along each
// axis, by random numbers of a fixed seed; those whose flag is not 0 stay.
Eigen::VectorXd crumpled(const ClothParts& parts, double share,
                         const std::vector<std::uint8_t>& stays);

}  // namespace tremolo
