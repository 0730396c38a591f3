// The equation of an energy-preserving step
// (runtime/bodies/reduced/integrators/energy_preserving.cpp has it, its symbols and its solve) for
// eight bodies of one model, one per lane of a vector.
//
// Linear algebra of r coordinates takes r^3 operations and the force r^4, so that N and the
// Jacobian are made for each lane: Z is reduced to tridiagonal form W T W^T by Householder's
// reflections in all lanes at once. W is kept as its reflections. Where J is not a function of Z (a
// fixed N, or strong damping) it has a Cholesky factor.
//
// No operation mixes lanes: the numbers of a body depend neither on the other lanes nor on the
// number of its own. A lane that a mask leaves out keeps its numbers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "runtime/integrator.h"
#include "runtime/math/kernels/lanes.h"
#include "runtime/model.h"

namespace tremolo {

inline constexpr std::size_t kSolveLanes = 8;
inline constexpr std::size_t kMostLaneMoves = 4;  // of Broyden's updates

// A simple fraction weight/(z - pole), of a conjugate pair the one above the real axis.
struct LanePole {
  double re, im;
  double weight_re, weight_im;
};

// First rows of the arrays of a LaneSpan, in rows of eight doubles. A matrix is stored as its lower
// triangle by columns.
struct LaneLayout {
  explicit LaneLayout(std::size_t modes = 0);

  // Scratch, r rows each if nothing else is said.
  std::size_t q0, p0, f, d, G, predicted;
  std::size_t d_hat, dp_hat, b_hat, g_hat, x, y;
  std::size_t q1, p1;
  std::size_t moves;      // kMostLaneMoves times r rows
  std::size_t z, factor;  // Z = h^2 K/4, and the Cholesky factor of J
  std::size_t filter;     // of this step: saved_rows of `saved_filter`
  std::size_t work_z;     // Z during the reduction
  std::size_t fractions;  // factors of T - pole
  std::size_t scratch_rows;
  // Saved between steps.
  std::size_t G_before, missed, d_hat_before, saved_filter, saved_z;
  std::size_t saved_rows;
  // Parts of a filter, from its first row: reflections u (lower triangle without the diagonal), f,
  // diagonal and off-diagonal of T.
  std::size_t u, reflection, diagonal, off, filter_rows;
};

// Constants of all bodies of a group.
struct LaneSystem {
  std::size_t modes = 0;   // r
  double step = 0.0;       // h, s
  double tolerance = 0.0;  // of the solve
  bool follows = false;    // N follows the state
  bool damped = false;
  bool factored = false;  // J has a Cholesky factor
  LaneLayout layout;
  AlignedDoubles lambda, D, theta_D, S;  // r each
  AlignedDoubles weight;                 // N if it is fixed, else n less N at rest, r
  // J is factors times Z, entry by entry, plus the diagonal `slope`; factors: lower triangle by
  // columns.
  AlignedDoubles slope, factors;
  double limit = 0.0;  // N at infinity
  std::vector<LanePole> of_filter, of_inverse;
};

// name: avf, ep2 or ep4. The model must not be linear, and options.beta must be zero.
LaneSystem make_lane_system(std::string_view name, const Model& model,
                            const IntegratorOptions& options);

// Arrays of eight bodies, rows as in LaneLayout.
struct LaneSpan {
  double* scratch;
  double* saved;
};

// One number per lane.
struct alignas(64) LaneNumbers {
  double value[kSolveLanes];
};

// A set of lanes as all bits of a number.
struct alignas(64) LaneMask {
  std::uint64_t value[kSolveLanes];
};
LaneMask lane_mask(std::uint32_t bits);

// ---- The parts of a step, in their order. Nothing is allocated. ----

// Sets d = h p0.
void begin_lanes(const LaneSystem& system, const LaneSpan& span);

// In the lanes of the mask Z and `filter` become those of the last step; in the others `missed` is
// zero.
void recall_lanes(const LaneSystem& system, const LaneSpan& span, const LaneMask& lanes);

// Computes N from Z in the lanes of the mask, its basis, and the factors for solve.
void filter_lanes(const LaneSystem& system, const LaneSpan& span, const LaneMask& lanes);
void factor_lanes(const LaneSystem& system, const LaneSpan& span);

// Sets d_hat and b_hat from d and p0 in the lanes of the mask.
void enter_lanes(const LaneSystem& system, const LaneSpan& span, const LaneMask& lanes);

// In the lanes of the mask: G predicted from the step before.
void predict_lanes(const LaneSystem& system, const LaneSpan& span, const LaneMask& lanes);

// In the lanes of the mask: the prediction moves along with move 0, `missed` is what G differs.
void miss_lanes(const LaneSystem& system, const LaneSpan& span, const LaneMask& lanes);
void move_prediction_lanes(const LaneSystem& system, const LaneSpan& span);

// Sets dp_hat and g_hat from d, d_hat and G in the lanes of the mask. ratio: relative_residual().
void evaluate_residual_lanes(const LaneSystem& system, const LaneSpan& span, const LaneMask& lanes,
                             LaneNumbers& ratio);

// Adds the move number `count` to d in the lanes of the mask, by the frozen Jacobian and `count` of
// Broyden's updates.
void move_lanes(const LaneSystem& system, const LaneSpan& span, std::size_t count,
                const LaneMask& lanes);

// Ends the step: sets q1 and p1 from d and dp_hat, with the energy of the residual given back.
struct LaneEnd {
  LaneNumbers dissipated;  // J
  LaneNumbers given_back;  // the energy that the solve left, J
  LaneNumbers kinetic;     // of p1 before that, J
};
void end_lanes(const LaneSystem& system, const LaneSpan& span, LaneEnd& end);

// Saves the knowledge of the step for the next one in the lanes of the mask.
void save_lanes(const LaneSystem& system, const LaneSpan& span, const LaneMask& lanes);

}  // namespace tremolo
