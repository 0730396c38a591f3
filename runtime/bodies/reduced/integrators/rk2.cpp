// The explicit midpoint rule, a Runge-Kutta method of two stages.
//
//     qm = q0 + (h/2) p0
//     pm = p0 + (h/2) (f(t+) - R(q0) - D p0)
//     q1 = q0 + h pm
//     p1 = p0 + h (fm - R(qm) - D pm)          fm: average of f over the step
//
// Two forces a step. Second order, also with load and damping. Neither symplectic nor reversible:
// on q'' + omega^2 q = 0 its matrix has the eigenvalues 1 + z + z^2/2 at z = +-i h omega, so that
// a step multiplies the amplitude by sqrt(1 + (h omega)^4/4): undamped motion always grows, if
// slowly at small h. It is here as a contrast. The average hands on the exact impulse of any load.
// `dissipated` is h pm.D pm: second order.
#include "runtime/bodies/reduced/integrators/one_step.h"

namespace tremolo {
namespace {

class Rk2 final : public OneStep {
 public:
  Rk2(Model::Pointer model, const IntegratorOptions& options)
      : OneStep("rk2", std::move(model), options), zm_(z0_), k_(z0_) {}

  StepReport step(State& state, const StepLoad& load) noexcept override {
    z0_ = state;
    rates(z0_, load.start, k_);
    advance(z0_, 0.5 * h_, k_, zm_);
    const double power = rates(zm_, load.average, k_);
    advance(z0_, h_, k_, state);
    return finish({.dissipated = h_ * power}, state);
  }

 private:
  State zm_;  // (qm, pm)
  State k_;
};

}  // namespace

IntegratorPointer make_rk2(Model::Pointer model, const IntegratorOptions& options) {
  return std::make_unique<Rk2>(std::move(model), options);
}

}  // namespace tremolo
