#include "precompute/reference/full/full_order_solver.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "precompute/system/failure.h"

namespace tremolo {
namespace {

// Computes values += mass M + rest K.
void add_constant_part(const FullOrder& body, double mass, double rest,
                       std::vector<double>& values) {
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] += mass * body.mass[i] + rest * body.stiffness[i];
}

// The K of a free body is singular: returns the multiple of M to be added for a factor. It is small
// relative to the stiffness, so that it only affects rigid motions.
double factor_shift(const FullOrder& body, const StepEquation& equation) {
  if (body.rigid.cols() == 0 || equation.mass > 0) return 0.0;
  double stiffness = 0, mass = 0;
  for (Eigen::Index i = 0; i < body.size(); ++i)
    for (int at = body.pattern.start[i]; at < body.pattern.start[i + 1]; ++at)
      if (body.pattern.column[at] == i) {
        stiffness += body.stiffness[at];
        mass += body.mass[at];
      }
  return 1e-8 * stiffness / mass;
}

void factorise(FullOrderSolver& solver, const std::vector<double>& values) {
  const SparseRows rows = rows_of(*solver.body, values);
  if (solver.factor == nullptr)
    solver.factor = std::make_unique<SparseCholesky>(rows);
  else
    solver.factor->factorise(rows);
}

// Factorises the tangent or, if that is indefinite, the equation's tangent at rest.
void renew_factor(FullOrderSolver& solver, const StepEquation& equation) {
  const FullOrder& body = *solver.body;
  const double shift = factor_shift(body, equation);
  solver.mass = equation.mass;
  solver.rest = equation.rest;
  solver.stale = false;
  std::vector<double> values = solver.tangent;
  if (shift != 0) add_constant_part(body, shift, 0.0, values);
  try {
    factorise(solver, values);
    return;
  } catch (const Failure& failure) {
    if (failure.error().kind != ErrorKind::kSolver) throw;
  }
  double rest = equation.rest;
  for (const SegmentPoint& point : equation.points)
    rest += point.weight * (point.rate ? 1.0 : point.fraction);
  std::fill(values.begin(), values.end(), 0.0);
  add_constant_part(body, equation.mass + shift, rest, values);
  try {
    factorise(solver, values);
  } catch (const Failure& failure) {
    if (failure.error().kind != ErrorKind::kSolver) throw;
    throw Failure({ErrorKind::kSolver,
                   "the stiffness at rest is singular: a part of the mesh moves without strain. "
                   "Hold it, or join it by faces"});
  }
}

// Returns P^-1 g on the complement of the rigid motions.
Vector precondition(FullOrderSolver& solver, const Vector& g) {
  Vector z;
  solver.factor->solve(g, z);
  remove_rigid_motion(*solver.body, z);
  return z;
}

// Solves H step = -g to the relative `reduction` in the preconditioner's norm; z = P^-1 g. At a
// direction of non-positive curvature it stops with a descent direction.
Direction conjugate_gradients(FullOrderSolver& solver, const Vector& g, const Vector& z,
                              double reduction, int most, int& iterations) {
  const FullOrder& body = *solver.body;
  Direction result{Vector::Zero(g.size()), 0.0};
  iterations = 0;
  Vector residual = -g, search = -z;
  double size = g.dot(z);
  const double target = reduction * reduction * size;
  while (iterations < most) {
    Vector image = multiply(body, solver.tangent, search);
    remove_rigid_force(body, image);
    const double curvature = search.dot(image);
    if (!(curvature > 0)) {
      if (iterations++ == 0) return {search, curvature};
      break;
    }
    const double length = size / curvature;
    result.step += length * search;
    residual -= length * image;
    ++iterations;
    const Vector next = precondition(solver, residual);
    const double next_size = residual.dot(next);
    if (!(next_size > target)) break;
    search = next + (next_size / size) * search;
    size = next_size;
  }
  result.curvature = -result.step.dot(g + residual);
  return result;
}

// Returns the number of solves that cost about as much as a factorisation; beyond it a new factor
// pays off.
int affordable_solves(const SparseCholesky& factor) {
  const double ratio = factor.flops() / (32.0 * static_cast<double>(factor.entries()));
  return static_cast<int>(std::clamp(ratio, 6.0, 40.0));
}

}  // namespace

Vector equation_gradient(const FullOrder& body, const StepEquation& equation, const Vector& d) {
  Vector g = segment_force(body, equation.points, equation.origin, d) + equation.constant;
  if (equation.mass != 0) g += equation.mass * multiply(body, body.mass, d);
  if (equation.rest != 0) g += equation.rest * multiply(body, body.stiffness, d);
  remove_rigid_force(body, g);
  return g;
}

void equation_tangent(const FullOrder& body, const StepEquation& equation, const Vector& d,
                      std::vector<double>& values) {
  segment_tangent(body, equation.points, equation.origin, d, values);
  add_constant_part(body, equation.mass, equation.rest, values);
}

