// Which vertices move, and the order in which the solvers see them.
//
// Free vertices become nodes 0..N-1. METIS partitions the node graph over the ranks, each rank's
// nodes are consecutive, and within a rank nested dissection orders them for a sparse factor (the
// node graph, each node standing for three dofs: cheaper to order than the dof graph and less
// fill). Dof 3*node + axis.
#pragma once

#include <vector>

#include "common/mesh/tet_mesh.h"

namespace tremolo {

// Neighbours of each vertex or node in compressed rows: those of i are
// neighbours[start[i] .. start[i+1]), ascending, without i itself.
struct Graph {
  std::vector<int> start;
  std::vector<int> neighbours;
};

// The graph of the vertices that have a `number` 0..count-1 (others -1), by those numbers: two are
// neighbours when a tetrahedron has both.
Graph node_graph(const TetMesh& mesh, const std::vector<int>& number, int count);

// A nested dissection of the whole graph: the node that comes i-th. Throws Failure (kSystem).
std::vector<int> dissection_order(const Graph& graph);

struct DofMap {
  std::vector<int> vertex_of_node;  // N
  std::vector<int> node_of_vertex;  // n; -1: fixed, or no tetrahedron has it
  std::vector<int> rank_begin;      // ranks + 1 node numbers
  Graph graph;                      // of the nodes

  int nodes() const { return static_cast<int>(vertex_of_node.size()); }
};

// fixed: ascending vertex ids. Throws Failure (kContent) when no vertex is left to move, (kSystem)
// when METIS fails.
DofMap make_dof_map(const TetMesh& mesh, const std::vector<VertexId>& fixed, int ranks);

// The rank whose node this is; -1 for what is no node (-1).
int rank_of_node(const DofMap& map, int node);

// Who counts an element, which may have nodes of several ranks: its lowest free corner's rank; -1:
// every corner is fixed.
int element_rank(const DofMap& map, const Tetrahedron& tet);

// This rank's share. Its part of the mesh are the tetrahedra with at least one of its nodes and
// their vertices, some of which are other ranks' nodes; a single rank's part is the whole mesh,
// with the same numbers.
struct LocalDofs {
  int first_node = 0;
  int nodes = 0;
  std::vector<VertexId> vertices;       // of the part: ids in the whole mesh, ascending
  std::vector<std::size_t> tetrahedra;  // of the part: the `counted` ones first, both ascending
  std::size_t counted = 0;              // each tetrahedron is counted by one rank
  std::vector<int> node_of_vertex;      // of the part's vertices; -1: no node
  std::vector<int> row_of_vertex;       // first of the vertex's three rows here, or -1: not ours
  std::vector<int> elements;            // of the part, with at least one node of this rank
  int dofs() const { return 3 * nodes; }
};
LocalDofs local_dofs(const TetMesh& mesh, const DofMap& map, int rank);

// The part's vertices and tetrahedra, in its numbers; no sets, no regions.
TetMesh part_mesh(const TetMesh& mesh, const LocalDofs& local);

}  // namespace tremolo
