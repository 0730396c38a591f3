// Numbering of the free displacement components, and the sparsity pattern of their matrices.
#pragma once

#include <array>

#include "precompute/fem/dof_map.h"
#include "precompute/reference/full/step_equation.h"

namespace tremolo {

// Unknown i is component dof[i] = 3*vertex + axis of all vertices' displacements. Nodes are in
// nested dissection order, to reduce the fill of a factor.
struct Unknowns {
  DofMap map;
  std::vector<int> of_dof;  // 3n; -1: held
  std::vector<int> dof;     // N
  Eigen::Index count() const { return dof.size(); }
};

// fixed: ascending ids. held: ascending ids of vertices held along x, y, z. Throws Failure
// (kContent) if nothing is left to move.
Unknowns make_unknowns(const TetMesh& mesh, const std::vector<VertexId>& fixed,
                       const std::array<std::vector<VertexId>, 3>& held);

Vector expand(const Unknowns& unknowns, const Vector& x);  // N -> 3n, zero at held components
Vector restrict_to(const Unknowns& unknowns, const Vector& field);  // 3n -> N

// A symmetric sparse matrix on the unknowns in compressed rows, columns ascending, with the element
// contributions to each 3x3 block. The blocks of node a are block[a] .. block[a+1]. The columns of
// block b start `offset[b]` entries after the row's start; the block is the sum over part[begin[b]]
// .. part[begin[b+1]]; a part stands for nodes i, j of an element of `nodes` nodes.
struct ElementPart {
  std::size_t element;
  int i, j;
};
struct Pattern {
  std::vector<int> start, column;
  std::vector<int> block, node, offset, begin, part;
  int nodes = 4;

  int self(int node_index) const;  // index of a node's diagonal block
  ElementPart element_part(int at) const {
    const int inside = part[at] % (nodes * nodes);
    return {static_cast<std::size_t>(part[at] / (nodes * nodes)), inside / nodes, inside % nodes};
  }
};
// Throws Failure (kContent) if the parts' numbers exceed 32 bits: above 134 million linear or 21
// million quadratic tetrahedra.
Pattern make_pattern(const TetMesh& mesh, const Unknowns& unknowns);

}  // namespace tremolo
