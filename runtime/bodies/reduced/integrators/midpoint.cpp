// Implicit midpoint (thesis 3.4.9).
//
// The discrete Lagrangian that takes V at the midpoint qm = (q0 + q1)/2 gives, with the mean
// velocity (p0 + p1)/2 = (q1 - q0)/h,
//
//     (p1 - p0)/h = fm - R(qm) - D (q1 - q0)/h          fm: average of f over the step
//
// Without p1, for d = q1 - q0 and times h^2/2:
//
//     d - h p0 + (h^2/2) [R(qm) + D d/h - fm] = 0,       p1 = 2 d/h - p0
//     Jacobian I + (h^2/4) K(qm) + (h/2) D               symmetric
//
// Second order with load and damping; symplectic and time-reversible without them; linearly stable
// for every h. Balance: load and damping do exactly fm.d - d.D d/h, which `dissipated`
// reports; V is not kept exactly, it only oscillates.
#include "runtime/bodies/reduced/integrators/implicit_step.h"

namespace tremolo {
namespace {

class Midpoint final : public ImplicitStep {
 public:
  Midpoint(Model::Pointer model, const IntegratorOptions& options)
      : ImplicitStep("midpoint", std::move(model), options) {}

  StepReport step(State& state, const StepLoad& load) noexcept override {
    Eigen::VectorXd& d = newton_.unknowns;
    begin_solve(0.5, state);
    StepReport report = solve_frozen(newton_, max_iterations_, [&](bool jacobian) {
      return evaluate_one_stage(0.5, state, load.average, jacobian);
    });
    if (!report.converged) return report;
    report.dissipated = dissipated();
    state.q += d;
    state.p = (2.0 / h_) * d - state.p;
    return report;
  }
};

}  // namespace

IntegratorPointer make_midpoint(Model::Pointer model, const IntegratorOptions& options) {
  return std::make_unique<Midpoint>(std::move(model), options);
}

}  // namespace tremolo
