#include "runtime/integrators/imexv_linear.h"

#include <utility>

#include "runtime/damping.h"
#include "runtime/integrators/force_cache.h"

namespace tremolo {
namespace {

class ImexvLinear final : public Integrator {
 public:
  ImexvLinear(Model::Pointer model, const IntegratorOptions& options, Split split)
      : model_(std::move(model)),
        split_(split),
        step_(options.step),
        damped_(options.alpha > 0.0 || options.beta > 0.0),
        decay_(split_decay(model_->lambda(), split, options.alpha, options.beta, 0.5 * step_)),
        lambda_(model_->lambda().tail(split.high)),
        rates_(options.beta * lambda_),
        forces_(model_->potential()),
        start_{decay_, decay_},
        d_(lambda_) {}

  StepReport step(State& state, const StepLoad& load) noexcept override {
    StepReport report;
    start_ = state;
    if (damped_) report.dissipated += decay_momentum(decay_, state.p);
    kick(state, load.start);
    state.q.head(split_.low) += step_ * state.p.head(split_.low);
    report.dissipated += advance_high(state);
    kick(state, load.end);
    if (damped_) report.dissipated += decay_momentum(decay_, state.p);
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
  void kick(State& state, const Eigen::VectorXd& load) {
    state.p += 0.5 * step_ * (load - forces_.force(state.q));
    state.p.tail(split_.high).array() +=
        0.5 * step_ * lambda_.array() * state.q.tail(split_.high).array();
  }

  // Returns the work of the damping force.
  double advance_high(State& state) {
    const double h = step_;
    auto q = state.q.tail(split_.high);
    auto p = state.p.tail(split_.high);
    d_.array() = (h * p.array() - (0.5 * h * h) * lambda_.array() * q.array()) /
                 (1.0 + (0.25 * h * h) * lambda_.array() + (0.5 * h) * rates_.array());
    q += d_;
    p = (2.0 / h) * d_ - p;
    return (d_.array().square() * rates_.array()).sum() / h;
  }

  Model::Pointer model_;
  Split split_;
  double step_;
  bool damped_;
  Eigen::VectorXd decay_;
  Eigen::VectorXd lambda_;  // of the high rows
  Eigen::VectorXd rates_;   // beta lambda of the high rows
  ForceCache forces_;
  State start_;
  Eigen::VectorXd d_;  // high rows of q1 - q0
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
