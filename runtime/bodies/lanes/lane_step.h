// One step of a block of bodies side by side in the lanes of vectors: imexv-linear
// (runtime/bodies/reduced/integrators/imexv/imexv_linear.cpp), of which verlet is the case with
// every row low.
#pragma once

#include <cstddef>
#include <cstdint>

#include "runtime/bodies/reduced/integrators/imexv/linear_rows.h"

namespace tremolo {

typedef double LaneVector __attribute__((vector_size(64), may_alias));

// A block's arrays: r rows of `width` vectors of 8 lanes, width 1 or 2.
struct BlockArrays {
  std::size_t modes;  // r
  std::size_t low;    // rows before it are explicit
  std::size_t width;
  double h;  // the step, s
  const double* lambda;
  const double* decay;  // DampedKick's on low rows, 1 on high rows; null without damping
  const double* reach;  // DampedKick's on low rows; h/2 on high rows
  const LinearRow* rows;
  LaneVector* q;
  LaneVector* p;
  LaneVector* R_s;      // force of the kicks: R without lambda q on the high rows
  const LaneVector* f;  // the load; null: none
};

// The first kick, the drift of the low rows, the midpoint rule of the high rows.
void kick_and_drift(const BlockArrays& b);

// The second kick.
void kick_again(const BlockArrays& b);

// x = scale q, rounded to x's precision. count: vectors.
void to_lanes(const LaneVector* q, std::size_t count, double scale, double* x);
void to_lanes(const LaneVector* q, std::size_t count, double scale, float* x);

// R_s = scale gradient, plus lambda q on the low rows.
void set_force(const BlockArrays& b, double scale, const double* gradient);
void set_force(const BlockArrays& b, double scale, const float* gradient);

// energy, in: C + Q; out: T + V. harmonic: T and the quadratic part of V. All J, `width` vectors.
void add_quadratic_energy(const BlockArrays& b, LaneVector* energy, LaneVector* harmonic);

// work: of the load from q0 to q. kick: 1/2 (h |f|)^2. Both J, `width` vectors.
void sum_work(const BlockArrays& b, const LaneVector* q0, LaneVector* work, LaneVector* kick);

// Bits of the lanes in which q, p or R_s is not finite.
std::uint32_t lanes_not_finite(const BlockArrays& b);

}  // namespace tremolo
