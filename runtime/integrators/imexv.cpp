#include "runtime/integrators/imexv.h"

#include <utility>

#include "runtime/damping.h"
#include "runtime/integrators/force_cache.h"
#include "runtime/integrators/high_rows.h"

namespace tremolo {
namespace {

class Imexv final : public Integrator {
 public:
  Imexv(Model::Pointer model, const IntegratorOptions& options, Split split)
      : model_(std::move(model)),
        split_(split),
        step_(options.step),
        damped_(options.alpha > 0.0 || options.beta > 0.0),
        decay_(split_decay(model_->lambda(), split, options.alpha, options.beta, 0.5 * step_)),
        forces_(model_->potential()),
        high_(model_->potential(), split, damping_rates(model_->lambda(), 0.0, options.beta),
              options, HighDamping::kMeanVelocity, SolveNorm::kRelative),
        start_{decay_, decay_} {}

  StepReport step(State& state, const StepLoad& load) noexcept override {
    const double h = step_;
    const Eigen::Index low = split_.low;
    start_ = state;
    double dissipated = damped_ ? decay_momentum(decay_, state.p) : 0.0;
    if (low > 0) kick_low(state, load.start);
    state.q.head(low) += h * state.p.head(low);
    StepReport report = high_.advance(start_.q, state, load.average);
    if (report.converged && low > 0) kick_low(state, load.end);
    if (damped_) dissipated += decay_momentum(decay_, state.p);
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
  void kick_low(State& state, const Eigen::VectorXd& load) {
    const Eigen::VectorXd& force = forces_.force(state.q);
    state.p.head(split_.low) += 0.5 * step_ * (load - force).head(split_.low);
  }

  Model::Pointer model_;
  Split split_;
  double step_;
  bool damped_;
  Eigen::VectorXd decay_;
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
