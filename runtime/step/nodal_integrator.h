// Integrators of M x'' = f(x, v) for masses in space (runtime/step/nodal_system.h).
//
//   explicit-euler         x1 = x0 + h v0,            v1 = v0 + h a(x0, v0)
//   symplectic-euler       v1 = v0 + h a(x0, v0),     x1 = x0 + h v1
//   explicit-midpoint      the slope in the middle, of an explicit Euler half step
//   rk4                    Runge and Kutta's
//   implicit-euler         M (x1 - x0 - h v0)/h^2 = f(x1, (x1 - x0)/h), by Newton
//   implicit-euler-linear  its first Newton step alone (Baraff and Witkin 1998)
//   implicit-euler-sweep   f at the end of an explicit Euler step: one sweep of fixed points
//   midpoint               2 M (x1 - x0 - h v0)/h^2 = f((x0 + x1)/2, (x1 - x0)/h)
//   newmark                beta = 1/4, gamma = 1/2
//   bdf2                   x1 - 4/3 x0 + 1/3 x-1 = 2/3 h v1, v the same; its first step: midpoint
//   imex                   half a kick of soft forces, midpoint of stiff ones, half a kick
//   energy                 2 M (x1 - x0 - h v0)/h^2 = NodalSystem::step_force: energy is balanced
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>

#include <Eigen/Core>

#include "common/result.h"
#include "common/state_stream.h"
#include "runtime/step/nodal_system.h"

namespace tremolo {

// State of 3n coordinates.
struct NodalState {
  Eigen::VectorXd x, v;  // 3n, m and m/s
  double time = 0.0;     // s
};

// Selects the solver of Newton's systems: by a factor or by conjugate gradients; automatic by size.
enum class NodalSolver { kAutomatic, kCholesky, kConjugateGradients };
// Options of a nodal integrator.
struct NodalOptions {
  double step = 1.0 / 60.0;  // s
  double tolerance = 1e-6;   // of Newton's residual, as a fraction of NodalSystem::load_size()
  int max_iterations = 50;
  NodalSolver solver = NodalSolver::kAutomatic;
  int halvings = 6;  // how often a failed step is halved before it is given up
  // Reports contain energies, which takes two evaluations per step; false: they are 0.
  bool account = true;
  // Only with account. midpoint, newmark and bdf2 add energy where stiff springs rotate in long
  // steps. They take a step by the rule of `energy` if it would have added more, since they last
  // took as much, than a hundredth of the nodes' largest energy; implicit-euler-linear then takes
  // Newton's method.
  bool guard = true;
};

// Report of a step. H is the potential energy plus the kinetic energy of the nodes that are not
// fixed.
struct NodalReport {
  bool made = false;       // the step succeeded
  int parts = 1;           // number of parts of a subdivided step
  int iterations = 0;      // of Newton's method
  double residual = 0.0;   // the largest at the end, in the unit of the tolerance
  double held_work = 0.0;  // work of moving fixed nodes, J
  double damped = 0.0;     // as StepWork, J
  double driven = 0.0;     // as StepWork, J
  double pressed = 0.0;    // work of reactions (NodalContact), J
  // Energy added by the method itself, J: H1 - H0 less all reported work; zero to rounding for
  // `energy`.
  double numerical = 0.0;
  int guarded = 0;  // parts that used the rule of `energy`
};

class NodalIntegrator {
 public:
  virtual ~NodalIntegrator() = default;
  virtual std::string_view name() const = 0;
  // Takes one step. A step that fails leaves the state unchanged. Nothing is allocated.
  virtual NodalReport step(NodalState& state) = 0;
  // The state was changed from outside (contact, a user): the method's own state is discarded.
  virtual void reset() = 0;
  // Saves or restores what the method keeps between steps, all that the next step depends on beside
  // the state.
  virtual void carry(StateStream& stream) { (void)stream; }
};

// The twelve names above.
std::span<const std::string_view> nodal_integrator_names();

// system: must outlive the integrator. Errors (kUsage): another name, a step or tolerance that is
// not positive and finite; kSystem: no memory for a requested factor.
Result<std::unique_ptr<NodalIntegrator>> make_nodal_integrator(std::string_view name,
                                                               const NodalSystem& system,
                                                               const NodalOptions& options);

// Steps above this multiple of 1/omega_max, where one exists, are unstable for an undamped linear
// spring: 2 for symplectic-euler, 2 sqrt(2) for rk4, 2/sqrt(3) for the sweep, 2 for the soft half
// of imex; 0: never stable undamped (explicit-euler, explicit-midpoint); infinity for the others.
double stability_number(std::string_view name);

// omega_max^2, the largest eigenvalue of M^-1 K (1/s^2), K the tangent of a part at (x, 0), by
// Lanczos; fixed nodes do not move. relative: requested accuracy.
double largest_eigenvalue(const NodalSystem& system, const Eigen::VectorXd& x, ForcePart part,
                          double relative = 1e-4);

}  // namespace tremolo
