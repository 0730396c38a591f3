// The mean of grad (C + Q) on the segment between two positions, and the tangent, for many bodies
// of one model at once, one body per lane.
//
// With m the middle of the segment and s half of it (docs/theory.md, "Energy-preserving steps")
//
//     mean    = 3 C[m,m] + C[s,s] + 4 Q[m m^T + s s^T] m
//     tangent = 6 C[m] + 12 Q[m m^T + s s^T],           K(m) - Lambda + O(s^2)
//
// Two passes compute them. Both read each coefficient once for all lanes of a block.
//
// evaluate_segment() gives both. Let X be the pairs i <= j of m m^T + s s^T, twice that for i < j.
// One product with a symmetric matrix gives A' and, with it, everything:
//
//     [ 0        1/2 C ] [ m ]   [ 1/2 C[X]           ]
//     [ 1/2 C^T    Q   ] [ X ] = [ A' = Q[X] + 1/2 C[m] ],     mean = 4 A' m + C[X],  tangent = 12
//     A'
//
// evaluate_mean() gives the mean alone, in 3/5 of the time at r = 30. The mean of a cubic is that
// of its values at the two points m +- s/sqrt(3). The two share the sum over a row of the gradient,
// since a coefficient times t(+) + t(-) is one multiply-add (lane_force.h has t): three per
// coefficient.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "runtime/bodies/lanes/lane_force.h"
#include "runtime/math/kernels/lanes.h"

namespace tremolo {

// Coefficients of the two passes, of (C + Q)(coordinate_scale x) / energy_scale as a polynomial in
// x; the scales are those of LaneCoefficients.
template <class Real>
struct SegmentCoefficients {
  std::size_t modes = 0;          // r
  double coordinate_scale = 1.0;  // kg^1/2 m
  double energy_scale = 1.0;      // J
  // The matrix above, its lower triangle in groups of 8 rows: the columns before the group, then a
  // whole square on the diagonal.
  std::vector<Real, CacheLineAllocator<Real>> matrix;
  std::vector<Real> stream;  // of evaluate_mean
};

// cubic, quartic: as for make_lane_coefficients. The scales are taken from `lanes`.
template <class Real>
SegmentCoefficients<Real> make_segment_coefficients(const LaneCoefficients<Real>& lanes,
                                                    std::span<const double> cubic,
                                                    std::span<const double> quartic);

// Rows of the scratch of evaluate_segment.
constexpr std::size_t segment_scratch_rows(std::size_t modes) {
  return 2 * ((modes + modes * (modes + 1) / 2 + 7) / 8 * 8);
}

// All arrays are rows of kBodiesPerBlock numbers aligned to 64 bytes. middle, half: m and s in
// units of coordinate_scale, r rows. mean: r rows, in units of energy_scale/coordinate_scale.
// tangent: in units of energy_scale/coordinate_scale^2, the pairs i <= j in the order of
// pair_index. vectors: at most those of this machine. Nothing is allocated.
template <class Real>
void evaluate_segment(const SegmentCoefficients<Real>& coefficients, const Real* middle,
                      const Real* half, Real* scratch, Real* mean, Real* tangent,
                      InstructionSet vectors = instruction_set());

// As above, the mean alone. scratch: 2 r rows.
template <class Real>
void evaluate_mean(const SegmentCoefficients<Real>& coefficients, const Real* middle,
                   const Real* half, Real* scratch, Real* mean,
                   InstructionSet vectors = instruction_set());

}  // namespace tremolo
