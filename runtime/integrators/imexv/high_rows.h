// The implicit half of the splitting methods: the midpoint rule on the high rows alone, while the
// low rows move from q0_l to q1_l independently.
#pragma once

#include <memory>

#include <Eigen/Core>

#include "runtime/integrators/solve/damping.h"
#include "runtime/integrators/solve/newton.h"
#include "runtime/integrators/solve/strain_damping.h"
#include "runtime/kernels/potential.h"

namespace tremolo {

// Form of the damping force on the high rows.
enum class HighDamping {
  kMeanVelocity,  // D d/h, with theta of runtime/integrators/solve/damping.h: second order
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
