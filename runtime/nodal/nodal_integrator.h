// Integrators of M x'' = f(x, v) for masses in space (runtime/nodal/nodal_system.h).
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
//   bdf2                   x1 - 4/3 x0 + 1/3 x-1 = 2/3 h v1, likewise v; its first step: midpoint
//   imex                   half a kick of soft forces, midpoint of stiff ones, half a kick
//   energy                 2 M (x1 - x0 - h v0)/h^2 = NodalSystem::step_force: energy is balanced
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>

#include <Eigen/Core>

#include "common/result.h"
#include "runtime/nodal/nodal_system.h"

namespace tremolo {

// x, v: 3n; time: s.
struct NodalState {
  Eigen::VectorXd x, v;
  double time = 0.0;
};

// tolerance: of Newton's residual, a share of NodalSystem::load_size(). factor: whether Newton's
// systems are solved by a factor, or by conjugate gradients; automatic by size. halvings: how often
// a step that fails is halved before it is given up. account: whether reports tell the energies,
// which costs two evaluations a step; else they are 0 there. guard: midpoint, newmark and bdf2,
// which add energy where stiff springs turn in long steps, take those steps by the rule of `energy`
// in which they would have added more, since they last had taken as much, than a hundredth of what
// the nodes' energy was at most, and implicit-euler-linear by Newton's method; only if `account`.
enum class NodalSolver { kAutomatic, kCholesky, kConjugateGradients };
struct NodalOptions {
  double step = 1.0 / 60.0;  // s
  double tolerance = 1e-6;
  int max_iterations = 50;
  NodalSolver solver = NodalSolver::kAutomatic;
  int halvings = 6;
  bool account = true;
  bool guard = true;
};

// H is the potential and the kinetic energy of the nodes that are not held. made: the step was
// made. parts: into how many it was cut. iterations: Newton's. residual: the largest at the end, as
// the tolerance is. held_work: what held nodes that move gave, J. damped, driven: as StepWork.
// pressed: what reactions (NodalContact) did. numerical: what the method itself added to the
// energy, J: H1 - H0 less all that is told; zero to rounding for `energy`. guarded: parts that were
// taken by the rule of `energy`.
struct NodalReport {
  bool made = false;
  int parts = 1;
  int iterations = 0;
  double residual = 0.0;
  double held_work = 0.0;
  double damped = 0.0;
  double driven = 0.0;
  double pressed = 0.0;
  double numerical = 0.0;
  int guarded = 0;
};

class NodalIntegrator {
 public:
  virtual ~NodalIntegrator() = default;
  virtual std::string_view name() const = 0;
  // Takes the state one step further. A step that cannot be made leaves it as it was. Nothing is
  // allocated.
  virtual NodalReport step(NodalState& state) = 0;
  // The state was changed from outside (contact, a user): what was carried is forgotten.
  virtual void reset() = 0;
};

// The twelve names above.
std::span<const std::string_view> nodal_integrator_names();

// system: must outlive it. Errors (kUsage): another name, a step or tolerance that is not positive
// and finite; kSystem: no memory for a factor where one was asked for.
Result<std::unique_ptr<NodalIntegrator>> make_nodal_integrator(std::string_view name,
                                                               const NodalSystem& system,
                                                               const NodalOptions& options);

// Steps above this multiple of 1/omega_max, where one exists, are unstable for an undamped linear
// spring: 2 for symplectic-euler, 2 sqrt(2) for rk4, 2/sqrt(3) for the sweep, 2 for the soft half
// of imex; 0: never stable undamped (explicit-euler, explicit-midpoint); infinity for the others.
double stability_number(std::string_view name);

// omega_max^2, the largest eigenvalue of M^-1 K (1/s^2), K the tangent of a part at (x, 0), by
// Lanczos; held nodes do not move. relative: to be reached.
double largest_eigenvalue(const NodalSystem& system, const Eigen::VectorXd& x, ForcePart part,
                          double relative = 1e-4);

}  // namespace tremolo
