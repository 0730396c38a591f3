#include "precompute/reference/time_integration.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/text.h"
#include "precompute/system/failure.h"

namespace tremolo {
namespace {

constexpr int kMostHalvings = 6;

// Predicts the next displacement change from earlier steps. The prediction is exact for linear
// growth and for alternating signs, as of fast motion that the step does not resolve.
Vector predict(const Motion& motion, double step) {
  const std::vector<Vector>& last = motion.last_steps;
  if (last.size() >= 3) return last[0] + last[1] - last[2];
  return step * motion.v;
}

void keep_step(Vector d, Motion& motion) {
  motion.last_steps.insert(motion.last_steps.begin(), std::move(d));
  if (motion.last_steps.size() > 3) motion.last_steps.pop_back();
}

double kinetic_energy(const SecondOrderSystem& system, const Vector& v) {
  return 0.5 * v.dot(system.mass_times(v));
}

void apply_mass_damping(double factor, Motion& motion) {
  if (factor == 1.0) return;
  const double left = factor * factor;
  motion.dissipated += (1.0 - left) * motion.kinetic;
  motion.kinetic *= left;
  motion.v *= factor;
}

// Returns false, with the state unchanged, if the solve fails.
bool take_step(const SecondOrderSystem& system, const TimeSettings& settings, double step,
               const Vector& load, Motion& motion) {
  Motion next = motion;
  const double factor = std::exp(-0.5 * settings.alpha * step);
  apply_mass_damping(factor, next);
  const Vector momentum = system.mass_times(next.v);
  const StepEquation equation{2.0 / (step * step), 0.0,
                              segment_points(settings.scheme, settings.beta / step), next.u,
                              (-2.0 / step) * momentum - load};
  Vector d = predict(next, step);
  const SolveReport report = system.solve(equation, std::max(0.0, motion.total()), d);
  motion.iterations = next.iterations += report.iterations;
  motion.linear_iterations = next.linear_iterations += report.linear_iterations;
  motion.factorisations = next.factorisations += report.factorisations;
  if (!report.converged) return false;
  if (report.scale > 0)
    next.worst_residual = std::max(next.worst_residual, report.residual / report.scale);
  next.work += load.dot(d);
  if (settings.beta > 0)
    next.dissipated += (settings.beta / step) * system.strain_change_work(next.u, d);
  next.u += d;
  next.v = (2.0 / step) * d - next.v;
  next.kinetic = kinetic_energy(system, next.v);
  next.potential = system.energy(next.u);
  apply_mass_damping(factor, next);
  keep_step(std::move(d), next);
  motion = std::move(next);
  return true;
}

void advance_part(const SecondOrderSystem& system, const TimeSettings& settings,
                  const LoadHistory& load, double time, double step, int halvings, Motion& motion) {
  if (take_step(system, settings, step, load(time, step), motion)) return;
  if (halvings == kMostHalvings)
    throw Failure({ErrorKind::kSolver,
                   text("the step from t = %.6g s did not converge, not in parts of %.3g s either",
                        time, step)});
  motion.last_steps.clear();
  if (halvings == 0) ++motion.halved_steps;
  for (int part = 0; part < 2; ++part) {
    advance_part(system, settings, load, time + 0.5 * part * step, 0.5 * step, halvings + 1,
                 motion);
    motion.last_steps.clear();
  }
}

}  // namespace

std::vector<SegmentPoint> segment_points(TimeScheme scheme, double damping) {
  const double off = 0.5 / std::numbers::sqrt3;
  std::vector<SegmentPoint> points;
  if (scheme == TimeScheme::kMidpoint)
    points = {{1.0, 0.5}};
  else
    points = {{0.5, 0.5 - off}, {0.5, 0.5 + off}};
  if (damping > 0) points.push_back({damping, 0.5, true});
  return points;
}

Motion start_motion(const SecondOrderSystem& system, Vector u, Vector v) {
  Motion motion;
  motion.kinetic = kinetic_energy(system, v);
  motion.potential = system.energy(u);
  motion.u = std::move(u);
  motion.v = std::move(v);
  return motion;
}

void advance(const SecondOrderSystem& system, const TimeSettings& settings, const LoadHistory& load,
             Motion& motion) {
  advance_part(system, settings, load, motion.time, settings.step, 0, motion);
  ++motion.steps;
  motion.time = static_cast<double>(motion.steps) * settings.step;
}

}  // namespace tremolo
