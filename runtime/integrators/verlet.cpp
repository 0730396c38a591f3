#include "runtime/integrators/verlet.h"

#include <utility>

#include "runtime/integrators/solve/damping.h"
#include "runtime/integrators/solve/force_cache.h"

namespace tremolo {
namespace {

class Verlet final : public Integrator {
 public:
  Verlet(Model::Pointer model, const IntegratorOptions& options)
      : model_(std::move(model)),
        step_(options.step),
        kick_(damping_rates(model_->lambda(), options.alpha, options.beta), step_),
        forces_(model_->potential()),
        start_{model_->lambda(), model_->lambda()} {}

  StepReport step(State& state, const StepLoad& load) noexcept override {
    StepReport report;
    start_ = state;
    report.dissipated += kick_(load.start - forces_.force(state.q), state.p);
    state.q += step_ * state.p;
    report.dissipated += kick_(load.end - forces_.force(state.q), state.p);
    report.converged = state.q.allFinite() && state.p.allFinite();
    if (!report.converged) state = start_;
    return report;
  }

  std::string_view name() const override { return "verlet"; }
  std::optional<double> known_potential(const Eigen::VectorXd& q) const override {
    return forces_.known_energy(q);
  }

 private:
  Model::Pointer model_;
  double step_;
  DampedKick kick_;
  ForceCache forces_;
  State start_;
};

}  // namespace

std::unique_ptr<Integrator> make_verlet(Model::Pointer model, const IntegratorOptions& options) {
  return std::make_unique<Verlet>(std::move(model), options);
}

}  // namespace tremolo
