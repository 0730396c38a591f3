// The equation of an implicit step, solved for x1 by Newton's method:
//
//     mu M (x1 - x^) = f(x*, v*),    x* = x0 + theta (x1 - x0),    v* = kappa (x1 - x0) + v^
//
// or with NodalSystem::step_force(x0, x1) on its right-hand side. The reactions of
// NodalSystem::contact() at x1 are added; after each solve they are revised, and the solve
// continues where they change.
//
// Newton's matrix is mu M + theta K + kappa D where that is positive definite, so that the last
// steps converge quadratically; otherwise indefinite terms are left out. A line search corrects for
// that. Where x1 is sought as a minimum (ImplicitEquation), only so much of them is left out as
// makes the matrix positive definite, and reactions are revised before their solve is exact.
#pragma once

#include <memory>
#include <optional>

#include <Eigen/Core>

#include "runtime/math/sparse/block_cholesky.h"
#include "runtime/math/sparse/conjugate_gradients.h"
#include "runtime/step/left_out_terms.h"
#include "runtime/step/nodal_integrator.h"

namespace tremolo {

// Computes a better step from the last ones, for iterations x <- x + p(x) whose steps p shrink
// slowly. This is Anderson's mixing (1965); on a linear problem it is GMRES preconditioned by the
// iteration.
//
// Let dX and dP be the differences of the last positions and steps, and g the combination that
// minimizes |p - dP g|. It shows how much of p the last steps could have saved: the step is p - (dX
// + dP) g.
class MixedSteps {
 public:
  // size: of x. All memory is allocated here: 2 kept() + 2 vectors.
  explicit MixedSteps(Eigen::Index size);

  static constexpr Eigen::Index kept() { return kKept; }

  // Forgets all steps.
  void clear() { count_ = total_ = 0; }

  // Adds the step p at x and computes the better step `mixed`. False if there is none: at first,
  // and where the differences are not informative. Nothing is allocated.
  bool mix(const Eigen::VectorXd& x, const Eigen::VectorXd& p, Eigen::VectorXd& mixed);

 private:
  static constexpr Eigen::Index kKept = 8;
  using Small = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kKept, kKept>;

  Eigen::MatrixXd dx_, dp_;  // one column per difference; the oldest is overwritten
  Eigen::VectorXd x_, p_;    // the last position and step
  Eigen::Matrix<double, kKept, kKept> products_;  // dP^T dP
  Eigen::Index count_ = 0;                        // number of filled columns
  Eigen::Index total_ = 0;                        // steps since clear()
};

// The coefficients of the equation.
struct ImplicitEquation {
  double mu = 0.0, theta = 1.0, kappa = 0.0;
  // The vectors are 3n long and must outlive the solve.
  const Eigen::VectorXd* x0 = nullptr;
  const Eigen::VectorXd* x_hat = nullptr;
  const Eigen::VectorXd* v_hat = nullptr;
  ForcePart part = ForcePart::kAll;
  double h = 0.0;  // of step_force, which is used if h is positive, s
  // Fraction of the impulse h f of a reaction f that the step uses (NodalContact).
  double share = 1.0;
  // x1 is a minimum of mu/2 |x1 - x^|_M^2 + V(x1), forces without a potential aside: the search
  // may go wherever that falls.
  bool minimum = false;
};

class ImplicitSolve {
 public:
  // Error kSystem: no memory for a requested factor.
  static Result<std::unique_ptr<ImplicitSolve>> create(const NodalSystem& system,
                                                       const NodalOptions& options);

  // Solves the equation. x1: in, a first guess with fixed nodes at their ends; out, the solution.
  // once: one Newton step from the guess is the answer. Adds to the report's iterations, of which
  // there are at most NodalOptions::max_iterations in each convergence; sets its residual. False:
  // it does not converge or is not finite; x1 is then undefined.
  bool solve(const ImplicitEquation& equation, Eigen::VectorXd& x1, bool once, NodalReport& report);

  // The force of the last residual, at the solution.
  const Eigen::VectorXd& force() const { return f_; }
  // Work of step_force() there.
  const StepWork& work() const { return work_; }

  // Saves or restores what the next solve depends on.
  void carry(StateStream& stream) { stream(factored_); }

 private:
  static constexpr int kMostCgIterations = 5000;

  ImplicitSolve(const NodalSystem& system, const NodalOptions& options);
  bool converge(const ImplicitEquation& equation, double tolerance, Eigen::VectorXd& x1,
                NodalReport& report);
  bool solve_once(const ImplicitEquation& equation, Eigen::VectorXd& x1, NodalReport& report);
  bool revise(const ImplicitEquation& equation, const Eigen::VectorXd& x1);
  double residual(const ImplicitEquation& equation, const Eigen::VectorXd& x1);
  bool direction(const ImplicitEquation& equation, const Eigen::VectorXd& x1, double target,
                 bool once);
  void assemble(const ImplicitEquation& equation, const Eigen::VectorXd& x1);
  bool solve_system(double target, bool once);
  double rounding(const Eigen::VectorXd& x1) const;
  // Sets lacks_ for the first matrix at a residual, and after one that was indefinite.
  void begin_lacking(const ImplicitEquation& equation, double size, bool once);
  void lack_more(const ImplicitEquation& equation, double size);
  // Searches from x1 with the residual `size`; sets trial_ and returns its residual. Empty: no part
  // of the step lowers the residual.
  std::optional<double> search(const ImplicitEquation& equation, const Eigen::VectorXd& x1,
                               double size, double limit);

  const NodalSystem& system_;
  NodalOptions options_;
  BlockMatrix matrix_;
  std::optional<BlockCholesky> factor_;
  std::optional<ConjugateGradients> gradients_;
  // Iterations after which conjugate gradients are given up, because a factor takes less time.
  int worth_ = kMostCgIterations;
  // Systems that the factor still solves before conjugate gradients are tried again.
  int factored_ = 0;
  // Residual below which the full tangent is tried; it was indefinite at a larger one.
  double full_limit_ = 0.0;
  LeftOutTerms lacks_;
  MixedSteps steps_;
  Eigen::VectorXd x_, v_, f_, r_, d_, trial_, base_;
  StepWork work_;
};

}  // namespace tremolo
