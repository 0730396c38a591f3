#include "runtime/step/implicit_solve.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>

namespace tremolo {
namespace {

// With more nodes than this no factor is used: it takes more than some hundred megabytes.
constexpr std::size_t kMostFactored = 60'000;
// Time of an iteration of conjugate gradients per block, in multiplications of a factorisation (5
// ns over 0.11 ns, measured on sheets of 2 500 and 10 000 nodes).
constexpr double kIterationCost = 45.0;
// Number of systems solved by the factor after one for which conjugate gradients took too long.
constexpr int kFactored = 5;
constexpr int kLineHalvings = 10;
// Fewer iterations than this are not worth a trial.
constexpr int kLeastWorth = 20;
// Linear residual of an inexact Newton step over the residual. More digits after a step that shrank
// it well (Eisenstat and Walker 1996) saved no step on hanging sheets and took a sixth more
// iterations of conjugate gradients: the rotation of the springs limits the steps.
constexpr double kForcing = 0.1;

// A full tangent that was indefinite is tried again at this fraction of that residual.
constexpr double kFullAgain = 0.3;
// The first tolerance of a minimum with reactions, in loads, and its fraction after each revision.
constexpr double kLoose = 10.0;
constexpr double kTighter = 1.0 / 3.0;

}  // namespace

ImplicitSolve::ImplicitSolve(const NodalSystem& system, const NodalOptions& options)
    : system_(system),
      options_(options),
      matrix_(system.pattern()),
      steps_(3 * system.mass().size()),
      x_(Eigen::VectorXd::Zero(3 * system.mass().size())),
      v_(x_),
      f_(x_),
      r_(x_),
      d_(x_),
      trial_(x_),
      base_(x_) {}

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
  if (options.solver == NodalSolver::kCholesky) return made;
  if (made->factor_)
    made->worth_ = static_cast<int>(
        std::min(static_cast<double>(kMostCgIterations),
                 made->factor_->multiplications() /
                     (kIterationCost * static_cast<double>(system.pattern()->blocks()))));
  if (made->worth_ >= kLeastWorth) made->gradients_.emplace(*system.pattern());
  return made;
}

