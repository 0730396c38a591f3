// Stoermer-Verlet, kick-drift-kick (thesis 3.4.4-3.4.5, which lack M^-1; here M = I).
//
// The discrete Lagrangian that takes V by the trapezoid rule gives
//
//     p <- p + (h/2) (f(t+) - R(q0))
//     q <- q + h p
//     p <- p + (h/2) (f((t+h)-) - R(q1))
//
// With damping each kick is DampedKick of runtime/bodies/reduced/integrators/solve/damping.h, the
// exact flow of p' = -D p + f over half a step: D = alpha + beta lambda_i then takes exactly e^{-D
// h} off the area of each mode's phase plane, and a coordinate in thick damping moves with v = f/D.
// The part of the damping that depends on q is StrainKick of solve/strain_damping.h.
//
// Explicit: one force a step. Second order, also with load and damping; symplectic and
// time-reversible without them. Conditionally stable: linearly iff h omega < 2 for every omega
// (damped somewhat beyond), the step below explicit_step_limit_s of `tremolo inspect` (0.5 to 2.2
// ms on the six sample models); deformation that stiffens the solid lowers the limit, and beyond it
// the motion explodes. At 0.9 of it the six run for 10 s under their own loads. `dissipated` is
// exact for these kicks.
#include "runtime/bodies/reduced/integrators/one_step.h"
#include "runtime/bodies/reduced/integrators/solve/strain_damping.h"

namespace tremolo {
namespace {

class Verlet final : public OneStep {
 public:
  Verlet(Model::Pointer model, const IntegratorOptions& options)
      : OneStep("verlet", std::move(model), options),
        kick_(D_, h_),
        strain_kick_(D_, h_),
        f_(rest_) {}

  StepReport step(State& state, const StepLoad& load) noexcept override {
    auto& [q, p] = state;
    StepReport report;
    z0_ = state;
    report.dissipated += kick(q, load.start, p);
    q += h_ * p;
    report.dissipated += kick(q, load.end, p);
    return finish(report, state);
  }

 private:
  double kick(const Eigen::VectorXd& q, const Eigen::VectorXd& load, Eigen::VectorXd& p) {
    if (!strain_.present()) return kick_(load - V_.force(q), p);
    f_ = load - V_.force(q);
    return strain_kick_(strain_, q, f_, p);
  }

  DampedKick kick_;
  StrainKick strain_kick_;
  Eigen::VectorXd f_;
};

}  // namespace

IntegratorPointer make_verlet(Model::Pointer model, const IntegratorOptions& options) {
  return std::make_unique<Verlet>(std::move(model), options);
}

}  // namespace tremolo
