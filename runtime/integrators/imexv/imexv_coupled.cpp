#include "runtime/integrators/imexv/imexv_coupled.h"

#include <algorithm>
#include <utility>

#include "runtime/integrators/solve/damping.h"
#include "runtime/integrators/solve/force_cache.h"
#include "runtime/integrators/solve/newton.h"

namespace tremolo {
namespace {

class ImexvCoupled final : public Integrator {
 public:
  ImexvCoupled(Model::Pointer model, const IntegratorOptions& options, Split split)
      : model_(std::move(model)),
        options_(options),
        split_(split),
        rates_(damping_rates(model_->lambda(), options.alpha, options.beta)),
        divisor_(midpoint_damping(rates_, fast_part(model_->lambda(), split), options.step)),
        slow_(model_->potential().leading(split.low)),
        slow_forces_(slow_),
        slow_workspace_(slow_.make_workspace(kUseTangent)),
        slow_evaluation_(slow_.make_evaluation()),
        low_(Eigen::VectorXd::Zero(split.low)),
        workspace_(model_->potential().make_workspace(kUseTangent)),
        evaluation_(model_->potential().make_evaluation()),
        middle_(rates_),
        newton_(model_->modes()),
        start_{rates_, rates_} {}

  StepReport step(State& state, const StepLoad& load) noexcept override {
    start_ = state;
    kick_low(state, load.start);
    StepReport report = advance_all(state, load.average);
    if (report.converged) kick_low(state, load.end);
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

  // lambda of the linear part of V_fast: none on the low rows.
  static Eigen::VectorXd fast_part(const Eigen::VectorXd& lambda, Split split) {
    Eigen::VectorXd fast = lambda;
    fast.head(split.low).setZero();
    return fast;
  }

  // The midpoint rule for V_fast and all of the damping (runtime/integrators/solve/damping.h).
  StepReport advance_all(State& state, const Eigen::VectorXd& load) {
    const double h = options_.step;
    if (split_.high == 0) return drift(state);
    Eigen::VectorXd& d = newton_.unknowns;
    d = h * state.p;
    StepReport report =
        solve_newton(newton_, options_.max_iterations, [&] { return evaluate(state, load); });
    if (!report.converged) return report;
    report.dissipated = finish(state, d);
    return report;
  }

  // V_fast = 0.
  StepReport drift(State& state) {
    const double h = options_.step;
    newton_.unknowns = h * (state.p.array() / (1.0 + 0.5 * h * rates_.array() * divisor_.array()));
    StepReport report;
    report.dissipated = finish(state, newton_.unknowns);
    return report;
  }

  // From d to the state at the end. Returns what damping took, J.
  double finish(State& state, const Eigen::VectorXd& d) {
    const double h = options_.step;
    middle_ = (2.0 / divisor_.array()) * (d.array() / h - state.p.array());  // Dp
    state.q += d;
    state.p += middle_;
    return (rates_.array() * d.array().square()).sum() / h +
           0.5 * ((divisor_.array() - 1.0) * middle_.array().square()).sum();
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
    newton_.residual.array() = (d - h * state.p).array() / divisor_.array() +
                               (0.5 * h) * (h * evaluation_.force + rates_.cwiseProduct(d)).array();
    newton_.residual.tail(high) -= (0.5 * h * h) * load.tail(high);
    newton_.jacobian = (0.25 * h * h) * evaluation_.tangent;
    newton_.jacobian.diagonal().array() += divisor_.array().inverse() + (0.5 * h) * rates_.array();
    return relative_size(newton_.residual.norm(), options_.tolerance, scale);
  }

  Model::Pointer model_;
  IntegratorOptions options_;
  Split split_;
  Eigen::VectorXd rates_;    // D
  Eigen::VectorXd divisor_;  // 1 + 2 theta h D
  Potential slow_;           // V(q_l, 0)
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
