// Which vertices move, and the order in which the solvers see them.
//
// Free vertices become nodes 0..N-1. METIS partitions the node graph over the ranks, each rank's
// nodes are consecutive, and within a rank nested dissection orders them for a sparse factor (the
// node graph, each node standing for three dofs: cheaper to order than the dof graph and less
// fill). Dof 3*node + axis.
#pragma once

#include <vector>

#include "common/tet_mesh.h"

namespace tremolo {

// Neighbours of each vertex or node in compressed rows: those of i are
// neighbours[start[i] .. start[i+1]), ascending, without i itself.
struct Graph {
  std::vector<int> start;
  std::vector<int> neighbours;
};

// The graph of the vertices that `keep` marks: two are neighbours when a tetrahedron has both.
// Numbers of the graph are those of `number` (a vertex not kept has -1).
Graph node_graph(const TetMesh& mesh, const std::vector<int>& number, int count);

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

// This rank's share.
struct LocalDofs {
  int first_node = 0;
  int nodes = 0;
  std::vector<int> row_of_vertex;  // n; first of the vertex's three local rows, or -1
  std::vector<int> elements;       // tetrahedra with at least one node of this rank
  int dofs() const { return 3 * nodes; }
};
LocalDofs local_dofs(const TetMesh& mesh, const DofMap& map, int rank);

}  // namespace tremolo
