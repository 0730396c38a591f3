#include "runtime/integrators/imexv_coupled.h"

#include <algorithm>
#include <utility>

#include "runtime/damping.h"
#include "runtime/integrators/force_cache.h"
#include "runtime/integrators/newton.h"

namespace tremolo {
namespace {

class ImexvCoupled final : public Integrator {
 public:
  ImexvCoupled(Model::Pointer model, const IntegratorOptions& options, Split split)
      : model_(std::move(model)),
        options_(options),
        split_(split),
        damped_(options.alpha > 0.0 || options.beta > 0.0),
        decay_(
            split_decay(model_->lambda(), split, options.alpha, options.beta, 0.5 * options.step)),
        rates_(options.beta * model_->lambda().tail(split.high)),
        slow_(model_->potential().leading(split.low)),
        slow_forces_(slow_),
        slow_workspace_(slow_.make_workspace(kUseTangent)),
        slow_evaluation_(slow_.make_evaluation()),
        low_(Eigen::VectorXd::Zero(split.low)),
        workspace_(model_->potential().make_workspace(kUseTangent)),
        evaluation_(model_->potential().make_evaluation()),
        middle_(decay_),
        newton_(model_->modes()),
        start_{decay_, decay_} {}

  StepReport step(State& state, const StepLoad& load) noexcept override {
    start_ = state;
    double dissipated = damped_ ? decay_momentum(decay_, state.p) : 0.0;
    kick_low(state, load.start);
    StepReport report = advance_all(state, load.average);
    if (report.converged) kick_low(state, load.end);
    if (damped_) dissipated += decay_momentum(decay_, state.p);
    report.dissipated += dissipated;
    report.converged = report.converged && state.q.allFinite() && state.p.allFinite();
    if (!report.converged) state = start_;
    return report;
  }

  std::string_view name() const override { return "imexv-coupled"; }
  std::optional<Split> split() const override { return split_; }

 private:
  void kick_low(State& state, const Eigen::VectorXd& load) {
    if (split_.low == 0) return;
    low_ = state.q.head(split_.low);
    state.p.head(split_.low) +=
        0.5 * options_.step * (load.head(split_.low) - slow_forces_.force(low_));
  }

  // The midpoint rule for V_fast. dissipated: the work of the high rows' damping force.
  StepReport advance_all(State& state, const Eigen::VectorXd& load) {
    const double h = options_.step;
    if (split_.high == 0) {  // no fast part: a drift
      state.q += h * state.p;
      return {};
    }
    Eigen::VectorXd& d = newton_.unknowns;
    d = h * state.p;
    StepReport report =
        solve_newton(newton_, options_.max_iterations, [&] { return evaluate(state, load); });
    if (!report.converged) return report;
    report.dissipated = (d.tail(split_.high).array().square() * rates_.array()).sum() / h;
    state.q += d;
    state.p = (2.0 / h) * d - state.p;
    return report;
  }

  double evaluate(const State& state, const Eigen::VectorXd& load) {
    const double h = options_.step;
    const Eigen::Index low = split_.low, high = split_.high;
    const Eigen::VectorXd& d = newton_.unknowns;
    middle_ = state.q + 0.5 * d;
    model_->potential().evaluate(middle_, kWantForce | kWantTangent, workspace_, evaluation_);
    // Of the whole force: what is left of it on the low rows is rounded like the whole.
    const double scale = std::max(
        {h * state.p.norm(), h * h * evaluation_.force.norm(), h * h * load.tail(high).norm()});
    if (low > 0) {
      low_ = middle_.head(low);
      slow_.evaluate(low_, kWantForce | kWantTangent, slow_workspace_, slow_evaluation_);
      evaluation_.force.head(low) -= slow_evaluation_.force;
      evaluation_.tangent.topLeftCorner(low, low) -= slow_evaluation_.tangent;
    }
    newton_.residual = d - h * state.p + (0.5 * h * h) * evaluation_.force;
    newton_.residual.tail(high).array() +=
        (0.5 * h) * rates_.array() * d.tail(high).array() - (0.5 * h * h) * load.tail(high).array();
    newton_.jacobian = (0.25 * h * h) * evaluation_.tangent;
    newton_.jacobian.diagonal().array() += 1.0;
    newton_.jacobian.diagonal().tail(high).array() += (0.5 * h) * rates_.array();
    return relative_size(newton_.residual.norm(), options_.tolerance, scale);
  }

  Model::Pointer model_;
  IntegratorOptions options_;
  Split split_;
  bool damped_;
  Eigen::VectorXd decay_;
  Eigen::VectorXd rates_;  // beta lambda of the high rows
  Potential slow_;         // V(q_l, 0)
  ForceCache slow_forces_;
  PotentialWorkspace slow_workspace_;
  Evaluation slow_evaluation_;
  Eigen::VectorXd low_;  // low rows of a q
  PotentialWorkspace workspace_;
  Evaluation evaluation_;
  Eigen::VectorXd middle_;
  NewtonWorkspace newton_;
  State start_;
};

}  // namespace

Result<std::unique_ptr<Integrator>> make_imexv_coupled(Model::Pointer model,
                                                       const IntegratorOptions& options) {
  const Result<Split> split = choose_split(model->lambda(), options.step, options.split);
  if (!split) return split.error();
  return std::unique_ptr<Integrator>(
      std::make_unique<ImexvCoupled>(std::move(model), options, *split));
}

}  // namespace tremolo
