// Motion in time of the full mesh or of the reduced model, by the same step.
//
// With d = u1 - u0 and the mean load f over the step, the momentum being M v:
//   M (2/h) (d/h - v0) + F + beta K d/h = f,    v1 = 2 d/h - v0,
// F = f(u0 + d/2) for the implicit midpoint rule; the mean of f(u) on the segment for the averaged
// vector field, exact by two Gauss points since f is cubic: H1 - H0 = f . d - d . beta K d/h.
// Damping of the mass multiplies v by exp(-alpha h/2) before and after. K is that at rest.
#pragma once

#include <cstdint>

#include "precompute/reference/step_equation.h"

namespace tremolo {

enum class TimeScheme { kMidpoint, kAveragedField };

std::vector<SegmentPoint> segment_points(TimeScheme scheme);

// step: s; alpha: 1/s; beta: s.
struct TimeSettings {
  TimeScheme scheme = TimeScheme::kAveragedField;
  double step = 1e-3;
  double alpha = 0;
  double beta = 0;
};

// The mean load over [time, time + step], N.
using LoadHistory = std::function<Vector(double time, double step)>;

// Energies in J. work, dissipated: since the start. last_steps: displacement changes of the steps
// before, latest first, for the next guess.
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

Motion start_motion(const SecondOrderSystem& system, Vector u, Vector v);

// One step; where its solve fails it is taken as two halves, these again, up to six times. Throws
// Failure (kSolver) when that fails too.
void advance(const SecondOrderSystem& system, const TimeSettings& settings, const LoadHistory& load,
             Motion& motion);

}  // namespace tremolo
