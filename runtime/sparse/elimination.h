// The order in which a sparse symmetric matrix is eliminated, and the columns of its factor that
// have the same rows. Both follow from the pattern alone and are computed once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "runtime/sparse/block_matrix.h"

namespace tremolo {

// The elimination. Nodes are renumbered in its order. A supernode is a run of nodes whose columns
// of the factor have the same rows below it (some of them zeros, where that makes longer runs).
struct Elimination {
  std::vector<std::uint32_t> order;    // the old number of each node
  std::vector<std::uint32_t> first;    // start of each supernode; supernodes() + 1 entries
  std::vector<std::size_t> row_first;  // start of each supernode's rows; supernodes() + 1 entries
  std::vector<std::uint32_t> rows;     // below each supernode, ascending
  std::vector<std::uint32_t> owner;    // the supernode of each node

  std::size_t supernodes() const { return first.size() - 1; }
  std::size_t width(std::size_t s) const { return first[s + 1] - first[s]; }
  std::size_t rows_below(std::size_t s) const { return row_first[s + 1] - row_first[s]; }
};

// Eigen's approximate minimum degree (Amestoy, Davis and Duff 1996), then the elimination tree (Liu
// 1990) in postorder.
Elimination eliminate(const BlockPattern& pattern);

}  // namespace tremolo
