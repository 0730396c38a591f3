#include "precompute/reference/full/step_equation.h"

#include <algorithm>
#include <cmath>

#include "common/text.h"
#include "precompute/system/failure.h"

namespace tremolo {

double first_minimum(double slope, double curvature, double slope_half, double slope_one,
                     double most) {
  const double whole = slope_one - slope - curvature;
  const double half = slope_half - slope - 0.5 * curvature;
  const double cubic = 2.0 * whole - 8.0 * half, square = 8.0 * half - whole;
  const auto at = [&](double t) { return slope + t * (curvature + t * (square + t * cubic)); };
  // Between neighbouring extrema the slope changes its sign at most once.
  std::vector<double> ends = {0.0};
  const double discriminant = square * square - 3.0 * cubic * curvature;
  if (discriminant > 0) {
    const double q = -(square + std::copysign(std::sqrt(discriminant), square));
    for (const double t : {q == 0 ? most : curvature / q, cubic == 0 ? most : q / (3.0 * cubic)})
      if (t > 0 && t < most) ends.push_back(t);
  }
  std::sort(ends.begin(), ends.end());
  ends.push_back(most);
  for (std::size_t i = 1; i < ends.size(); ++i) {
    double low = ends[i - 1], high = ends[i];
    if (!(at(high) > 0)) continue;
    for (int k = 0; k < 60; ++k) {
      const double middle = 0.5 * (low + high);
      (at(middle) > 0 ? high : low) = middle;
    }
    return high;
  }
  return most;
}

void move_along(const std::function<Vector(const Vector&)>& gradient, const Direction& direction,
                Vector& d, Vector& g) {
  constexpr double kEnough = 0.5;
  constexpr double kFarthest = 16.0;
  const double slope = g.dot(direction.step);
  Vector end = d + direction.step;
  Vector end_gradient = gradient(end);
  const double end_slope = end_gradient.dot(direction.step);
  if (!(direction.curvature > 0 && std::abs(end_slope) <= kEnough * std::abs(slope))) {
    const double half_slope = gradient(d + 0.5 * direction.step).dot(direction.step);
    end = d + first_minimum(slope, direction.curvature, half_slope, end_slope, kFarthest) *
                  direction.step;
    end_gradient = gradient(end);
  }
  d = std::move(end);
  g = std::move(end_gradient);
}

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
