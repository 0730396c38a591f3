// One step of a body: (q, p) at t -> (q, p) at t + h, for  q'' + D q' + grad V(q) = f(t).
//
// The mass matrix is the identity, so p is both momentum and velocity. D is Rayleigh damping, or
// has a ratio of each mode (runtime/bodies/reduced/integrators/solve/damping.h); f is given as a
// StepLoad (runtime/load.h).
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include <Eigen/Core>

#include "common/damping_ratios.h"
#include "common/result.h"
#include "common/state_stream.h"
#include "runtime/load.h"
#include "runtime/math/state.h"
#include "runtime/model.h"
#include "runtime/split.h"

namespace tremolo {

// Reason why a step failed. kSolver: the solve gave up. kNumbers: a number overflowed, as from a
// state with too large values. kLoad: the same from a valid state with a load on it. kEnergy: the
// energy is far above the energy that was put in, because the method has exploded
// (runtime/energy_bound.h).
enum class StepFailure { kNone, kSolver, kNumbers, kLoad, kEnergy };

// Result of a step.
struct StepReport {
  int iterations = 0;     // linear systems solved
  double residual = 0.0;  // of the step's equation, Euclidean norm, units of q
  // False: the solve gave up or a number is not finite; the state is then as before the step.
  bool converged = true;
  // Energy taken by damping in this step, J (exact or second order: each method's file says which).
  double dissipated = 0.0;
  // Work of the load in addition to average . (q1 - q0), J; zero for most methods.
  double extra_work = 0.0;
  // Number of parts of a step that was subdivided after its solve had failed
  // (runtime/bodies/reduced/integrators/solve/halving.h).
  int parts = 1;
  // Reason for a step that is not converged, set by Body; integrators leave kNone.
  StepFailure failure = StepFailure::kNone;
};

// Options of an integrator.
struct IntegratorOptions {
  double step = 3e-3;  // h, s
  double alpha = 0.0;  // Rayleigh's, 1/s
  double beta = 0.0;   // Rayleigh's, s
  // In addition, of_modes or table: the coordinate i has the rate 2 zeta_i omega_i. `rayleigh` is
  // not read: alpha and beta are above.
  DampingRatios ratios = {};
  // Newmark's beta and gamma.
  double newmark_beta = 0.25;
  double newmark_gamma = 0.5;
  SplitOptions split = {};  // for methods that split
  // Of the solve, on the residual relative to max(h |p|, h^2 |R|, h^2 |f|); imexv-thesis takes it
  // as absolute, in units of q. Above 1e-6 the solver's error shows in the orbit and, except for
  // the energy-preserving methods, in the energy; below 1e-14 rounding may keep the solve from
  // converging. Methods whose energy shows it multiply it by (h omega_1)^3/1e-5 where that is below
  // one, so that a smaller step never drifts more because of its solves.
  double tolerance = 1e-6;
  int max_iterations = 20;
  int halvings = 6;  // how often a step whose solve failed may be halved; 0: never
  // StepLoad::coupling will be set, which only the energy-preserving family reads.
  bool moving_frame = false;
};

// Puts `damping` in place of all damping that the options have.
inline void put_damping(const DampingRatios& damping, IntegratorOptions& options) {
  options.alpha = damping.rayleigh.alpha;
  options.beta = damping.rayleigh.beta;
  options.ratios = damping;
  options.ratios.rayleigh = {};
}

// All damping of the options.
inline DampingRatios damping_of(const IntegratorOptions& options) {
  DampingRatios damping = options.ratios;
  damping.rayleigh = {options.alpha, options.beta};
  return damping;
}

// The default of a body, a group of a Crowd, the C header and the programs: it cannot explode, at
// any step and load.
inline constexpr std::string_view kDefaultIntegrator = "ep4";

class Integrator {
 public:
  virtual ~Integrator() = default;

  // Advances the state by one step. Allocates nothing for r up to 100. The caller may change the
  // state between steps; cached values for another q are detected and computed again.
  virtual StepReport step(State& state, const StepLoad& load) noexcept = 0;

  // Discards the state from earlier steps.
  virtual void reset() {}

  // Saves or restores the state from earlier steps: with it the next step has the same bits.
  virtual void carry(StateStream& stream) = 0;

  // Continues the motion of `before`, the same method with other damping: takes over its knowledge
  // of the motion or the loads. Most methods have none.
  virtual void follow(const Integrator& before) { (void)before; }

  virtual std::string_view name() const = 0;

  // The split of a method that splits; empty for the others.
  virtual std::optional<Split> split() const { return std::nullopt; }

  // The momentum at the time of state.q, r long. It differs from state.p only for methods with a
  // staggered momentum; compute energies from this one.
  virtual void synchronized_momentum(const State& state, Eigen::VectorXd& p) const { p = state.p; }

  // V(q), J, for methods that know it from the last force of the step that ended at q.
  virtual std::optional<double> known_potential(const Eigen::VectorXd& q) const {
    (void)q;
    return std::nullopt;
  }
};

// Names that make_integrator accepts, in the order of listings.
std::span<const std::string_view> integrator_names();

// Errors (kUsage): an unknown name (the message lists the known ones), a step that is not positive
// and finite, negative alpha or beta, a Newmark pair outside beta >= 0, gamma >= 0, a split out of
// range, a tolerance that is not positive, max_iterations < 1, a negative number of halvings.
// kContent: those of check_ratios. On a linear model (Potential::linear) "ep4" is the exact
// solution, coordinate by coordinate, for any r and in O(r) a step
// (runtime/bodies/reduced/integrators/exact_linear.cpp); every other method is its usual map.
Result<std::unique_ptr<Integrator>> make_integrator(std::string_view name, Model::Pointer model,
                                                    const IntegratorOptions& options);

}  // namespace tremolo
