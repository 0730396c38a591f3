// Common base of the methods that solve for all coordinates at once, with R and K at one position
// of the step.
#pragma once

#include "runtime/bodies/reduced/integrators/one_step.h"
#include "runtime/bodies/reduced/integrators/solve/newton.h"

namespace tremolo {

class ImplicitStep : public OneStep {
 protected:
  ImplicitStep(std::string_view name, Model::Pointer model, const IntegratorOptions& options)
      : OneStep(name, std::move(model), options, kWantForce, kUseTangent),
        tolerance_(options.tolerance),
        max_iterations_(options.max_iterations),
        newton_(model_->modes()),
        qm_(D_) {
    strain_.set_tolerance(tolerance_);
  }

  // Residual of the step with R at qm = q0 + theta d, for d = newton_.unknowns:
  //
  //     d - h p0 + theta h^2 [R(qm) + D d/h - f]
  //
  // On request it also computes the Jacobian I + theta^2 h^2 K(qm) + theta h D. D has its rest at
  // qm; the Jacobian approximates that by beta (K - Lambda). f: average of the load over the step.
  // Returns relative_residual().
  double evaluate_one_stage(double theta, const State& z0, const Eigen::VectorXd& f,
                            bool jacobian) {
    const double h = h_;
    const Eigen::VectorXd& d = newton_.unknowns;
    qm_ = z0.q + theta * d;
    const auto& [V, R, K] = V_.evaluate(qm_, jacobian ? kWantForce | kWantTangent : kWantForce);
    newton_.residual = d - h * z0.p + (theta * h * h) * (R - f) + (theta * h) * D_.cwiseProduct(d);
    if (strain_.present()) {
      rest_work_ = strain_.force(qm_, d, rest_) / h;
      newton_.residual += (theta * h) * rest_;
    }
    if (jacobian) {
      const double beta = strain_.beta();
      newton_.jacobian = (theta * theta * h * h + theta * h * beta) * K;
      newton_.jacobian.diagonal().array() += 1.0 + theta * h * D_.array();
      if (strain_.present()) newton_.jacobian.diagonal() -= (theta * h * beta) * model_->lambda();
    }
    return relative_residual(newton_.residual.norm(), tolerance_, h, z0.p.norm(), R.norm(),
                             f.norm());
  }

  // Sets d = h p0, the start of a solve.
  void begin_solve(double theta, const State& z0) {
    newton_.unknowns = h_ * z0.p;
    if (!strain_.present()) return;
    qm_ = z0.q + theta * newton_.unknowns;
    strain_.stand_at(qm_);
  }

  // d.D d/h, the energy that damping took along d, J.
  double dissipated() const { return dissipation(newton_.unknowns) / h_ + rest_work_; }

  double tolerance_;
  int max_iterations_;
  NewtonWorkspace newton_;
  Eigen::VectorXd qm_;      // position at which R and K are evaluated
  double rest_work_ = 0.0;  // d.rest(qm) d/h, J
};

}  // namespace tremolo
