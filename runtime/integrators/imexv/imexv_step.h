// The step of `imexv` with a given split; its equations stand in imexv.cpp.
#pragma once

#include <limits>

#include "runtime/integrators/imexv/high_rows.h"
#include "runtime/integrators/one_step.h"

namespace tremolo {

class ImexvStep : public OneStep {
 public:
  std::optional<Split> split() const final { return Split{low_, model_->modes() - low_}; }

 protected:
  ImexvStep(std::string_view name, Model::Pointer model, const IntegratorOptions& options,
            Split split, unsigned want, unsigned uses)
      : OneStep(name, std::move(model), options, want, uses),
        low_(split.low),
        kick_(D_, h_),
        z_end_{D_, D_} {
    z_end_.q.setConstant(std::numeric_limits<double>::quiet_NaN());
  }

  // From z0_, with the leading low_ coordinates explicit. high: made for that split.
  StepReport split_step(HighRows& high, State& state, const StepLoad& load) {
    double dissipated = kick_low(state, load.start);
    if (strain_.present()) {
      if (z_end_.q != z0_.q || z_end_.p != z0_.p) find_rest();
      dissipated += damp_low(0.5, state);
    }
    state.q.head(low_) += h_ * state.p.head(low_);
    StepReport report = high.advance(z0_.q, state, load.average);
    if (report.converged && strain_.present()) {
      dissipated += damp_low(-0.5, state);
      rest_ = high.rest();
      dissipated += damp_low(1.0, state);
    }
    if (report.converged) dissipated += kick_low(state, load.end);
    if (strain_.present()) z_end_ = state;
    report.dissipated += dissipated;
    report.converged = report.converged && state.q.allFinite() && state.p.allFinite();
    return report;
  }

  void carry(StateStream& stream) override {
    stream(V_);
    if (strain_.present()) stream(z_end_, rest_);
  }

  Eigen::Index low_;
  DampedKick kick_;

 private:
  // The impulse of the rest of the damping in a step that would go on as at z0_.
  void find_rest() {
    z_end_.p = h_ * z0_.p;
    strain_.force_at(z0_.q, z_end_.p, rest_);
  }

  // Takes a part of the impulse rest_ off the low rows. Returns what that took, J.
  double damp_low(double part, State& state) {
    auto p = state.p.head(low_);
    const double before = p.squaredNorm();
    p -= part * rest_.head(low_);
    return 0.5 * (before - p.squaredNorm());
  }

  // Returns what damping took, J.
  double kick_low(State& state, const Eigen::VectorXd& f) {
    if (low_ == 0) return 0.0;
    return kick_((f - V_.force(state.q)).head(low_), state.p);
  }

  State z_end_;  // of the last step, whose impulse is rest_
};

// Makes a method that takes the split it starts with. Errors as choose_split.
template <class Method>
MadeIntegrator make_split_method(Model::Pointer model, const IntegratorOptions& options) {
  const Result<Split> split = choose_split(model->lambda(), options.step, options.split);
  if (!split) return split.error();
  return IntegratorPointer(std::make_unique<Method>(std::move(model), options, *split));
}

}  // namespace tremolo
