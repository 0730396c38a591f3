// Edge points make a tetrahedral mesh quadratic (docs/theory.md, section "Elements").
//
// Every edge has its own vertex in its middle, common to all tetrahedra around it. As a control
// point of a Bernstein-Bezier field it has the value c_ab; the field's value in the edge's middle
// is u_m = (c_a + 2 c_ab + c_b) / 4.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "common/mesh/surface_mesh.h"
#include "common/mesh/tet_mesh.h"
#include "common/result.h"

namespace tremolo {

// The control points of one element: its four corners, and of a quadratic one its six edge points
// in the order of kTetEdges.
inline constexpr int kMostNodes = 10;
struct ElementNodes {
  std::array<VertexId, kMostNodes> ids{};
  int count = 4;

  const VertexId* begin() const { return ids.data(); }
  const VertexId* end() const { return ids.data() + count; }
  VertexId operator[](std::size_t i) const { return ids[i]; }
};

inline ElementNodes element_nodes(const TetMesh& mesh, std::size_t element) {
  ElementNodes nodes;
  for (std::size_t a = 0; a < 4; ++a) nodes.ids[a] = mesh.tetrahedra[element][a];
  if (mesh.edge_points.empty()) return nodes;
  for (std::size_t e = 0; e < 6; ++e) nodes.ids[4 + e] = mesh.edge_points[element][e];
  nodes.count = kMostNodes;
  return nodes;
}

// Every edge of the tetrahedra once, as its ends (lower id first), ascending.
std::vector<std::pair<VertexId, VertexId>> mesh_edges(const TetMesh& mesh);

// Makes a linear mesh quadratic: appends the middle of each edge to the vertices, in the order of
// mesh_edges(). A mesh that has `edges` from its file keeps them; its tetrahedra find their points
// by the ends. Colours, if there are any, become bare on new vertices.
// Errors (kContent): there would be 2^31 vertices or more; an edge of a file's mesh has no point.
Status add_edge_points(TetMesh& mesh);

// Checks the `edges` of a file, before add_edge_points: errors (kContent) for missing, repeated or
// wrongly connected ones. Points of curved edges, farther from the middle than `tolerance` times
// the edge's length, are moved to the middle. Returns their number.
Result<std::size_t> straighten_edges(TetMesh& mesh, double tolerance);

// Removes the edge points from a mesh that is to be linear: the other vertices keep their order.
// Returns how many there were.
std::size_t remove_edge_points(TetMesh& mesh);

// The vertices that are edge points: empty for a linear mesh, else one flag per vertex.
std::vector<bool> edge_point_flags(const TetMesh& mesh);

// The edge whose point a vertex is; nullptr if it is not an edge point.
const MeshEdge* edge_of_point(const TetMesh& mesh, VertexId point);

// Edge points that are fixed if these corners are (docs/theory.md): both ends are fixed, and the
// edge is in the chosen region. by_place: corners chosen by their positions, with the edges between
// them; for all others an edge must be a side of a boundary triangle whose three corners are fixed.
// held, by_place: ascending. Returns ascending ids.
std::vector<VertexId> held_edge_points(const TetMesh& mesh, const std::vector<VertexId>& held,
                                       const std::vector<VertexId>& by_place);

// The boundary of a quadratic mesh with four triangles for each of `boundary`, whose corners
// include the edge points. Triangles 4t .. 4t+3 are those of triangle t.
BoundarySurface subdivided(const BoundarySurface& boundary, const TetMesh& mesh);

// Uniform refinement: each tetrahedron into eight. The vertices of a mesh with edge points become
// corners of eight times as many tetrahedra: four at the corners, four around the shortest diagonal
// of the octahedron between. Those of tetrahedron t are 8t .. 8t+7, positively oriented, in its
// region. Vertices and sets keep their numbers; the result is linear, without edges.
TetMesh refined_mesh(const TetMesh& mesh);

}  // namespace tremolo
