// Explicit Euler: every rate is taken at the start of the step.
//
//     q1 = q0 + h p0
//     p1 = p0 + h (fm - R(q0) - D p0)          fm: average of f over the step
//
// One force a step. First order. Neither symplectic nor reversible: on q'' + omega^2 q = 0 a step
// multiplies the amplitude by sqrt(1 + (h omega)^2), whatever h is, so undamped motion always
// grows. It is here as a contrast. The average hands on the exact impulse of any load. `dissipated`
// is h p0.D p0: first order.
#include "runtime/bodies/reduced/integrators/one_step.h"

namespace tremolo {
namespace {

class ExplicitEuler final : public OneStep {
 public:
  ExplicitEuler(Model::Pointer model, const IntegratorOptions& options)
      : OneStep("explicit-euler", std::move(model), options), k_(z0_) {}

  StepReport step(State& state, const StepLoad& load) noexcept override {
    z0_ = state;
    const double power = rates(z0_, load.average, k_);
    advance(z0_, h_, k_, state);
    return finish({.dissipated = h_ * power}, state);
  }

 private:
  State k_;
};

}  // namespace

IntegratorPointer make_explicit_euler(Model::Pointer model, const IntegratorOptions& options) {
  return std::make_unique<ExplicitEuler>(std::move(model), options);
}

}  // namespace tremolo
