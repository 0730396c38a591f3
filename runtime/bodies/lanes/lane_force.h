// grad (C + Q) for many bodies of one model at once, one body per lane.
//
// The part of V beyond 1/2 q^T Lambda q (docs/theory.md, "Reduced energy") is, over the unique
// entries with their number of orderings multiplied in,
//
//     sum_{j<=k<=l} t s,   t = q_j q_k q_l,   s = c_jkl + sum_{i<=j} c_ijkl q_i .
//
// One pass over the coefficients gives value and gradient. Each coefficient is loaded once and is
// added to s and, times t, to the gradient's row i: two multiply-adds per coefficient. The
// contribution of s to the rows j, k, l costs one operation per triple, not per coefficient. Every
// operation is the same on all lanes, so a body's result depends neither on the other lanes nor on
// the number of its lane.
//
// In float the range does not depend on units: coordinates are relative to the scale at which the
// cubic and the quartic terms are equal, and the energy is relative to its largest coefficient.
// Both scales are powers of two, which cause no rounding.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "runtime/math/kernels/lanes.h"

namespace tremolo {

// Bodies per block: as many as fit in 64 bytes, 16 floats or 8 doubles.
template <class Real>
inline constexpr std::size_t kBodiesPerBlock = 64 / sizeof(Real);

// The unique coefficients of the leading `modes` coordinates in the order of the pass, of (C +
// Q)(coordinate_scale x) / energy_scale as a polynomial in x.
template <class Real>
struct LaneCoefficients {
  std::size_t modes = 0;          // r
  double coordinate_scale = 1.0;  // kg^1/2 m
  double energy_scale = 1.0;      // J
  std::vector<Real> stream;       // triple_count(r) + quad_count(r)
};

// cubic, quartic: tensor entries packed as in common/packed_index.h, at least triple_count(modes)
// and quad_count(modes) of them, finite.
template <class Real>
LaneCoefficients<Real> make_lane_coefficients(std::size_t modes, std::span<const double> cubic,
                                              std::span<const double> quartic);

// x, gradient: [coordinate][lane], r x kBodiesPerBlock, aligned to 64 bytes: x = q /
// coordinate_scale, and the derivative with respect to x: grad (C + Q) = (energy_scale /
// coordinate_scale) gradient. energy: kBodiesPerBlock values of (C + Q) / energy_scale, or null.
// vectors: at most those of this machine; narrower ones are for tests and measurements. Nothing is
// allocated.
//
// Rounding: a row is a sum of about r^3/36 partial sums of up to 6 terms, each rounded to eps =
// 2^-24 in float, 2^-53 in double, and the coefficients are rounded once. Measured against grad V
// in double: tests/runtime/lane_force_test.cpp and `tremolo bench --only speed`.
void evaluate_lanes(const LaneCoefficients<float>& coefficients, const float* x, float* gradient,
                    float* energy, InstructionSet vectors = instruction_set());
void evaluate_lanes(const LaneCoefficients<double>& coefficients, const double* x, double* gradient,
                    double* energy, InstructionSet vectors = instruction_set());

extern template LaneCoefficients<float> make_lane_coefficients(std::size_t, std::span<const double>,
                                                               std::span<const double>);
extern template LaneCoefficients<double> make_lane_coefficients(std::size_t,
                                                                std::span<const double>,
                                                                std::span<const double>);

}  // namespace tremolo
