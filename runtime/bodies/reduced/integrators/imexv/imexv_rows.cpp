#include "runtime/bodies/reduced/integrators/imexv/imexv_rows.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "runtime/bodies/reduced/integrators/solve/inertia_filter.h"
#include "runtime/bodies/reduced/integrators/solve/newton.h"

namespace tremolo {

using Eigen::Index;
using Eigen::VectorXd;

DampedMidpoint make_split_midpoint(const Model& model, const IntegratorOptions& options,
                                   Split split) {
  const VectorXd& lambda = model.lambda();
  DampedMidpoint midpoint =
      make_damped_midpoint(damping_rates(lambda, options), lambda, options.step);
  midpoint.g.head(split.low).setOnes();
  for (Index i = split.low; i < lambda.size(); ++i) {
    const double share = stiff_share(options.beta, options.step, std::sqrt(lambda[i]));
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

HighRows::HighRows(const Model& model, Split split, const IntegratorOptions& options,
                   HighDamping damping, SolveNorm norm, std::shared_ptr<HighScratch> scratch)
    : potential_(model.potential()),
      split_(split),
      midpoint_(make_damped_midpoint(damping_rates(model.lambda(), options).tail(split.high),
                                     model.lambda().tail(split.high), options.step)),
      tolerance_(options.tolerance),
      max_iterations_(options.max_iterations),
      damping_(damping),
      norm_(norm),
      scratch_(scratch ? std::move(scratch) : std::make_shared<HighScratch>(potential_)),
      newton_(split.high),
      strain_(model, options.beta),
      lambda_(model.lambda().tail(split.high)),
      d_(Eigen::VectorXd::Zero(model.modes())),
      rest_(d_) {
  if (damping == HighDamping::kEndVelocity) midpoint_.g.setOnes();
}

StepReport HighRows::advance(const Eigen::VectorXd& q0, State& state, const Eigen::VectorXd& f) {
  const double h = midpoint_.h;
  if (strain_.present()) {
    d_.head(split_.low) = state.q.head(split_.low) - q0.head(split_.low);
    d_.tail(split_.high) = h * state.p.tail(split_.high);
    scratch_->qm = q0 + 0.5 * d_;
    strain_.stand_at(scratch_->qm);
    if (split_.high == 0) strain_.force(scratch_->qm, d_, rest_);
  }
  if (split_.high == 0) return {};
  Eigen::VectorXd& d = newton_.unknowns;
  auto p = state.p.tail(split_.high);
  d = h * p;
  scratch_->qm.head(split_.low) = 0.5 * (q0.head(split_.low) + state.q.head(split_.low));
  potential_.begin_trailing(scratch_->qm, split_.low, scratch_->workspace);
  StepReport report =
      solve_newton(newton_, max_iterations_, [&] { return evaluate(q0, state, f); });
  if (!report.converged) return report;
  Eigen::VectorXd& dp = newton_.correction;
  midpoint_.set_change(d, p, dp);
  state.q.tail(split_.high) += d;
  p += dp;
  // The force -D v acts along d: v is the mean or the end velocity.
  report.dissipated = damping_ == HighDamping::kMeanVelocity
                          ? midpoint_.dissipated(d, dp)
                          : (d.array() * midpoint_.D.array() * p.array()).sum();
  if (strain_.present()) report.dissipated += d.dot(rest_.tail(split_.high)) / h;
  return report;
}

double HighRows::evaluate(const Eigen::VectorXd& q0, const State& state, const Eigen::VectorXd& f) {
  const auto& [h, D, g] = midpoint_;
  const Eigen::Index high = split_.high;
  const Eigen::VectorXd& d = newton_.unknowns;
  const auto p = state.p.tail(high), f_high = f.tail(high);
  scratch_->qm.tail(high) = q0.tail(high) + 0.5 * d;
  potential_.evaluate_trailing(scratch_->qm, split_.low, kWantForce | kWantTangent,
                               scratch_->workspace, scratch_->evaluation);
  const auto R = scratch_->evaluation.force.tail(high);
  newton_.residual.array() = (d - h * p).array() / g.array() + (0.5 * h * h) * (R - f_high).array();
  const double beta = strain_.beta();
  newton_.jacobian =
      (0.25 * h * h + 0.5 * h * beta) * scratch_->evaluation.tangent.bottomRightCorner(high, high);
  if (strain_.present()) {
    d_.tail(high) = d;
    strain_.force(scratch_->qm, d_, rest_);
    newton_.residual += (0.5 * h) * rest_.tail(high);
    newton_.jacobian.diagonal() -= (0.5 * h * beta) * lambda_;
  }
  if (damping_ == HighDamping::kMeanVelocity) {
    newton_.residual.array() += (0.5 * h) * D.array() * d.array();
    newton_.jacobian.diagonal().array() += g.array().inverse() + (0.5 * h) * D.array();
  } else {
    newton_.residual.array() += D.array() * (h * d.array() - (0.5 * h * h) * p.array());
    newton_.jacobian.diagonal().array() += 1.0 + h * D.array();
  }
  if (norm_ == SolveNorm::kAbsolute) {
    // Not lpNorm<Infinity>: a NaN must come through.
    return newton_.residual.cwiseAbs().maxCoeff<Eigen::PropagateNaN>() / tolerance_;
  }
  return relative_residual(newton_.residual.norm(), tolerance_, h, p.norm(), R.norm(),
                           f_high.norm());
}

}  // namespace tremolo
