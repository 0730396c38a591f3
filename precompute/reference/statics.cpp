#include "precompute/reference/statics.h"

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

// Where the load's growth leads if nothing bends: along the last load step.
Vector guess(const Vector& before, const Vector& now, double last_part, double part) {
  if (last_part == 0) return now;
  return now + (part / last_part) * (now - before);
}

}  // namespace

StaticSolution static_solution(const SecondOrderSystem& system, const Vector& load) {
  constexpr double kSmallest = 1.0 / 4096.0;
  StaticSolution solution;
  solution.u = Vector::Zero(system.size);
  StepEquation equation{0.0, 0.0, {{1.0, 1.0}}, Vector::Zero(system.size), Vector()};
  Vector before = solution.u;
  double reached = 0, part = 1, last_part = 0, energy = 0;
  SolveReport report;
  while (reached < 1) {
    part = std::min(part, 1 - reached);
    equation.constant = -(reached + part) * load;
    Vector u = guess(before, solution.u, last_part, part);
    report = system.solve(equation, energy, u);
    add(report, solution);
    if (!report.converged) {
      part *= 0.5;
      if (part < kSmallest)
        throw Failure(
            {ErrorKind::kSolver,
             text("the static solution did not converge beyond %.4g of the load: residual "
                  "%.1e after %d iterations. A smaller load (--scale) may be borne",
                  reached, report.residual / report.scale, report.iterations)});
      continue;
    }
    // In units of the whole load's linear compliance, whatever the first part was.
    if (energy == 0) energy = std::pow(report.scale / part, 2);
    before = std::exchange(solution.u, std::move(u));
    last_part = part;
    reached = reached + part >= 1 ? 1 : reached + part;
    part *= 2;
    ++solution.load_steps;
  }
  solution.residual = report.scale == 0 ? 0.0 : report.residual / report.scale;
  solution.energy = system.energy(solution.u);
  solution.work = load.dot(solution.u);
  return solution;
}

}  // namespace tremolo
