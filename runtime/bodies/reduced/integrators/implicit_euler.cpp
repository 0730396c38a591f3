// Implicit Euler: every rate is taken at the end of the step.
//
//     q1 = q0 + h p1
//     p1 = p0 + h (fm - R(q1) - D p1)          fm: average of f over the step
//
// Without p1, for d = q1 - q0 and times h:
//
//     d - h p0 + h^2 [R(q0 + d) + D d/h - fm] = 0,       p1 = d/h
//     Jacobian I + h^2 K(q0 + d) + h D                   symmetric
//
// First order. Neither symplectic nor reversible: on q'' + omega^2 q = 0 a step multiplies the
// amplitude by 1/sqrt(1 + (h omega)^2), so it is stable for every h and damps what it does not
// resolve. (The eigenvalues of its matrix are 1/(1 -+ i h omega).) It is here as a contrast. The
// average hands on the exact impulse of any load. `dissipated` is the work of the damping force,
// d.D d/h: first order. What the method itself takes away is not in it.
#include "runtime/bodies/reduced/integrators/implicit_step.h"

namespace tremolo {
namespace {

class ImplicitEuler final : public ImplicitStep {
 public:
  ImplicitEuler(Model::Pointer model, const IntegratorOptions& options)
      : ImplicitStep("implicit-euler", std::move(model), options) {}

  StepReport step(State& state, const StepLoad& load) noexcept override {
    Eigen::VectorXd& d = newton_.unknowns;
    begin_solve(1.0, state);
    StepReport report = solve_newton(newton_, max_iterations_, [&] {
      return evaluate_one_stage(1.0, state, load.average, true);
    });
    if (!report.converged) return report;
    report.dissipated = dissipated();
    state.q += d;
    state.p = d / h_;
    return report;
  }
};

}  // namespace

IntegratorPointer make_implicit_euler(Model::Pointer model, const IntegratorOptions& options) {
  return std::make_unique<ImplicitEuler>(std::move(model), options);
}

}  // namespace tremolo
