#include "precompute/reference/full/statics.h"

#include <cmath>

#include "common/format_text.h"
#include "precompute/system/failure.h"

namespace tremolo {
namespace {

void add(const SolveReport& report, StaticSolution& solution) {
  solution.iterations += report.iterations;
  solution.linear_iterations += report.linear_iterations;
  solution.factorisations += report.factorisations;
}

// Returns a linear extrapolation of the displacement along the last load step.
Vector extrapolate(const Vector& before, const Vector& now, double last_fraction, double fraction) {
  if (last_fraction == 0) return now;
  return now + (fraction / last_fraction) * (now - before);
}

}  // namespace

StaticSolution static_solution(const SecondOrderSystem& system, const Vector& load) {
  constexpr double kSmallest = 1.0 / 4096.0;
  StaticSolution solution;
  solution.u = Vector::Zero(system.size);
  StepEquation equation{0.0, 0.0, {{1.0, 1.0}}, Vector::Zero(system.size), Vector()};
  Vector before = solution.u;
  double reached = 0, fraction = 1, last_fraction = 0, energy = 0;
  SolveReport report;
  while (reached < 1) {
    fraction = std::min(fraction, 1 - reached);
    equation.constant = -(reached + fraction) * load;
    Vector u = extrapolate(before, solution.u, last_fraction, fraction);
    report = system.solve(equation, energy, u);
    add(report, solution);
    if (!report.converged) {
      fraction *= 0.5;
      if (fraction < kSmallest)
        throw Failure(
            {ErrorKind::kSolver,
             text("the static solution did not converge beyond %.4g of the load: residual "
                  "%.1e after %d iterations. A smaller load (--scale) may be borne",
                  reached, report.residual / report.scale, report.iterations)});
      continue;
    }
    // The scale is the whole load's linear compliance, whatever the size of the first load step.
    if (energy == 0) energy = std::pow(report.scale / fraction, 2);
    before = std::exchange(solution.u, std::move(u));
    last_fraction = fraction;
    reached = reached + fraction >= 1 ? 1 : reached + fraction;
    fraction *= 2;
    ++solution.load_steps;
  }
  solution.residual = report.scale == 0 ? 0.0 : report.residual / report.scale;
  solution.energy = system.energy(solution.u);
  solution.work = load.dot(solution.u);
  return solution;
}

}  // namespace tremolo
