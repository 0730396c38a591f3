// A surface attached to the tetrahedra: each of its vertices is an affine combination of the four
// corners of one of them,
//
//     x_v = sum_c w_vc X_c,   sum_c w_vc = 1        and so   u_v = sum_c w_vc u_c = (W U q)_v
//
// in the tetrahedron that contains it or, outside, in the one at the boundary's nearest point, with
// weights that are then extrapolated: an affine motion of the mesh moves the surface in the same
// way.
#pragma once

#include <string>
#include <vector>

#include "common/mesh/render_surface.h"
#include "common/mesh/tet_mesh.h"
#include "formats/basis/basis_data.h"

namespace tremolo {

// Extrapolated weights stay in this range; beyond it a small rotation of the tetrahedron would move
// the vertex far. Such a vertex follows the boundary's nearest point instead, which is rigid only
// for translations.
inline constexpr double kLeastWeight = -2.0;
inline constexpr double kLargestWeight = 3.0;

// tetrahedra, weights: one a vertex of the surface. Distances in m, to the boundary.
struct Embedding {
  std::vector<std::size_t> tetrahedra;
  std::vector<Eigen::Vector4d> weights;
  std::size_t counted = 0;  // points that the next four values are of
  std::size_t outside = 0;
  double largest_distance = 0;  // of those outside
  std::size_t clamped = 0;      // of those, follow the nearest point
  double clamped_distance = 0;  // largest
};

// mesh: positively oriented, at least one tetrahedron. points: finite. The result does not depend
// on the number of threads.
Embedding embed(const std::vector<Eigen::Vector3d>& points, const TetMesh& mesh,
                unsigned threads = 1);

// Attaches the vertices of a surface. The counts and distances leave out those that belong to no
// triangle: nobody sees where they are.
Embedding embed_surface(const RenderSurface& surface, const TetMesh& mesh, unsigned threads = 1);

// W U, 3s x r; basis: U, 3n x r.
BasisRows embedded_rows(const Embedding& embedding, const TetMesh& mesh, const BasisRows& basis);

// For each point the mesh's vertex with the largest weight.
std::vector<VertexId> heaviest_vertices(const Embedding& embedding, const TetMesh& mesh);

// Describes the positions of the points in the mesh, for the user.
std::vector<std::string> describe(const Embedding& embedding, const TetMesh& mesh);

}  // namespace tremolo
