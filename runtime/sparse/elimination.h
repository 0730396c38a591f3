// The order in which a sparse symmetric matrix is eliminated, and which columns of its factor have
// the same rows: found from the pattern alone, once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "runtime/sparse/block_matrix.h"

namespace tremolo {

// Nodes are numbered anew, in the order of their elimination; a supernode is a run of them whose
// columns of the factor have the same rows below it (some of them zeros, where that made longer
// runs). order: the old number of each. first: where supernode s begins, supernodes() + 1 entries.
// rows: below s, ascending, from row_first[s] to row_first[s + 1] - 1. owner: the supernode of
// each.
struct Elimination {
  std::vector<std::uint32_t> order;
  std::vector<std::uint32_t> first;
  std::vector<std::size_t> row_first;
  std::vector<std::uint32_t> rows;
  std::vector<std::uint32_t> owner;

  std::size_t supernodes() const { return first.size() - 1; }
  std::size_t width(std::size_t s) const { return first[s + 1] - first[s]; }
  std::size_t rows_below(std::size_t s) const { return row_first[s + 1] - row_first[s]; }
};

// Eigen's approximate minimum degree (Amestoy, Davis and Duff 1996), then the elimination tree (Liu
// 1990) in postorder.
Elimination eliminate(const BlockPattern& pattern);

}  // namespace tremolo
