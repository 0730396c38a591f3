#include "runtime/integrators/imexv/damped_rows.h"

#include <algorithm>
#include <cmath>

#include "runtime/integrators/solve/inertia_filter.h"
#include "runtime/integrators/solve/newton.h"

namespace tremolo {

using Eigen::Index;
using Eigen::VectorXd;

DampedMidpoint make_split_midpoint(const Model& model, const IntegratorOptions& options,
                                   Split split) {
  const VectorXd& lambda = model.lambda();
  DampedMidpoint midpoint = make_damped_midpoint(damping_rates(lambda, options.alpha, options.beta),
                                                 lambda, options.step);
  midpoint.g.head(split.low).setOnes();
  for (Index i = split.low; i < lambda.size(); ++i) {
    const double share = stiff_share(options.step * options.beta * lambda[i]);
    midpoint.g[i] = 1.0 + share * (midpoint.g[i] - 1.0);
  }
  return midpoint;
}

DampedRows::DampedRows(const Model& model, const IntegratorOptions& options)
    : model_(model),
      options_(options),
      midpoint_(make_split_midpoint(model, options, {0, model.modes()})),
      high_g_(midpoint_.g),
      workspace_(model.potential().make_workspace(kUseTangent)),
      at_(model.potential().make_evaluation()),
      jacobian_(Eigen::MatrixXd::Identity(model.modes(), model.modes())),
      factor_(jacobian_) {
  for (VectorXd* v : {&d_, &qm_, &rest_, &residual_, &dp_}) v->setZero(model.modes());
}

StepReport DampedRows::advance(Split split, StrainDamping& strain, State& state,
                               const VectorXd& f) {
  midpoint_.g = high_g_;
  midpoint_.g.head(split.low).setOnes();
  const auto& [h, D, g] = midpoint_;
  const double beta = strain.beta();
  const Index high = split.high;
  StepReport report;
  d_ = h * state.p;
  qm_ = state.q + 0.5 * d_;
  strain.stand_at(qm_);
  for (;; ++report.iterations) {
    qm_ = state.q + 0.5 * d_;
    model_.potential().evaluate(qm_, kWantForce | kWantTangent, workspace_, at_);
    const double rest_work = strain.force(qm_, d_, rest_) / h;
    residual_ = (d_ - h * state.p).cwiseQuotient(g) + (0.5 * h) * (D.cwiseProduct(d_) + rest_);
    residual_.tail(high) += (0.5 * h * h) * (at_.force - f).tail(high);
    report.residual = residual_.norm();
    const double ratio = relative_residual(report.residual, options_.tolerance, h, state.p.norm(),
                                           at_.force.tail(high).norm(), f.tail(high).norm());
    // A correction that is lost in the rounding of d is convergence too.
    report.converged =
        ratio <= 1.0 || (report.iterations > 0 && dp_.norm() <= kRounding * d_.norm());
    if (report.converged) {
      midpoint_.set_change(d_, state.p, dp_);
      report.dissipated = midpoint_.dissipated(d_, dp_) + rest_work;
      state.q += d_;
      state.p += dp_;
      return report;
    }
    if (!std::isfinite(ratio) || report.iterations == options_.max_iterations) return report;
    jacobian_ = (0.5 * h * beta) * at_.tangent;
    jacobian_.bottomRows(high) += (0.25 * h * h) * at_.tangent.bottomRows(high);
    jacobian_.diagonal() += g.cwiseInverse() + (0.5 * h) * (D - beta * model_.lambda());
    factor_.compute(jacobian_);
    dp_ = factor_.solve(residual_);
    d_ -= dp_;
  }
}

}  // namespace tremolo