namespace {

struct Iteration {
  Vector g;
  double last = 0;  // previous residual
};

// Writes the residual to the report and returns whether the iteration ends. stall_tolerance:
// relative residual that is accepted, as rounding, once the residual stagnates; the report contains
// its value.
bool finished(const FullOrderSolver& solver, double square, double stall_tolerance,
              Iteration& iteration, SolveReport& report) {
  report.residual = std::sqrt(std::max(0.0, square));
  if (report.scale == 0) report.scale = report.residual;
  if (!std::isfinite(square)) return true;
  const double relative = report.scale == 0 ? 0.0 : report.residual / report.scale;
  const bool stalled = report.iterations > 1 && relative <= stall_tolerance &&
                       report.residual > 0.5 * iteration.last;
  report.converged = relative <= solver.options.tolerance || stalled;
  return report.converged || report.iterations == solver.options.max_iterations;
}

// Iterates with the frozen factor and no tangent while each iteration halves the residual. Returns
// whether the solve is finished. If the residual has not decreased in total, d and g are restored.
bool iterate_frozen(FullOrderSolver& solver, const StepEquation& equation, Iteration& iteration,
                    Vector& d, SolveReport& report) {
  const FullOrder& body = *solver.body;
  SecantUpdates updates;
  const Vector start = d, start_gradient = iteration.g;
  double start_residual = 0;
  for (bool first = true;; first = false) {
    Vector step = -apply_inverse(
        updates, [&](const Vector& x) { return precondition(solver, x); }, iteration.g);
    const double square = -iteration.g.dot(step);
    if ((first || std::isfinite(square)) && finished(solver, square, 0.0, iteration, report))
      return true;
    if (!std::isfinite(square)) report.residual = std::numeric_limits<double>::infinity();
    if (first) start_residual = report.residual;
    if (!first && !(report.residual <= 0.5 * iteration.last)) {
      if (report.residual < start_residual) return false;
      d = start;
      iteration.g = start_gradient;
      return false;
    }
    iteration.last = report.residual;
    d += step;
    Vector next = equation_gradient(body, equation, d);
    add_pair(std::move(step), next - iteration.g, updates);
    iteration.g = std::move(next);
    ++report.iterations;
    ++report.linear_iterations;
  }
}

void iterate_newton(FullOrderSolver& solver, const StepEquation& equation, Iteration& iteration,
                    Vector& d, SolveReport& report) {
  const FullOrder& body = *solver.body;
  for (;; ++report.iterations) {
    equation_tangent(body, equation, d, solver.tangent);
    if (solver.stale || solver.factor == nullptr) {
      renew_factor(solver, equation);
      ++report.factorisations;
    }
    const Vector z = precondition(solver, iteration.g);
    if (finished(solver, iteration.g.dot(z), 1e-7, iteration, report)) return;
    iteration.last = report.residual;
    // Digits beyond the next Newton step's accuracy are wasted: the nonlinear remainder is of the
    // order of the squared residual.
    const double relative = report.residual / report.scale;
    const double reduction =
        std::max(0.3 * solver.options.tolerance / relative, std::min(0.1, relative));
    const int affordable = affordable_solves(*solver.factor);
    int linear_iterations = 0;
    const Direction direction =
        conjugate_gradients(solver, iteration.g, z, reduction, 4 * affordable, linear_iterations);
    report.linear_iterations += linear_iterations;
    if (linear_iterations > affordable) solver.stale = true;
    move_along([&](const Vector& at) { return equation_gradient(body, equation, at); }, direction,
               d, iteration.g);
  }
}

}  // namespace

SolveReport solve(FullOrderSolver& solver, const StepEquation& equation, double energy, Vector& d) {
  constexpr int kMany = 12;  // frozen iterations from which a new factor pays off
  const FullOrder& body = *solver.body;
  SolveReport report;
  report.scale = std::sqrt(energy);
  if (solver.mass != equation.mass || solver.rest != equation.rest) solver.stale = true;
  Iteration iteration{equation_gradient(body, equation, d)};
  // With the mass term the tangent changes little from step to step; without it (statics) it does.
  for (int tries = 0; equation.mass > 0 && tries < 2; ++tries) {
    if (solver.stale || solver.factor == nullptr) {
      equation_tangent(body, equation, d, solver.tangent);
      renew_factor(solver, equation);
      ++report.factorisations;
    }
    if (iterate_frozen(solver, equation, iteration, d, report)) {
      solver.stale = report.iterations > kMany;
      return report;
    }
    solver.stale = true;
  }
  iteration.last = std::numeric_limits<double>::infinity();  // Newton has not stalled yet
  iterate_newton(solver, equation, iteration, d, report);
  return report;
}

Vector linear_response(FullOrderSolver& solver, const Vector& force) {
  const StepEquation linear{0.0, 1.0, {}, Vector::Zero(force.size()), -force};
  Vector response = Vector::Zero(force.size());
  if (!solve(solver, linear, 0.0, response).converged)
    throw Failure({ErrorKind::kSolver, "the linear response to the load did not converge"});
  return response;
}

SecondOrderSystem make_system(FullOrderSolver& solver) {
  const FullOrder& body = *solver.body;
  return {body.size(), [&body](const Vector& x) { return multiply(body, body.mass, x); },
          [&body](const Vector& u, const Vector& d) { return strain_change_work(body, u, d); },
          [&body](const Vector& u) { return potential_energy(body, u); },
          [&solver](const StepEquation& equation, double energy, Vector& d) {
            return solve(solver, equation, energy, d);
          }};
}

void add_pair(Vector step, Vector change, SecantUpdates& updates) {
  constexpr std::size_t kMost = 12;
  const double product = step.dot(change);
  if (!(product > 0)) return;
  updates.pairs.push_back({std::move(step), std::move(change), product});
  if (updates.pairs.size() > kMost) updates.pairs.pop_front();
}

Vector apply_inverse(const SecantUpdates& updates,
                     const std::function<Vector(const Vector&)>& inverse, const Vector& g) {
  const auto& pairs = updates.pairs;
  std::vector<double> along(pairs.size());
  Vector rest = g;
  for (std::size_t i = pairs.size(); i-- > 0;) {
    along[i] = pairs[i].step.dot(rest) / pairs[i].product;
    rest -= along[i] * pairs[i].change;
  }
  Vector result = inverse(rest);
  for (std::size_t i = 0; i < pairs.size(); ++i)
    result += (along[i] - pairs[i].change.dot(result) / pairs[i].product) * pairs[i].step;
  return result;
}

}  // namespace tremolo
