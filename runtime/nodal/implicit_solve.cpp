#include "runtime/nodal/implicit_solve.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tremolo {
namespace {

// Above so many nodes conjugate gradients take less time and memory than a factor (measured on
// sheets, docs/cloth.md).
constexpr std::size_t kMostFactored = 60'000;
constexpr int kLineHalvings = 10;
constexpr int kMostCgIterations = 5'000;
// Of an inexact Newton step: its linear residual over the residual.
constexpr double kForcing = 1e-2;

}  // namespace

ImplicitSolve::ImplicitSolve(const NodalSystem& system, const NodalOptions& options)
    : system_(system),
      options_(options),
      matrix_(system.pattern()),
      x_(Eigen::VectorXd::Zero(3 * system.mass().size())),
      v_(x_),
      f_(x_),
      r_(x_),
      d_(x_),
      trial_(x_) {}

Result<std::unique_ptr<ImplicitSolve>> ImplicitSolve::create(const NodalSystem& system,
                                                             const NodalOptions& options) {
  std::unique_ptr<ImplicitSolve> made(new ImplicitSolve(system, options));
  const bool small = system.size() <= kMostFactored;
  if (options.solver == NodalSolver::kCholesky ||
      (options.solver == NodalSolver::kAutomatic && small)) {
    Result<BlockCholesky> factor = BlockCholesky::create(system.pattern());
    if (factor)
      made->factor_ = std::move(*factor);
    else if (options.solver == NodalSolver::kCholesky)
      return factor.error();
  }
  if (!made->factor_) made->gradients_.emplace(*system.pattern());
  return made;
}

// Leaves f_ and r_ = f - mu M (x1 - x^), zero at held nodes; returns |r_|.
double ImplicitSolve::residual(const ImplicitEquation& equation, const Eigen::VectorXd& x1) {
  const Eigen::VectorXd& x0 = *equation.x0;
  if (equation.h > 0.0) {
    work_ = system_.step_force(x0, x1, equation.h, f_);
  } else {
    x_ = x0 + equation.theta * (x1 - x0);
    v_ = *equation.v_hat + equation.kappa * (x1 - x0);
    system_.force(x_, v_, equation.part, f_);
  }
  const Eigen::VectorXd& mass = system_.mass();
  const std::span<const std::uint8_t> held = system_.held();
  const Eigen::VectorXd& x_hat = *equation.x_hat;
  double square = 0.0;
  for (Eigen::Index i = 0; i < mass.size(); ++i) {
    if (held[static_cast<std::size_t>(i)] != 0) {
      r_.segment<3>(3 * i).setZero();
      continue;
    }
    r_.segment<3>(3 * i) =
        f_.segment<3>(3 * i) -
        (equation.mu * mass[i]) * (x1.segment<3>(3 * i) - x_hat.segment<3>(3 * i));
    square += r_.segment<3>(3 * i).squaredNorm();
  }
  return std::sqrt(square);
}

// d_ = A^-1 r_ at x1; false where there is none.
bool ImplicitSolve::direction(const ImplicitEquation& equation, const Eigen::VectorXd& x1,
                              double target, bool once) {
  const Eigen::VectorXd& mass = system_.mass();
  matrix_.set_zero();
  for (Eigen::Index i = 0; i < mass.size(); ++i)
    matrix_.diagonal(static_cast<std::size_t>(i)).diagonal().setConstant(equation.mu * mass[i]);
  if (equation.h > 0.0)
    system_.add_step_tangent(*equation.x0, x1, equation.h, matrix_);
  else
    system_.add_tangent(x_, v_, equation.part, equation.theta, equation.kappa, matrix_);
  matrix_.hold(system_.held());
  if (factor_) {
    if (!factor_->factor(matrix_)) return false;
    d_ = r_;
    factor_->solve(d_);
    return d_.allFinite();
  }
  d_.setZero();
  const double size = r_.norm();
  const double enough = once ? 0.1 * target : std::max(0.1 * target, kForcing * size);
  const CgReport solved =
      gradients_->solve(matrix_, r_, d_, std::min(enough, 0.5 * size), kMostCgIterations);
  return solved.positive && d_.allFinite();
}

// What rounding of the positions leaves of the residual, N.
double ImplicitSolve::rounding(const Eigen::VectorXd& x1) const {
  double stiffest = 0.0;
  for (std::size_t i = 0; i < system_.size(); ++i)
    stiffest = std::max(stiffest, matrix_.diagonal(i).diagonal().maxCoeff());
  return 4.0 * std::numeric_limits<double>::epsilon() * stiffest * x1.lpNorm<Eigen::Infinity>() *
         std::sqrt(static_cast<double>(x1.size()));
}

bool ImplicitSolve::solve(const ImplicitEquation& equation, Eigen::VectorXd& x1, bool once,
                          NodalReport& report) {
  const double load = system_.load_size();
  const double target = options_.tolerance * load;
  double size = residual(equation, x1);
  for (int k = 0; k < options_.max_iterations; ++k) {
    report.residual = size / load;
    if (!std::isfinite(size)) return false;
    if (!once && size <= target) return true;
    if (!direction(equation, x1, target, once)) return false;
    ++report.iterations;
    if (once) {
      x1 += d_;
      return std::isfinite(residual(equation, x1));
    }
    const double limit = std::max(target, rounding(x1));
    const double slope = d_.dot(r_);
    double share = 1.0, next = 0.0;
    int halved = 0;
    for (;; share *= 0.5) {
      trial_ = x1 + share * d_;
      next = residual(equation, trial_);
      // The residual falls, or, as it may rise on the way to a minimum where Newton's matrix leaves
      // terms out, what is left of it along the direction does (Matthies and Strang 1979).
      if (next <= limit || next <= (1.0 - 1e-4 * share) * size) break;
      if (std::isfinite(next) && std::abs(d_.dot(r_)) <= 0.8 * std::abs(slope)) break;
      if (++halved > kLineHalvings) return size <= limit;
    }
    x1.swap(trial_);
    size = next;
    report.residual = size / load;
    if (size <= limit) return true;
  }
  return false;
}

}  // namespace tremolo
