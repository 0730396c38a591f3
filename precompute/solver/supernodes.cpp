#include "precompute/solver/supernodes.h"

namespace tremolo {
namespace {

#define TREMOLO_INLINE_LANES [[gnu::always_inline]] inline

// Forward substitution for a tile of `Columns` columns from `column` on: solves for their rows of t
// and eliminates them from all rows below.
template <int Columns, int Vectors>
TREMOLO_INLINE_LANES void forward_tile(const double* panel, std::size_t rows, std::size_t column,
                                       Lanes* t) {
  const double* l[Columns];
  Lanes x[Columns][Vectors];
  for (int c = 0; c < Columns; ++c) l[c] = panel + (column + c) * rows;
  for (int c = 0; c < Columns; ++c)
    for (int v = 0; v < Vectors; ++v) {
      Lanes sum = t[(column + c) * Vectors + v];
      for (int b = 0; b < c; ++b) sum -= l[b][column + c] * x[b][v];
      x[c][v] = sum / l[c][column + c];
      t[(column + c) * Vectors + v] = x[c][v];
    }
  for (std::size_t row = column + Columns; row < rows; ++row)
    for (int v = 0; v < Vectors; ++v) {
      Lanes sum = t[row * Vectors + v];
      for (int c = 0; c < Columns; ++c) sum -= l[c][row] * x[c][v];
      t[row * Vectors + v] = sum;
    }
}

// Backward substitution for a tile: subtracts the known rows below, then solves for the tile's
// rows.
template <int Columns, int Vectors>
TREMOLO_INLINE_LANES void backward_tile(const double* panel, std::size_t rows, std::size_t column,
                                        Lanes* t) {
  const double* l[Columns];
  Lanes x[Columns][Vectors];
  for (int c = 0; c < Columns; ++c) {
    l[c] = panel + (column + c) * rows;
    for (int v = 0; v < Vectors; ++v) x[c][v] = t[(column + c) * Vectors + v];
  }
  for (std::size_t row = column + Columns; row < rows; ++row)
    for (int v = 0; v < Vectors; ++v) {
      const Lanes known = t[row * Vectors + v];
      for (int c = 0; c < Columns; ++c) x[c][v] -= l[c][row] * known;
    }
  for (int c = Columns - 1; c >= 0; --c)
    for (int v = 0; v < Vectors; ++v) {
      Lanes sum = x[c][v];
      for (int b = c + 1; b < Columns; ++b) sum -= l[c][column + b] * x[b][v];
      x[c][v] = sum / l[c][column + c];
      t[(column + c) * Vectors + v] = x[c][v];
    }
}

constexpr std::size_t kTile = 8;

template <int Vectors>
TREMOLO_INLINE_LANES void solve(const Supernodes& f, Lanes* x, Lanes* t) {
  const auto gather = [&](std::size_t s) __attribute__((always_inline)) {
    const std::size_t first = f.first_row[s];
    const auto rows = f.first_row[s + 1] - first;
    for (std::size_t i = 0; i < rows; ++i)
      for (int v = 0; v < Vectors; ++v)
        t[i * Vectors + v] = x[static_cast<std::size_t>(f.row[first + i]) * Vectors + v];
    return rows;
  };
  const auto scatter = [&](std::size_t s, std::size_t count) __attribute__((always_inline)) {
    const std::size_t first = f.first_row[s];
    for (std::size_t i = 0; i < count; ++i)
      for (int v = 0; v < Vectors; ++v)
        x[static_cast<std::size_t>(f.row[first + i]) * Vectors + v] = t[i * Vectors + v];
  };
  for (std::size_t s = 0; s < f.count; ++s) {
    const std::size_t columns = f.first_column[s + 1] - f.first_column[s];
    const double* panel = f.values + f.panel[s];
    const std::size_t rows = gather(s);
    std::size_t c = 0;
    for (; c + kTile <= columns; c += kTile) forward_tile<kTile, Vectors>(panel, rows, c, t);
    for (; c + 3 <= columns; c += 3) forward_tile<3, Vectors>(panel, rows, c, t);
    for (; c < columns; ++c) forward_tile<1, Vectors>(panel, rows, c, t);
    scatter(s, rows);
  }
  for (std::size_t s = f.count; s-- > 0;) {
    const std::size_t columns = f.first_column[s + 1] - f.first_column[s];
    const double* panel = f.values + f.panel[s];
    const std::size_t rows = gather(s);
    // The tiles of the forward pass in reverse order: leftover columns come first.
    const std::size_t whole = columns / kTile * kTile;
    std::size_t c = columns;
    for (; (c - whole) % 3 != 0; --c) backward_tile<1, Vectors>(panel, rows, c - 1, t);
    for (; c > whole; c -= 3) backward_tile<3, Vectors>(panel, rows, c - 3, t);
    for (; c > 0; c -= kTile) backward_tile<kTile, Vectors>(panel, rows, c - kTile, t);
    scatter(s, columns);
  }
}

TREMOLO_CLONES void solve_one(const Supernodes& factor, Lanes* x, Lanes* scratch) {
  solve<1>(factor, x, scratch);
}

TREMOLO_CLONES void solve_two(const Supernodes& factor, Lanes* x, Lanes* scratch) {
  solve<2>(factor, x, scratch);
}

}  // namespace

void solve_supernodes(const Supernodes& factor, int vectors, LaneBlock* x, LaneBlock* scratch) {
  (vectors == 1 ? solve_one : solve_two)(factor, &x->at, &scratch->at);
}

}  // namespace tremolo
