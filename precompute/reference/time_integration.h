// Time integration of the full mesh or of the reduced model, by the same steps.
//
// With d = u1 - u0, the mean load f over the step and momentum M v:
//   M (2/h) (d/h - v0) + F + F_v = f,    v1 = 2 d/h - v0.
// F = f(u0 + d/2) for the implicit midpoint rule, the mean of f(u) on the segment for the averaged
// vector field (exact with two Gauss points, since f is cubic). F_v is the force of the stress
// beta C : (E1 - E0)/h at u0 + d/2: H1 - H0 = f . d - beta/h int (E1 - E0) : C : (E1 - E0).
// Mass damping multiplies v by exp(-alpha h/2) before and after the step.
#pragma once

#include <cstdint>

#include "precompute/reference/full/step_equation.h"

namespace tremolo {

enum class TimeScheme { kMidpoint, kAveragedField };

// Returns the points at which the scheme evaluates the force; with stiffness damping, beta/h, the
// point of its stress, too.
std::vector<SegmentPoint> segment_points(TimeScheme scheme, double damping = 0);

// step: s; alpha: 1/s; beta: s.
struct TimeSettings {
  TimeScheme scheme = TimeScheme::kAveragedField;
  double step = 1e-3;
  double alpha = 0;
  double beta = 0;
};

// Returns the mean load over [time, time + step], N.
using LoadHistory = std::function<Vector(double time, double step)>;

// State of a motion; energies in J. work, dissipated: since the start. last_steps: displacement
// changes of earlier steps, latest first, for the prediction.
struct Motion {
  Vector u, v;
  double time = 0;
  double kinetic = 0, potential = 0, work = 0, dissipated = 0;
  std::vector<Vector> last_steps;
  std::int64_t steps = 0;
  std::int64_t halved_steps = 0;  // taken in parts
  std::int64_t iterations = 0, linear_iterations = 0, factorisations = 0;
  double worst_residual = 0;  // relative

  double total() const { return kinetic + potential; }
};

// Returns the motion at t = 0. u: m; v: m/s (for a reduced model its coordinates).
Motion start_motion(const SecondOrderSystem& system, Vector u, Vector v);

// Advances by one step. If its solve fails, the step is halved, recursively up to six times. Throws
// Failure (kSolver) if that fails too.
void advance(const SecondOrderSystem& system, const TimeSettings& settings, const LoadHistory& load,
             Motion& motion);

}  // namespace tremolo
