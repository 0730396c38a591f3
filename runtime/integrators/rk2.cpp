#include "runtime/integrators/rk2.h"

#include <utility>

#include "runtime/integrators/solve/damping.h"

namespace tremolo {
namespace {

class Rk2 final : public Integrator {
 public:
  Rk2(Model::Pointer model, const IntegratorOptions& options)
      : model_(std::move(model)),
        step_(options.step),
        rates_(damping_rates(model_->lambda(), options.alpha, options.beta)),
        workspace_(model_->potential().make_workspace(kUsePoint)),
        evaluation_(model_->potential().make_evaluation()),
        start_{rates_, rates_},
        middle_{rates_, rates_} {}

  StepReport step(State& state, const StepLoad& load) noexcept override {
    StepReport report;
    start_ = state;
    move(start_, 0.5 * step_, load.start, middle_);
    move(middle_, step_, load.average, state);
    report.dissipated = step_ * (middle_.p.array().square() * rates_.array()).sum();
    report.converged = state.q.allFinite() && state.p.allFinite();
    if (!report.converged) state = start_;
    return report;
  }

  std::string_view name() const override { return "rk2"; }

 private:
  // From the start of the step, by `time`, with the rates of `slope`.
  void move(const State& slope, double time, const Eigen::VectorXd& load, State& out) {
    model_->potential().evaluate(slope.q, kWantForce, workspace_, evaluation_);
    out.q = start_.q + time * slope.p;
    out.p = start_.p + time * (load - evaluation_.force - rates_.cwiseProduct(slope.p));
  }

  Model::Pointer model_;
  double step_;
  Eigen::VectorXd rates_;
  PotentialWorkspace workspace_;
  Evaluation evaluation_;
  State start_;
  State middle_;
};

}  // namespace

std::unique_ptr<Integrator> make_rk2(Model::Pointer model, const IntegratorOptions& options) {
  return std::make_unique<Rk2>(std::move(model), options);
}

}  // namespace tremolo
