// What a basis file holds, as values. docs/basis-format.md is the bytes.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "common/inertia_integrals.h"
#include "common/mesh/render_surface.h"
#include "common/mesh/surface_mesh.h"
#include "common/mesh/tet_mesh.h"

namespace tremolo {

// Rows of the basis: three consecutive rows (x, y, z) a vertex, in the order of vertex_ids.
using BasisRows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Some of the mesh's vertices with their rest positions and rows of U.
// vertex_ids: ascending ids in the source mesh. rest: one a vertex, m.
// rows: 3*size x r, row-major, kg^-1/2; zero for fixed vertices.
// column_scales: empty, or r if the rows come from a compact file: each entry of column i is a
// 16-bit integer times column_scales[i]. Readers set it, writers do not look at it.
struct VertexBlock {
  std::vector<VertexId> vertex_ids;
  std::vector<Eigen::Vector3d> rest;
  BasisRows rows;
  Eigen::VectorXd column_scales;
};

// A surface that follows the solid without being its boundary: what is drawn in its place.
// surface: its rest shape, m. rows: 3*s x r, row-major, kg^-1/2, W U: the weights with which each
// of its vertices hangs on the mesh's, times their rows of the basis. anchors: s, for each of its
// vertices the mesh's vertex that weighs most. column_scales: as in VertexBlock.
struct RenderBlock {
  RenderSurface surface;
  BasisRows rows;
  std::vector<VertexId> anchors;
  Eigen::VectorXd column_scales;
};

// Sizes fit each other, r coordinates and n vertices; every index names something; names have no
// zero byte and there is one of each kind.
bool fits(const RenderBlock& render, Eigen::Index r, std::uint64_t n);

// The load that a scene uses when it names none: a force on each of the vertices, N.
struct DefaultLoad {
  std::vector<VertexId> vertices;
  std::vector<Eigen::Vector3d> forces;  // one a vertex; their sum is what the user asked for
};

// The files that an imported model was made of (formats/vega/reduced_files.h), byte for byte; empty
// for a model that Tremolo made.
struct VegaFiles {
  std::string basis;  // .U
  std::string cubic;  // .cub
};

// Where the mass is. corners: of each tetrahedron, vertices of the mesh, positively oriented.
// masses: rho V of each, kg, without point masses. Both are empty where the maker did not keep
// them.
struct MassElements {
  std::vector<Tetrahedron> corners;
  std::vector<double> masses;
};

// Entry of LocalResponse::at that means all vertices of the default load together.
inline constexpr VertexId kAtDefaultLoad = -1;

// How the body gives way at rest, to first order, beyond what the basis has of it: the columns of
// W = (K^-1 - U Lambda^-1 U^T) G at the vertices. G: for each place three columns, the unit force
// (1 N) along x, y and z; at the default load's place it is shared as the load's forces are. Under
// forces f at the places, 3 a place, the displacement is U q + W f (docs/theory.md).
// at: p places, ids of vertices, ascending, each once; kAtDefaultLoad comes first.
// surface, interior, render: as the rows of these blocks, 3 a vertex x 3p, row-major, m/N.
struct LocalResponse {
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
  // entries, place pair_index(a, b) for a <= b. Stiffness damping needs it. Empty: not known (an
  // imported model, an older file) or a linear model.
  std::vector<double> strain_gram;

  VertexBlock surface;                   // vertices of the boundary
  VertexBlock interior;                  // all others
  std::vector<Triangle> triangles;       // boundary, indices into surface.vertex_ids
  std::vector<VertexId> fixed_vertices;  // ascending ids in the source mesh
  DefaultLoad load;                      // may be empty
  // Quadratic elements have vertices that are middles of edges, ascending; their rows are the
  // displacements of these places as of any other vertex. None: linear elements.
  std::vector<MeshEdge> edges;
  std::optional<RenderBlock> render;
  std::optional<InertiaIntegrals> inertia;  // none: an imported model, or a file made before these
  MassElements elements;                    // none unless asked for (--keep-elements)

  LocalResponse response;  // no places unless asked for (--response-at)

  std::string provenance;  // a JSON object, UTF-8
  VegaFiles vega;          // read_basis() leaves them in the file: read_vega_files()
};

}  // namespace tremolo