// Sets f_ and r_ = f - mu M (x1 - x^), zero at fixed nodes; returns |r_|.
double ImplicitSolve::residual(const ImplicitEquation& equation, const Eigen::VectorXd& x1) {
  const Eigen::VectorXd& x0 = *equation.x0;
  if (equation.h > 0.0) {
    work_ = system_.step_force(x0, x1, equation.h, f_);
  } else {
    x_ = x0 + equation.theta * (x1 - x0);
    v_ = *equation.v_hat + equation.kappa * (x1 - x0);
    system_.force(x_, v_, equation.part, f_);
  }
  if (const NodalContact* contact = system_.contact()) contact->add_force(x1, f_);
  const Eigen::VectorXd& mass = system_.mass();
  const std::span<const std::uint8_t> held = system_.held();
  const Eigen::VectorXd& x_hat = *equation.x_hat;
  double square = 0.0;
  for (Eigen::Index i = 0; i < mass.size(); ++i) {
    if (held[i] != 0) {
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

void ImplicitSolve::assemble(const ImplicitEquation& equation, const Eigen::VectorXd& x1) {
  const double share = lacks_.kept();
  const Eigen::VectorXd& mass = system_.mass();
  matrix_.set_zero();
  for (Eigen::Index i = 0; i < mass.size(); ++i)
    matrix_.diagonal(static_cast<std::size_t>(i)).diagonal().setConstant(equation.mu * mass[i]);
  if (equation.h > 0.0)
    system_.add_step_tangent(*equation.x0, x1, equation.h, share, matrix_);
  else
    system_.add_tangent(x_, v_, equation.part, equation.theta, equation.kappa, share, matrix_);
  if (const NodalContact* contact = system_.contact()) contact->add_tangent(matrix_);
  matrix_.hold(system_.held());
}

// d_ = A^-1 r_; false if that does not exist.
bool ImplicitSolve::solve_system(double target, bool once) {
  const bool try_gradients = gradients_ && (!factor_ || --factored_ <= 0);
  if (try_gradients) {
    d_.setZero();
    const double size = r_.norm();
    const double enough = once ? 0.1 * target : std::max(0.1 * target, kForcing * size);
    const CgReport solved =
        gradients_->solve(matrix_, r_, d_, std::min(enough, 0.5 * size), worth_);
    if (lacks_.fraction() < 1.0 && !solved.positive) return false;
    const bool good = solved.positive && d_.allFinite();
    if (!factor_ || (good && solved.converged)) return good;
    factored_ = kFactored;
  }
  if (!factor_->factor(matrix_)) return false;
  d_ = r_;
  factor_->solve(d_);
  return d_.allFinite();
}

void ImplicitSolve::begin_lacking(const ImplicitEquation& equation, double size, bool once) {
  if (once)
    lacks_.set(1.0);
  else if (equation.minimum)
    lacks_.less();
  else
    lacks_.set(size <= full_limit_ ? 0.0 : 1.0);
}

void ImplicitSolve::lack_more(const ImplicitEquation& equation, double size) {
  full_limit_ = kFullAgain * size;
  if (equation.minimum)
    lacks_.more();
  else
    lacks_.set(1.0);
}

// d_ = A^-1 r_ at x1; false if that does not exist.
bool ImplicitSolve::direction(const ImplicitEquation& equation, const Eigen::VectorXd& x1,
                              double target, bool once) {
  const double size = r_.norm();
  begin_lacking(equation, size, once);
  for (;;) {
    assemble(equation, x1);
    if (solve_system(target, once)) return true;
    if (lacks_.fraction() == 1.0) return false;
    lack_more(equation, size);
  }
}

// Rounding error of the residual from the positions, N.
double ImplicitSolve::rounding(const Eigen::VectorXd& x1) const {
  double stiffest = 0.0;
  for (std::size_t i = 0; i < system_.size(); ++i)
    stiffest = std::max(stiffest, matrix_.diagonal(i).diagonal().maxCoeff());
  return 4.0 * std::numeric_limits<double>::epsilon() * stiffest * x1.lpNorm<Eigen::Infinity>() *
         std::sqrt(static_cast<double>(x1.size()));
}

std::optional<double> ImplicitSolve::search(const ImplicitEquation& equation,
                                            const Eigen::VectorXd& x1, double size, double limit) {
  // The terms missing in Newton's matrix make its steps shrink slowly; the last steps show by how
  // much.
  const double slope = d_.dot(r_);
  if (lacks_.fraction() == 0.0 || equation.minimum) {
    steps_.clear();
  } else if (steps_.mix(x1, d_, trial_)) {
    trial_ += x1;
    const double next = residual(equation, trial_);
    if (next <= std::max(limit, size)) return next;
  }
  double share = 1.0;
  for (int halved = 0; halved <= kLineHalvings; ++halved, share *= 0.5) {
    trial_ = x1 + share * d_;
    const double next = residual(equation, trial_);
    if (next <= limit || next <= (1.0 - 1e-4 * share) * size) return next;
    // The residual may rise before a minimum where Newton's matrix lacks terms. Then its component
    // along the direction may fall instead (Matthies and Strang 1979). On the way to a minimum it
    // may also grow: the potential then falls faster.
    const double along = equation.minimum ? -d_.dot(r_) : std::abs(d_.dot(r_));
    if (std::isfinite(next) && along <= 0.8 * std::abs(slope)) return next;
  }
  return std::nullopt;
}

bool ImplicitSolve::revise(const ImplicitEquation& equation, const Eigen::VectorXd& x1) {
  NodalContact* contact = system_.contact();
  return contact != nullptr && contact->revise(*equation.x0, x1, equation.share);
}

bool ImplicitSolve::solve(const ImplicitEquation& equation, Eigen::VectorXd& x1, bool once,
                          NodalReport& report) {
  if (NodalContact* contact = system_.contact()) contact->start();
  if (once) return solve_once(equation, x1, report);
  const bool loose = equation.minimum && system_.contact() != nullptr;
  for (double tolerance = loose ? std::max(kLoose, options_.tolerance) : options_.tolerance;;) {
    if (!converge(equation, tolerance, x1, report)) return false;
    const bool exact = tolerance <= options_.tolerance, revised = revise(equation, x1);
    if (exact && !revised) return true;
    tolerance = std::max(options_.tolerance, revised ? kTighter * tolerance : 0.0);
  }
}

// Uses the same linearisation, at the guess, for all reactions.
bool ImplicitSolve::solve_once(const ImplicitEquation& equation, Eigen::VectorXd& x1,
                               NodalReport& report) {
  const double load = system_.load_size();
  base_ = x1;
  do {
    report.residual = residual(equation, base_) / load;
    if (!std::isfinite(report.residual)) return false;
    if (!direction(equation, base_, options_.tolerance * load, true)) return false;
    ++report.iterations;
    x1 = base_ + d_;
    if (!std::isfinite(residual(equation, x1))) return false;
  } while (revise(equation, x1));
  return true;
}

bool ImplicitSolve::converge(const ImplicitEquation& equation, double tolerance,
                             Eigen::VectorXd& x1, NodalReport& report) {
  const double load = system_.load_size();
  const double target = tolerance * load;
  double size = residual(equation, x1), limit = target;
  steps_.clear();
  full_limit_ = std::numeric_limits<double>::infinity();
  lacks_.set(0.0);
  for (int k = 0; k < options_.max_iterations; ++k) {
    report.residual = size / load;
    if (!std::isfinite(size)) return false;
    if (size <= target) return true;
    if (!direction(equation, x1, target, false)) return false;
    ++report.iterations;
    // The magnitude of the rounded numbers hardly changes.
    if (k == 0) limit = std::max(target, rounding(x1));
    const std::optional<double> next = search(equation, x1, size, limit);
    if (!next) return size <= limit;
    x1.swap(trial_);
    size = *next;
    report.residual = size / load;
    if (size <= limit) return true;
  }
  return false;
}

MixedSteps::MixedSteps(Eigen::Index size)
    : dx_(Eigen::MatrixXd::Zero(size, kKept)),
      dp_(Eigen::MatrixXd::Zero(size, kKept)),
      x_(Eigen::VectorXd::Zero(size)),
      p_(x_),
      products_(decltype(products_)::Zero()) {}

bool MixedSteps::mix(const Eigen::VectorXd& x, const Eigen::VectorXd& p, Eigen::VectorXd& mixed) {
  // Rounding would choose among differences that are closer to linear dependence.
  constexpr double kLeastShare = 1e-10;
  if (total_++ > 0) {
    const Eigen::Index column = (total_ - 2) % kKept;
    dx_.col(column) = x - x_;
    dp_.col(column) = p - p_;
    count_ = std::min(count_ + 1, kKept);
    for (Eigen::Index k = 0; k < count_; ++k)
      products_(k, column) = products_(column, k) = dp_.col(k).dot(dp_.col(column));
  }
  x_ = x;
  p_ = p;
  if (count_ == 0) return false;
  Small matrix = products_.topLeftCorner(count_, count_);
  matrix.diagonal() *= 1.0 + kLeastShare;
  Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kKept, 1> g(count_);
  for (Eigen::Index k = 0; k < count_; ++k) g[k] = dp_.col(k).dot(p);
  const Eigen::LLT<Small> factor(matrix);
  if (factor.info() != Eigen::Success) return false;
  factor.solveInPlace(g);
  if (!g.allFinite()) return false;
  mixed = p;
  for (Eigen::Index k = 0; k < count_; ++k) mixed -= g[k] * (dx_.col(k) + dp_.col(k));
  return true;
}

}  // namespace tremolo
