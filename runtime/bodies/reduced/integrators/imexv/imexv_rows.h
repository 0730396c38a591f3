// The rows of the methods imexv that are taken implicitly: damped ones, high ones.
#pragma once

#include <memory>

#include <Eigen/Core>
#include <Eigen/LU>

#include "runtime/bodies/reduced/integrators/solve/damping.h"
#include "runtime/bodies/reduced/integrators/solve/newton.h"
#include "runtime/bodies/reduced/integrators/solve/strain_damping.h"
#include "runtime/integrator.h"
#include "runtime/math/kernels/potential.h"

namespace tremolo {

// The middle of `imexv` where the damping depends on q (solve/strain_damping.h). It couples low and
// high rows. Therefore all of them are solved for, with all of the damping included.
//
//     low rows     d - h p + (h/2) [D d + rest(qm) d] = 0
//     high rows    (d - h p)/g + (h^2/2) [R(qm) - f] + (h/2) [D d + rest(qm) d] = 0
//
//     p <- p + (2/g) (d/h - p),  q <- q + d,        qm = q + d/2,  g = 1 on the low rows
//
// The kicks of the low rows before and after have no damping. Newton's method uses LU, because R's
// dependence on the low rows makes the Jacobian unsymmetric.

// D of all rows, and g with theta of the high rows, reduced by stiff_share(); 1 on low rows.
DampedMidpoint make_split_midpoint(const Model& model, const IntegratorOptions& options,
                                   Split split);

class DampedRows {
 public:
  // The model must outlive this.
  DampedRows(const Model& model, const IntegratorOptions& options);

  // Advances all rows, low of them explicit. f: the load's average over the step, r. dissipated:
  // exact for these rows, J. If it does not converge, the state is as before.
  StepReport advance(Split split, StrainDamping& strain, State& state, const Eigen::VectorXd& f);

 private:
  const Model& model_;
  IntegratorOptions options_;
  DampedMidpoint midpoint_;
  Eigen::VectorXd high_g_;  // g as if all rows were high
  PotentialWorkspace workspace_;
  Evaluation at_;
  Eigen::VectorXd d_, qm_, rest_, residual_, dp_;
  Eigen::MatrixXd jacobian_;
  Eigen::PartialPivLU<Eigen::MatrixXd> factor_;
};

// The implicit half of the splitting methods: the midpoint rule on the high rows alone, while the
// low rows move from q0_l to q1_l independently.

// Form of the damping force on the high rows.
enum class HighDamping {
  kMeanVelocity,  // D d/h, with theta of runtime/bodies/reduced/integrators/solve/damping.h: second
                  // order
  kEndVelocity,   // D p1, p1 = 2 d/h - p0: first order, the thesis's
};

// Criterion for convergence of the solve.
enum class SolveNorm {
  kRelative,  // |residual|_2 <= tolerance * max(h |p|, h^2 |R|, h^2 |f|) over the high rows
  kAbsolute,  // max |residual_i| <= tolerance
};

// Buffers shared by HighRows that are used one at a time. Their contents are undefined between
// calls.
struct HighScratch {
  explicit HighScratch(const Potential& potential)
      : workspace(potential.make_workspace(kUseSegment)),
        evaluation(potential.make_evaluation()),
        qm(Eigen::VectorXd::Zero(potential.size())) {}

  PotentialWorkspace workspace;
  Evaluation evaluation;
  Eigen::VectorXd qm;  // r
};

class HighRows {
 public:
  // The model must outlive this. scratch: null makes its own.
  HighRows(const Model& model, Split split, const IntegratorOptions& options, HighDamping damping,
           SolveNorm norm, std::shared_ptr<HighScratch> scratch = nullptr);

  // q0: before the step, r. state: low rows of q already at the step's end, high rows of q and p
  // before it. f: average of the load over the step, r. Solves
  //     (d - h p0)/g + (h^2/2) [R(qm) + damping force - f]_h = 0,      p1 = p0 + (2/g) (d/h - p0)
  // with g = 1 + 2 theta h D, or 1 for kEndVelocity, and moves the high rows of state to the end;
  // they are unchanged if it does not converge. The damping force has its rest at qm, with the mean
  // velocity of all rows. dissipated: energy that damping took from the high rows, J.
  StepReport advance(const Eigen::VectorXd& q0, State& state, const Eigen::VectorXd& f);

  // rest(qm) d of StrainDamping in the last step, d the change of all rows: the impulse of that
  // damping, r. It has acted on the high rows; the caller applies it to the low rows.
  const Eigen::VectorXd& rest() const { return rest_; }

 private:
  double evaluate(const Eigen::VectorXd& q0, const State& state, const Eigen::VectorXd& f);

  const Potential& potential_;
  Split split_;
  DampedMidpoint midpoint_;
  double tolerance_;
  int max_iterations_;
  HighDamping damping_;
  SolveNorm norm_;
  std::shared_ptr<HighScratch> scratch_;
  NewtonWorkspace newton_;  // d_h
  StrainDamping strain_;
  Eigen::VectorXd lambda_;    // of the high rows
  Eigen::VectorXd d_, rest_;  // of all rows
};

}  // namespace tremolo
