// Which displacement components move, and which of them an element couples.
#pragma once

#include <array>

#include "precompute/fem/dof_map.h"
#include "precompute/reference/step_equation.h"

namespace tremolo {

// Unknown i is component dof[i] = 3*vertex + axis of the displacements of all vertices. Nodes are
// in nested dissection, so a factor's fill is small.
struct Unknowns {
  DofMap map;
  std::vector<int> of_dof;  // 3n; -1: does not move
  std::vector<int> dof;     // N
  Eigen::Index count() const { return static_cast<Eigen::Index>(dof.size()); }
};

// fixed: ascending ids. held: ascending ids of what does not move along x, y, z. Throws Failure
// (kContent) when nothing is left to move.
Unknowns make_unknowns(const TetMesh& mesh, const std::vector<VertexId>& fixed,
                       const std::array<std::vector<VertexId>, 3>& held);

Vector expand(const Unknowns& unknowns, const Vector& x);  // N -> 3n, zero where nothing moves
Vector restrict_to(const Unknowns& unknowns, const Vector& field);  // 3n -> N

// A symmetric sparse matrix over the unknowns in compressed rows, columns ascending, and what each
// 3x3 block of two nodes is the sum of. Blocks of node a are block[a] .. block[a+1]; block b has
// its columns `offset[b]` behind the row's start, and is the sum over part[begin[b]] ..
// part[begin[b+1]]: 16*element + 4*i + j stands for corners i, j.
struct Pattern {
  std::vector<int> start, column;
  std::vector<int> block, node, offset, begin, part;
  int self(int node_index) const;  // the block of a node with itself
};
Pattern make_pattern(const TetMesh& mesh, const Unknowns& unknowns);

}  // namespace tremolo
