#include "runtime/integrators/imexv/high_rows.h"

#include <algorithm>
#include <utility>

#include "runtime/integrators/solve/damping.h"

namespace tremolo {

HighRows::HighRows(const Model& model, Split split, const IntegratorOptions& options,
                   HighDamping damping, SolveNorm norm, std::shared_ptr<HighScratch> scratch)
    : potential_(model.potential()),
      split_(split),
      rates_(damping_rates(model.lambda().tail(split.high), options.alpha, options.beta)),
      divisor_(damping == HighDamping::kMeanVelocity
                   ? midpoint_damping(rates_, model.lambda().tail(split.high), options.step)
                   : Eigen::VectorXd::Ones(split.high)),
      step_(options.step),
      tolerance_(options.tolerance),
      max_iterations_(options.max_iterations),
      damping_(damping),
      norm_(norm),
      scratch_(scratch ? std::move(scratch) : std::make_shared<HighScratch>(potential_)),
      newton_(split.high) {}

StepReport HighRows::advance(const Eigen::VectorXd& q0, State& state, const Eigen::VectorXd& load) {
  if (split_.high == 0) return {};
  const double h = step_;
  Eigen::VectorXd& d = newton_.unknowns;
  auto p = state.p.tail(split_.high);
  d = h * p;
  scratch_->middle.head(split_.low) = 0.5 * (q0.head(split_.low) + state.q.head(split_.low));
  potential_.begin_trailing(scratch_->middle, split_.low, scratch_->workspace);
  StepReport report =
      solve_newton(newton_, max_iterations_, [&] { return evaluate(q0, state, load); });
  if (!report.converged) return report;
  state.q.tail(split_.high) += d;
  newton_.correction.array() = (2.0 / divisor_.array()) * (d.array() / h - p.array());  // Dp
  p += newton_.correction;
  // The force -D v acts along d: v is the mean or the end velocity.
  if (damping_ == HighDamping::kMeanVelocity)
    report.dissipated =
        (d.array().square() * rates_.array()).sum() / h +
        0.5 * ((divisor_.array() - 1.0) * newton_.correction.array().square()).sum();
  else
    report.dissipated = (d.array() * rates_.array() * p.array()).sum();
  return report;
}

double HighRows::evaluate(const Eigen::VectorXd& q0, const State& state,
                          const Eigen::VectorXd& load) {
  const double h = step_;
  const Eigen::Index high = split_.high;
  const Eigen::VectorXd& d = newton_.unknowns;
  const auto p = state.p.tail(high);
  scratch_->middle.tail(high) = q0.tail(high) + 0.5 * d;
  potential_.evaluate_trailing(scratch_->middle, split_.low, kWantForce | kWantTangent,
                               scratch_->workspace, scratch_->evaluation);
  const auto force = scratch_->evaluation.force.tail(high);
  newton_.residual.array() =
      (d - h * p).array() / divisor_.array() + (0.5 * h * h) * (force - load.tail(high)).array();
  newton_.jacobian = (0.25 * h * h) * scratch_->evaluation.tangent.bottomRightCorner(high, high);
  if (damping_ == HighDamping::kMeanVelocity) {
    newton_.residual.array() += (0.5 * h) * rates_.array() * d.array();
    newton_.jacobian.diagonal().array() += divisor_.array().inverse() + (0.5 * h) * rates_.array();
  } else {
    newton_.residual.array() += rates_.array() * (h * d.array() - (0.5 * h * h) * p.array());
    newton_.jacobian.diagonal().array() += 1.0 + h * rates_.array();
  }
  if (norm_ == SolveNorm::kAbsolute) {
    // Not lpNorm<Infinity>: a NaN must come through.
    return newton_.residual.cwiseAbs().maxCoeff<Eigen::PropagateNaN>() / tolerance_;
  }
  const double scale =
      std::max({h * p.norm(), h * h * force.norm(), h * h * load.tail(high).norm()});
  return relative_size(newton_.residual.norm(), tolerance_, scale);
}

}  // namespace tremolo
