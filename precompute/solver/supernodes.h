// A lower triangular factor in supernodes: columns with the same row pattern form one dense panel.
// A solve handles eight or sixteen right-hand sides in one pass, stored as one or two SIMD vectors
// a row, so that the factor is read once for all of them.
#pragma once

#include <cstddef>

#include "precompute/dense/lanes.h"

namespace tremolo {

// Non-owning view. Supernode s has columns first_column[s] .. first_column[s+1]-1 and rows
// row[first_row[s]] .. row[first_row[s+1]-1], ascending, its own columns first. Its panel, rows x
// columns and column-major, starts at values + panel[s]; entries above the diagonal are not read.
struct Supernodes {
  std::size_t count = 0;
  const int* first_column = nullptr;
  const int* first_row = nullptr;
  const int* panel = nullptr;
  const int* row = nullptr;
  const double* values = nullptr;
  std::size_t most_rows = 0;  // the largest number of rows of a panel
};

// Computes x <- L^-T L^-1 x. x: n rows of `vectors` (1 or 2) LaneBlocks. scratch: most_rows *
// vectors.
void solve_supernodes(const Supernodes& factor, int vectors, LaneBlock* x, LaneBlock* scratch);

}  // namespace tremolo
