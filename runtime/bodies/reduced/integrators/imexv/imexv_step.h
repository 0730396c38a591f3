// The step of `imexv` with a given split; imexv.cpp has its equations.
#pragma once

#include <optional>

#include "runtime/bodies/reduced/integrators/imexv/imexv_rows.h"
#include "runtime/bodies/reduced/integrators/one_step.h"

namespace tremolo {

class ImexvStep : public OneStep {
 public:
  std::optional<Split> split() const final { return Split{low_, model_->modes() - low_}; }

 protected:
  ImexvStep(std::string_view name, Model::Pointer model, const IntegratorOptions& options,
            Split split, unsigned want, unsigned uses)
      : OneStep(name, std::move(model), options, want, uses),
        low_(split.low),
        kick_(strain_.present() ? Eigen::VectorXd(Eigen::VectorXd::Zero(D_.size())) : D_, h_) {
    if (strain_.present()) damped_rows_.emplace(*model_, options);
  }

  // Steps from z0_, with the leading low_ coordinates explicit. high: made for that split.
  StepReport split_step(HighRows& high, State& state, const StepLoad& load) {
    double dissipated = kick_low(state, load.start);
    StepReport report;
    if (damped_rows_) {
      report = damped_rows_->advance({low_, model_->modes() - low_}, strain_, state, load.average);
    } else {
      state.q.head(low_) += h_ * state.p.head(low_);
      report = high.advance(z0_.q, state, load.average);
    }
    if (report.converged) dissipated += kick_low(state, load.end);
    report.dissipated += dissipated;
    report.converged = report.converged && state.q.allFinite() && state.p.allFinite();
    return report;
  }

  Eigen::Index low_;
  DampedKick kick_;

 private:
  // Returns the energy that damping took, J.
  double kick_low(State& state, const Eigen::VectorXd& f) {
    if (low_ == 0) return 0.0;
    return kick_((f - V_.force(state.q)).head(low_), state.p);
  }

  std::optional<DampedRows> damped_rows_;  // where the damping depends on q
};

// Makes a method with the split that it starts with. Errors: same as for choose_split.
template <class Method>
MadeIntegrator make_split_method(Model::Pointer model, const IntegratorOptions& options) {
  const Result<Split> split = choose_split(model->lambda(), options.step, options.split);
  if (!split) return split.error();
  return IntegratorPointer(std::make_unique<Method>(std::move(model), options, *split));
}

}  // namespace tremolo
