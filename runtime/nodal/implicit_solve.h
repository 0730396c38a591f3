// The equation of an implicit step, solved for x1 by Newton's method:
//
//     mu M (x1 - x^) = f(x*, v*),    x* = x0 + theta (x1 - x0),    v* = kappa (x1 - x0) + v^
//
// or with NodalSystem::step_force(x0, x1) on its right, and the reactions of NodalSystem::contact()
// at x1 added to it: after each solve these are revised, and it goes on where they change. Newton's
// matrix is mu M + theta K + kappa D, as it is where that is positive definite, so that the last
// steps converge quadratically; else with what makes it indefinite left out. A line search takes
// care of what that leaves.
#pragma once

#include <memory>
#include <optional>

#include "runtime/nodal/mixed_steps.h"
#include "runtime/nodal/nodal_integrator.h"
#include "runtime/sparse/block_cholesky.h"
#include "runtime/sparse/conjugate_gradients.h"

namespace tremolo {

// h: of step_force, which is used if it is positive. x_hat, v_hat: 3n; must outlive the solve.
struct ImplicitEquation {
  double mu = 0.0, theta = 1.0, kappa = 0.0;
  const Eigen::VectorXd* x0 = nullptr;
  const Eigen::VectorXd* x_hat = nullptr;
  const Eigen::VectorXd* v_hat = nullptr;
  ForcePart part = ForcePart::kAll;
  double h = 0.0;
  double share = 1.0;  // of the impulse h f that the step takes of a reaction f (NodalContact)
};

class ImplicitSolve {
 public:
  // kSystem: no memory for a factor that was asked for.
  static Result<std::unique_ptr<ImplicitSolve>> create(const NodalSystem& system,
                                                       const NodalOptions& options);

  // x1: comes in as a first guess in which held nodes are where they go, and leaves as the
  // solution. iterations: at most so many. False where it does not converge or is not finite; x1 is
  // then anything. once: one Newton step from the guess is the answer. Adds to the report's
  // iterations; sets its residual.
  bool solve(const ImplicitEquation& equation, Eigen::VectorXd& x1, bool once, NodalReport& report);

  // The force of the last residual, at the solution.
  const Eigen::VectorXd& force() const { return f_; }
  // Work of step_force() there.
  const StepWork& work() const { return work_; }

 private:
  static constexpr int kMostCgIterations = 5000;

  ImplicitSolve(const NodalSystem& system, const NodalOptions& options);
  bool converge(const ImplicitEquation& equation, Eigen::VectorXd& x1, NodalReport& report);
  bool solve_once(const ImplicitEquation& equation, Eigen::VectorXd& x1, NodalReport& report);
  bool revise(const ImplicitEquation& equation, const Eigen::VectorXd& x1);
  double residual(const ImplicitEquation& equation, const Eigen::VectorXd& x1);
  bool direction(const ImplicitEquation& equation, const Eigen::VectorXd& x1, double target,
                 bool once);
  void assemble(const ImplicitEquation& equation, const Eigen::VectorXd& x1, bool full);
  bool solve_system(double target, bool once);
  double rounding(const Eigen::VectorXd& x1) const;
  // From x1 with the residual `size` to trial_, with the residual that is returned; nothing where
  // no part of the step is of use.
  std::optional<double> search(const ImplicitEquation& equation, const Eigen::VectorXd& x1,
                               double size, double limit);

  const NodalSystem& system_;
  NodalOptions options_;
  BlockMatrix matrix_;
  std::optional<BlockCholesky> factor_;
  std::optional<ConjugateGradients> gradients_;
  // Conjugate gradients are given up after so many iterations: a factor takes less then.
  int worth_ = kMostCgIterations;
  int factored_ = 0;  // systems that the factor still solves before they are tried again
  // Residual from which on the full tangent is tried: below that at which it was indefinite.
  double full_limit_ = 0.0;
  bool full_ = false;  // the direction is of the full tangent
  MixedSteps steps_;
  Eigen::VectorXd x_, v_, f_, r_, d_, trial_, base_;
  StepWork work_;
};

}  // namespace tremolo
