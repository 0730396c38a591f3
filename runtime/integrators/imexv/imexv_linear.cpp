#include "runtime/integrators/imexv/imexv_linear.h"

#include <utility>

#include "runtime/integrators/solve/damping.h"
#include "runtime/integrators/solve/force_cache.h"

namespace tremolo {
namespace {

class ImexvLinear final : public Integrator {
 public:
  ImexvLinear(Model::Pointer model, const IntegratorOptions& options, Split split)
      : model_(std::move(model)),
        split_(split),
        step_(options.step),
        lambda_(model_->lambda().tail(split.high)),
        rates_(damping_rates(lambda_, options.alpha, options.beta)),
        divisor_(midpoint_damping(rates_, lambda_, step_)),
        low_kick_(damping_rates(model_->lambda().head(split.low), options.alpha, options.beta),
                  step_),
        forces_(model_->potential()),
        start_{model_->lambda(), model_->lambda()},
        d_(lambda_),
        change_(lambda_) {}

  StepReport step(State& state, const StepLoad& load) noexcept override {
    StepReport report;
    start_ = state;
    report.dissipated += kick(state, load.start);
    state.q.head(split_.low) += step_ * state.p.head(split_.low);
    report.dissipated += advance_high(state);
    report.dissipated += kick(state, load.end);
    report.converged = state.q.allFinite() && state.p.allFinite();
    if (!report.converged) state = start_;
    return report;
  }

  std::string_view name() const override { return "imexv-linear"; }
  std::optional<double> known_potential(const Eigen::VectorXd& q) const override {
    return forces_.known_energy(q);
  }
  std::optional<Split> split() const override { return split_; }

 private:
  // Returns what damping took of the low rows.
  double kick(State& state, const Eigen::VectorXd& load) {
    const Eigen::VectorXd& force = forces_.force(state.q);
    auto p = state.p.tail(split_.high);
    p += 0.5 * step_ * (load - force).tail(split_.high);
    p.array() += 0.5 * step_ * lambda_.array() * state.q.tail(split_.high).array();
    return low_kick_((load - force).head(split_.low), state.p);
  }

  // The midpoint rule with damping (runtime/integrators/solve/damping.h). Returns what damping
  // took.
  double advance_high(State& state) {
    const double h = step_;
    auto q = state.q.tail(split_.high);
    auto p = state.p.tail(split_.high);
    d_.array() =
        (h * p.array() - (0.5 * h * h) * divisor_.array() * lambda_.array() * q.array()) /
        (1.0 + divisor_.array() * ((0.25 * h * h) * lambda_.array() + (0.5 * h) * rates_.array()));
    change_ = (2.0 / divisor_.array()) * (d_.array() / h - p.array());
    q += d_;
    p += change_;
    return (rates_.array() * d_.array().square()).sum() / h +
           0.5 * ((divisor_.array() - 1.0) * change_.array().square()).sum();
  }

  Model::Pointer model_;
  Split split_;
  double step_;
  Eigen::VectorXd lambda_;   // of the high rows
  Eigen::VectorXd rates_;    // D of the high rows
  Eigen::VectorXd divisor_;  // 1 + 2 theta h D of the high rows
  DampedKick low_kick_;
  ForceCache forces_;
  State start_;
  Eigen::VectorXd d_;       // high rows of q1 - q0
  Eigen::VectorXd change_;  // and of p1 - p0
};

}  // namespace

Result<std::unique_ptr<Integrator>> make_imexv_linear(Model::Pointer model,
                                                      const IntegratorOptions& options) {
  const Result<Split> split = choose_split(model->lambda(), options.step, options.split);
  if (!split) return split.error();
  return std::unique_ptr<Integrator>(
      std::make_unique<ImexvLinear>(std::move(model), options, *split));
}

}  // namespace tremolo
