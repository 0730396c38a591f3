// Vectors of four floats, and blocks of three by three in them.
#pragma once

namespace tremolo {

typedef float Quad __attribute__((vector_size(16), may_alias));

// Three columns; the fourth number of each is zero.
struct QuadBlock {
  Quad column[3];
};

// Converts columns a, b, c of four numbers to four columns of three.
[[gnu::always_inline]] inline void turn_quads(Quad a, Quad b, Quad c, Quad* out) {
  const Quad zero = {};
  const Quad ab = __builtin_shufflevector(a, b, 0, 4, 1, 5);
  const Quad cz = __builtin_shufflevector(c, zero, 0, 4, 1, 5);
  const Quad ab2 = __builtin_shufflevector(a, b, 2, 6, 3, 7);
  const Quad cz2 = __builtin_shufflevector(c, zero, 2, 6, 3, 7);
  out[0] = __builtin_shufflevector(ab, cz, 0, 1, 4, 5);
  out[1] = __builtin_shufflevector(ab, cz, 2, 3, 6, 7);
  out[2] = __builtin_shufflevector(ab2, cz2, 0, 1, 4, 5);
  out[3] = __builtin_shufflevector(ab2, cz2, 2, 3, 6, 7);
}

[[gnu::always_inline]] inline QuadBlock transposed(const QuadBlock& block) {
  Quad out[4];
  turn_quads(block.column[0], block.column[1], block.column[2], out);
  return {{out[0], out[1], out[2]}};
}

[[gnu::always_inline]] inline Quad times(const QuadBlock& block, Quad x) {
  return block.column[0] * x[0] + block.column[1] * x[1] + block.column[2] * x[2];
}

}  // namespace tremolo
