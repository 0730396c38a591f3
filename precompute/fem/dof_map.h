// Numbering of the free dofs.
//
// Free vertices, edge points among them, become nodes 0..N-1. METIS partitions the node graph over
// the ranks, each rank's nodes are consecutive, and within a rank they are in nested dissection
// order to reduce fill of a sparse factor. Ordering the node graph, where each node stands for
// three dofs, is cheaper than ordering the dof graph and gives less fill. Dof 3*node + axis.
#pragma once

#include <vector>

#include "common/mesh/edge_points.h"

namespace tremolo {

// An adjacency list in compressed rows: the neighbours of i are neighbours[start[i] .. start[i+1]),
// ascending, without i itself.
struct Graph {
  std::vector<int> start;
  std::vector<int> neighbours;
};

// Returns the graph of the vertices that have a `number` 0..count-1 (others have -1), in that
// numbering; two are adjacent if they share a tetrahedron.
Graph node_graph(const TetMesh& mesh, const std::vector<int>& number, int count);

// Returns a nested dissection order: entry i is the node that comes i-th. Throws Failure (kSystem).
std::vector<int> dissection_order(const Graph& graph);

struct DofMap {
  std::vector<int> vertex_of_node;  // N
  std::vector<int> node_of_vertex;  // n; -1: fixed, or in no tetrahedron
  std::vector<int> rank_begin;      // ranks + 1 offsets into the nodes
  Graph graph;                      // of the nodes

  int nodes() const { return static_cast<int>(vertex_of_node.size()); }
};

// fixed: ascending vertex ids. Throws Failure: kContent if every vertex is fixed, kSystem if METIS
// fails.
DofMap make_dof_map(const TetMesh& mesh, const std::vector<VertexId>& fixed, int ranks);

// Returns the rank that owns the node; -1 for node -1.
int rank_of_node(const DofMap& map, int node);

// Returns the rank that owns an element: that of its lowest free node; -1 if all are fixed.
int element_rank(const DofMap& map, const ElementNodes& nodes);

// The dofs of this rank. Its part of the mesh consists of the tetrahedra with at least one of its
// nodes, and of their vertices, some of which are nodes of other ranks. A single rank's part is the
// whole mesh in the same numbering.
struct LocalDofs {
  int first_node = 0;
  int nodes = 0;
  std::vector<VertexId> vertices;  // of the part: ids in the whole mesh, ascending
  std::vector<std::size_t>
      tetrahedra;                   // of the part: first the `counted` ones, both groups ascending
  std::size_t counted = 0;          // tetrahedra owned by this rank (element_rank)
  std::vector<int> node_of_vertex;  // of the part's vertices; -1: no node
  std::vector<int>
      row_of_vertex;          // first of the vertex's three local rows; -1: not owned by this rank
  std::vector<int> elements;  // in the part's numbering, those with at least one node of this rank
  int dofs() const { return 3 * nodes; }
};
LocalDofs local_dofs(const TetMesh& mesh, const DofMap& map, int rank);

// Returns the part's vertices and tetrahedra in the part's numbering; without sets and regions.
TetMesh part_mesh(const TetMesh& mesh, const LocalDofs& local);

}  // namespace tremolo
