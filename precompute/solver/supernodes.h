// A lower triangular factor in supernodes: columns that share their rows lie together as one dense
// panel. Solves take eight or sixteen right-hand sides in one pass, a row of them being a vector or
// two, so that the factor is read once for all of them.
#pragma once

#include <cstddef>

#include "precompute/dense/lanes.h"

namespace tremolo {

// Borrowed. Supernode s has columns first_column[s] .. first_column[s+1]-1 and rows
// row[first_row[s]] .. row[first_row[s+1]-1], ascending, the supernode's own columns first. Its
// panel, rows x columns and column-major, starts at values + panel[s]; what lies above the diagonal
// is not read.
struct Supernodes {
  std::size_t count = 0;
  const int* first_column = nullptr;
  const int* first_row = nullptr;
  const int* panel = nullptr;
  const int* row = nullptr;
  const double* values = nullptr;
  std::size_t most_rows = 0;  // of a panel
};

// x <- L^-T L^-1 x. x: n rows of `vectors` (1 or 2) LaneBlocks. scratch: most_rows * vectors.
void solve_supernodes(const Supernodes& factor, int vectors, LaneBlock* x, LaneBlock* scratch);

}  // namespace tremolo
