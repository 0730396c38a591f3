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
#pragma once

#include <Eigen/LU>

#include "runtime/integrator.h"
#include "runtime/integrators/solve/damping.h"
#include "runtime/integrators/solve/strain_damping.h"

namespace tremolo {

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

}  // namespace tremolo
