#include "runtime/integrators/imexv/imexv.h"

#include <utility>

#include "runtime/integrators/imexv/high_rows.h"
#include "runtime/integrators/solve/damping.h"
#include "runtime/integrators/solve/force_cache.h"

namespace tremolo {
namespace {

class Imexv final : public Integrator {
 public:
  Imexv(Model::Pointer model, const IntegratorOptions& options, Split split)
      : model_(std::move(model)),
        split_(split),
        step_(options.step),
        kick_(damping_rates(model_->lambda(), options.alpha, options.beta), step_),
        forces_(model_->potential()),
        high_(*model_, split, options, HighDamping::kMeanVelocity, SolveNorm::kRelative),
        start_{model_->lambda(), model_->lambda()} {}

  StepReport step(State& state, const StepLoad& load) noexcept override {
    const double h = step_;
    const Eigen::Index low = split_.low;
    start_ = state;
    double dissipated = kick_low(state, load.start);
    state.q.head(low) += h * state.p.head(low);
    StepReport report = high_.advance(start_.q, state, load.average);
    if (report.converged) dissipated += kick_low(state, load.end);
    report.dissipated += dissipated;
    report.converged = report.converged && state.q.allFinite() && state.p.allFinite();
    if (!report.converged) state = start_;
    return report;
  }

  std::string_view name() const override { return "imexv"; }
  std::optional<double> known_potential(const Eigen::VectorXd& q) const override {
    return forces_.known_energy(q);
  }
  std::optional<Split> split() const override { return split_; }

 private:
  double kick_low(State& state, const Eigen::VectorXd& load) {
    if (split_.low == 0) return 0.0;
    return kick_((load - forces_.force(state.q)).head(split_.low), state.p);
  }

  Model::Pointer model_;
  Split split_;
  double step_;
  DampedKick kick_;
  ForceCache forces_;
  HighRows high_;
  State start_;
};

}  // namespace

Result<std::unique_ptr<Integrator>> make_imexv(Model::Pointer model,
                                               const IntegratorOptions& options) {
  const Result<Split> split = choose_split(model->lambda(), options.step, options.split);
  if (!split) return split.error();
  return std::unique_ptr<Integrator>(std::make_unique<Imexv>(std::move(model), options, *split));
}

}  // namespace tremolo
