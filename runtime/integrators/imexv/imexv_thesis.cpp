#include "runtime/integrators/imexv/imexv_thesis.h"

#include <utility>

#include "runtime/integrators/imexv/high_rows.h"
#include "runtime/integrators/solve/damping.h"
#include "runtime/integrators/solve/force_cache.h"

namespace tremolo {
namespace {

class ImexvThesis final : public Integrator {
 public:
  ImexvThesis(Model::Pointer model, const IntegratorOptions& options, Split split)
      : model_(std::move(model)),
        split_(split),
        step_(options.step),
        rates_(damping_rates(model_->lambda(), options.alpha, options.beta)),
        forces_(model_->potential()),
        high_(*model_, split, options, HighDamping::kEndVelocity, SolveNorm::kAbsolute),
        load_before_(Eigen::VectorXd::Zero(model_->modes())),
        start_{load_before_, load_before_} {}

  StepReport step(State& state, const StepLoad& load) noexcept override {
    const double h = step_;
    const Eigen::Index low = split_.low;
    start_ = state;
    double dissipated = 0.0;
    auto p = state.p.head(low);
    if (low > 0) {
      const auto force = forces_.force(state.q).head(low);
      p += h * (0.5 * (load_before_ + load.start).head(low) - force -
                rates_.head(low).cwiseProduct(start_.p.head(low)));
      state.q.head(low) += h * p;
      dissipated = h * (rates_.head(low).array() * start_.p.head(low).array() * p.array()).sum();
    }
    StepReport report = high_.advance(start_.q, state, load.average);
    report.dissipated += dissipated;
    report.converged = report.converged && state.q.allFinite() && state.p.allFinite();
    if (!report.converged) {
      state = start_;
      return report;
    }
    load_before_ = load.end;
    // The next step's kick wants it, and so does whoever reads an energy in between: evaluated
    // here, a step's time contains all of its work.
    if (low > 0) forces_.force(state.q);
    return report;
  }

  void reset() override { load_before_.setZero(); }
  std::string_view name() const override { return "imexv-thesis"; }
  std::optional<double> known_potential(const Eigen::VectorXd& q) const override {
    return forces_.known_energy(q);
  }
  std::optional<Split> split() const override { return split_; }

  void synchronized_momentum(const State& state, Eigen::VectorXd& p) const override {
    p = state.p;
    if (split_.low == 0) return;
    const Eigen::VectorXd& force = forces_.force(state.q);
    p.head(split_.low) += 0.5 * step_ * (load_before_ - force).head(split_.low);
  }

 private:
  Model::Pointer model_;
  Split split_;
  double step_;
  Eigen::VectorXd rates_;
  mutable ForceCache forces_;
  HighRows high_;
  Eigen::VectorXd load_before_;  // f((t_k)-), what the step before ended with
  State start_;
};

}  // namespace

Result<std::unique_ptr<Integrator>> make_imexv_thesis(Model::Pointer model,
                                                      const IntegratorOptions& options) {
  const Result<Split> split = choose_split(model->lambda(), options.step, options.split);
  if (!split) return split.error();
  return std::unique_ptr<Integrator>(
      std::make_unique<ImexvThesis>(std::move(model), options, *split));
}

}  // namespace tremolo
