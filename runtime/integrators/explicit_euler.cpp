#include "runtime/integrators/explicit_euler.h"

#include <utility>

#include "runtime/integrators/solve/damping.h"

namespace tremolo {
namespace {

class ExplicitEuler final : public Integrator {
 public:
  ExplicitEuler(Model::Pointer model, const IntegratorOptions& options)
      : model_(std::move(model)),
        step_(options.step),
        rates_(damping_rates(model_->lambda(), options.alpha, options.beta)),
        workspace_(model_->potential().make_workspace(kUsePoint)),
        evaluation_(model_->potential().make_evaluation()),
        start_{rates_, rates_} {}

  StepReport step(State& state, const StepLoad& load) noexcept override {
    StepReport report;
    start_ = state;
    model_->potential().evaluate(start_.q, kWantForce, workspace_, evaluation_);
    state.q += step_ * start_.p;
    state.p += step_ * (load.average - evaluation_.force - rates_.cwiseProduct(start_.p));
    report.dissipated = step_ * (start_.p.array().square() * rates_.array()).sum();
    report.converged = state.q.allFinite() && state.p.allFinite();
    if (!report.converged) state = start_;
    return report;
  }

  std::string_view name() const override { return "explicit-euler"; }

 private:
  Model::Pointer model_;
  double step_;
  Eigen::VectorXd rates_;
  PotentialWorkspace workspace_;
  Evaluation evaluation_;
  State start_;
};

}  // namespace

std::unique_ptr<Integrator> make_explicit_euler(Model::Pointer model,
                                                const IntegratorOptions& options) {
  return std::make_unique<ExplicitEuler>(std::move(model), options);
}

}  // namespace tremolo
