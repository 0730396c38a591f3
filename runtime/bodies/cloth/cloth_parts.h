// The parts of a cloth: particles, springs of three kinds, triangles.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "common/mesh/render_surface.h"
#include "common/mesh/surface_mesh.h"
#include "common/result.h"
#include "runtime/bodies/cloth/cloth_scene.h"
#include "runtime/math/sparse/block_matrix.h"

namespace tremolo {

// pairs: the two particles of each spring. rest: their rest lengths, m.
struct ClothSprings {
  SpringLaw law;
  std::vector<NodePair> pairs;
  std::vector<double> rest;
};

// The particles, springs and triangles of a cloth.
struct ClothParts {
  Eigen::VectorXd x;                // at rest, m, 3n
  Eigen::VectorXd mass;             // kg, n
  std::vector<Triangle> triangles;  // for the wind and for drawing
  ClothSprings structural, shear, bend;
  double drag = 0.0;  // of the wind, kg/m^3 (docs/cloth.md)
  // For a file: its original surface, moved by the cloth's position; null: a grid.
  std::shared_ptr<const RenderSurface> drawn;
  // For a file with joined vertices: the particle of each of the file's vertices; else empty, and
  // the numbers are the same.
  std::vector<VertexId> particle_of;
  std::size_t joined = 0;  // vertices of the file that have no particle of their own
  // Texture coordinates of a grid's particles, (0, 0) at its corner to (1, 1): u along its columns,
  // v along its rows. Empty: a file, whose surface may have its own.
  std::vector<Eigen::Vector2f> uvs;

  std::size_t particles() const { return static_cast<std::size_t>(x.size()) / 3; }
  // Numbers of vertices in the file or of grid points, as scenes have them, and of particles.
  std::size_t vertices() const { return particle_of.empty() ? particles() : particle_of.size(); }
  std::size_t particle_of_vertex(std::size_t vertex) const {
    return particle_of.empty() ? vertex : static_cast<std::size_t>(particle_of[vertex]);
  }
  std::size_t vertex_of_particle(std::size_t particle) const;  // the first one
};

// The drawn surface of a file with the particles at x, 3n; its normals are those at rest.
RenderSurface drawn_at(const ClothParts& parts, const Eigen::VectorXd& x);

// The surface as which a cloth is drawn: of a file with texture coordinates that of the file, in
// which several vertices may be one particle; of all others the particles. Valid as long as the
// parts.
struct ClothLook {
  std::span<const Triangle> triangles;
  std::span<const Eigen::Vector2f> uvs;  // of each vertex; empty: it has no texture coordinates
  std::vector<std::uint32_t> particles;  // of each vertex
};
ClothLook look_of(const ClothParts& parts);

// Values of particles, `count` each, for the vertices of a look.
template <class Number>
void spread_to_look(const ClothLook& look, std::span<const Number> of_particles, std::size_t count,
                    std::vector<Number>& of_vertices) {
  of_vertices.clear();
  for (const std::size_t particle : look.particles)
    for (std::size_t k = 0; k < count; ++k)
      of_vertices.push_back(of_particles[count * particle + k]);
}

// Sets the rest lengths of the pairs to those at x. Errors (kContent): two particles at one
// position, with their numbers and `kind`.
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

// Makes the parts of a grid or of a file. In a file, boundary vertices at one position are joined:
// exporters split a sheet where texture coordinates or normals differ. Errors also as for
// read_polygons() and triangles_of().
Result<ClothParts> make_cloth_parts(const SceneCloth& cloth);

// x with each particle displaced by up to `share` of the mean length of its structural springs
// along each axis, by random numbers of a fixed seed; particles whose flag is not 0 stay.
Eigen::VectorXd crumpled(const ClothParts& parts, double share,
                         const std::vector<std::uint8_t>& stays);

// mesh: with the joined vertices. particle_of: for each vertex before, its number in `mesh`.
struct JoinedSeams {
  SurfaceMesh mesh;
  std::vector<VertexId> particle_of;
};

// Joins boundary vertices (of edges with one triangle) closer than a millionth of the mesh's size.
// Other vertices are not joined: layers may lie on each other. Numbers keep their order.
JoinedSeams join_seams(const SurfaceMesh& mesh);

}  // namespace tremolo
