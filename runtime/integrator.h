// One step of a body: (q, p) at t -> (q, p) at t + h, for  q'' + D q' + grad V(q) = f(t).
//
// The mass matrix is the identity, so p is both momentum and velocity. D is Rayleigh's
// (runtime/integrators/solve/damping.h), f comes as a StepLoad (runtime/load.h).
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include <Eigen/Core>

#include "common/result.h"
#include "common/state_stream.h"
#include "runtime/load.h"
#include "runtime/model.h"
#include "runtime/split.h"
#include "runtime/values/state.h"

namespace tremolo {

// Why a step was not made. kSolver: the solve gave up. kNumbers: a number overflowed, as from a
// state that was set too far out. kLoad: the same from a sound state with a load on it. kEnergy:
// the energy is out of all proportion to what was put in, the method has exploded
// (runtime/energy_bound.h).
enum class StepFailure { kNone, kSolver, kNumbers, kLoad, kEnergy };

// iterations: linear systems solved. residual: of the step's equation, Euclidean norm, units of q.
// converged: false if the solve gave up or a number is not finite; the state is then as before the
// step. dissipated: energy that damping took in this step, J (exact or second order: each method
// says which). extra_work: what the load did beyond average . (q1 - q0), J; zero for most methods.
// parts: into how many the step was cut because its solve had failed
// (runtime/integrators/solve/halving.h). failure: why it is not converged, as Body tells it; an
// integrator by itself leaves it at kNone.
struct StepReport {
  int iterations = 0;
  double residual = 0.0;
  bool converged = true;
  double dissipated = 0.0;
  double extra_work = 0.0;
  int parts = 1;
  StepFailure failure = StepFailure::kNone;
};

// step: h, s. alpha, beta: Rayleigh's, 1/s and s. newmark_*: Newmark's two numbers. tolerance: of
// the solve, on the residual relative to max(h |p|, h^2 |R|, h^2 |f|); imexv-thesis takes it as
// absolute, in units of q. Looser than 1e-6 the solver's error shows in the orbit and, but for the
// energy-preserving methods, in the energy; below 1e-14 rounding may keep the solve from
// converging. Methods whose energy it shows in take it times (h omega_1)^3/1e-5 where that is less
// than one, so that a smaller step never drifts more for its solves. halvings: how often a step
// whose solve failed may be cut in two; 0 gives up at once. moving_frame: StepLoad::coupling will
// be set, which only the energy-preserving family reads.
struct IntegratorOptions {
  double step = 3e-3;
  double alpha = 0.0;
  double beta = 0.0;
  double newmark_beta = 0.25;
  double newmark_gamma = 0.5;
  SplitOptions split = {};
  double tolerance = 1e-6;
  int max_iterations = 20;
  int halvings = 6;
  bool moving_frame = false;
};

// What a body, a group of a World, the C header and the programs take unless told otherwise: it
// cannot explode, at any step and load.
inline constexpr std::string_view kDefaultIntegrator = "ep4";

class Integrator {
 public:
  virtual ~Integrator() = default;

  // Advances the state by one step. Allocates nothing for r up to 100. Between steps the state may
  // be changed freely; what was cached for another q is noticed and computed again.
  virtual StepReport step(State& state, const StepLoad& load) noexcept = 0;

  // Forgets what was carried from earlier steps.
  virtual void reset() {}

  // What is carried from earlier steps, to be saved and put back: with it the next step has the
  // same bits.
  virtual void carry(StateStream& stream) = 0;

  // Goes on where `before` is, the same method with other damping: takes over what it has found out
  // about the motion or the loads. Most methods have nothing of the kind.
  virtual void follow(const Integrator& before) { (void)before; }

  virtual std::string_view name() const = 0;

  // For methods that split; empty for the others.
  virtual std::optional<Split> split() const { return std::nullopt; }

  // The momentum at the time of state.q. Differs from state.p only for methods that carry a
  // staggered one; energies must be read from this. p: r long.
  virtual void synchronized_momentum(const State& state, Eigen::VectorXd& p) const { p = state.p; }

  // V(q), J, for methods that have it from the last force of the step that ended at q.
  virtual std::optional<double> known_potential(const Eigen::VectorXd& q) const {
    (void)q;
    return std::nullopt;
  }
};

// Names that make_integrator knows, in the order they are listed to a user.
std::span<const std::string_view> integrator_names();

// Errors (kUsage): an unknown name (the message lists the known ones), a step that is not positive
// and finite, negative damping, a Newmark pair outside beta >= 0, gamma >= 0, a split out of range,
// a tolerance that is not positive, max_iterations < 1, a negative number of
// halvings.
// On a linear model (Potential::linear) "ep4" is the solution itself, coordinate by coordinate, for
// any r and in O(r) a step (runtime/integrators/exact_linear.cpp); every other method is its own
// map.
Result<std::unique_ptr<Integrator>> make_integrator(std::string_view name, Model::Pointer model,
                                                    const IntegratorOptions& options);

}  // namespace tremolo
