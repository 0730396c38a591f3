// The contents of a basis file as values; docs/basis-format.md describes the bytes.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "common/energy.h"
#include "common/mesh/render_surface.h"
#include "common/mesh/surface_mesh.h"
#include "common/mesh/tet_mesh.h"

namespace tremolo {

// Rows of the basis: three consecutive rows (x, y, z) a vertex, in the order of vertex_ids.
using BasisRows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Some of the mesh's vertices with their rest positions and rows of U.
struct VertexBlock {
  std::vector<VertexId> vertex_ids;   // ids in the source mesh, ascending
  std::vector<Eigen::Vector3d> rest;  // one per vertex, m
  BasisRows rows;                     // 3*size x r, row-major, kg^-1/2; zero for fixed vertices
  // Empty, or r if the rows come from a compact file: each entry of column i is a 16-bit integer
  // times column_scales[i]. Readers set it, writers ignore it.
  Eigen::VectorXd column_scales;
};

// A surface that follows the solid and is drawn instead of its boundary, s vertices.
struct RenderBlock {
  RenderSurface surface;  // at rest, m
  // W U, 3*s x r, row-major, kg^-1/2: W interpolates each of the surface's vertices from the
  // mesh's.
  BasisRows rows;
  std::vector<VertexId> anchors;  // s: the mesh's vertex with the largest weight
  Eigen::VectorXd column_scales;  // as in VertexBlock
};

// True if all sizes agree with each other, with r coordinates and n vertices; all indices are in
// range; and the lists of names are valid.
bool fits(const RenderBlock& render, Eigen::Index r, std::uint64_t n);

// The default load of a model, for scenes without one: a force on each of the vertices, N.
struct DefaultLoad {
  std::vector<VertexId> vertices;
  std::vector<Eigen::Vector3d> forces;  // one per vertex; their sum is the requested force
};

// The files that an imported model was made of (formats/vega/reduced_files.h), byte for byte; empty
// for a model that Tremolo made.
struct VegaFiles {
  std::string basis;  // .U
  std::string cubic;  // .cub
};

// Elements with their masses. Both lists are empty if they were not kept.
struct MassElements {
  std::vector<Tetrahedron> corners;  // vertices of the mesh, positively oriented
  std::vector<double> masses;        // rho V of each, kg, without point masses
};

// Entry of LocalResponse::at that means all vertices of the default load together.
inline constexpr VertexId kAtDefaultLoad = -1;

// Linear static compliance of the body that the basis does not represent: the columns of W = (K^-1
// - U Lambda^-1 U^T) G at the vertices. G has three columns for each point, a unit force (1 N)
// along x, y and z; the default load counts as one point, with the unit force distributed as the
// load's forces are. Under forces f at the points, 3 per point, the displacement is U q + W f
// (docs/theory.md). The rows are those of the basis's blocks, 3 per vertex x 3p, row-major, m/N.
struct LocalResponse {
  // p points: ids of vertices, ascending and unique; kAtDefaultLoad is first.
  std::vector<VertexId> at;
  BasisRows surface;
  BasisRows interior;
  BasisRows render;
};

// One precomputed model (docs/theory.md, section "Reduced energy"):
//   V(q) = 1/2 q^T diag(lambda) q + C[q,q,q] + Q[q,q,q,q]     J, mass matrix = identity
struct BasisData {
  std::uint64_t vertex_count = 0;       // n of the whole mesh
  std::uint64_t tetrahedron_count = 0;  // m
  std::uint64_t linear_mode_count = 0;  // k; 0: not known, an imported basis
  std::uint64_t fixed_vertex_count = 0;
  std::uint64_t rigid_mode_count = 0;  // left out of the basis: six for each free part
  double total_mass = 0;               // kg

  Eigen::VectorXd lambda;               // r, (rad/s)^2, ascending
  std::vector<double> cubic;            // C: triple_count(r) entries, packed_index.h
  std::vector<double> quartic;          // Q: quad_count(r) entries; both empty: a linear model
  std::vector<double> singular_values;  // of the mass-PCA, descending, kept and cut
  // G of V = 1/2 y^T G y, y the strain_terms(r) of packed_index.h: pair_count(strain_terms(r))
  // entries, index pair_index(a, b) for a <= b. Stiffness damping needs it. Empty: not known (an
  // imported model, an older file) or a linear model.
  std::vector<double> strain_gram;

  VertexBlock surface;                   // vertices of the boundary
  VertexBlock interior;                  // all others
  std::vector<Triangle> triangles;       // boundary, indices into surface.vertex_ids
  std::vector<VertexId> fixed_vertices;  // ascending ids in the source mesh
  DefaultLoad load;                      // may be empty
  // For quadratic elements: the vertices that are midpoints of edges, ascending; their rows are the
  // displacements of these points, as for any other vertex. Empty: linear elements.
  std::vector<MeshEdge> edges;
  std::optional<RenderBlock> render;
  std::optional<InertiaIntegrals> inertia;  // none: an imported model, or a file made before these
  MassElements elements;                    // empty unless requested (--keep-elements)

  LocalResponse response;  // no points unless requested (--response-at)

  std::string provenance;  // a JSON object, UTF-8
  VegaFiles vega;          // read_basis() leaves them in the file: read_vega_files()
};

}  // namespace tremolo
