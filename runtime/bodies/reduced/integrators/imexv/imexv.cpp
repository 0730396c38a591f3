// The implicit-explicit variational integrator in its symmetric form (thesis 4.3, 4.4, corrected).
//
// The coordinates are split by frequency (runtime/split.h) into low ones, l, and high ones, h. The
// discrete Lagrangian takes V by the trapezoid rule along l and by the midpoint along h; its step,
// with d = q1 - q0 and qm = (q0 + q1)/2 and M = I, is
//
//     p_l <- p_l + (h/2) (f_l(t+) - R_l(q0))        damped: DampedKick
//     q_l <- q_l + h p_l
//     solve for d_h:  (d_h - h p_h)/g + (h^2/2) [R(qm) + D d/h - fm]_h = 0
//                     Jacobian  1/g + (h^2/4) K_hh(qm) + (h/2) D_h
//     p_h <- p_h + (2/g) (d_h/h - p_h)
//     p_l <- p_l + (h/2) (f_l((t+h)-) - R_l(q1))    damped: DampedKick
//
// with g = 1 + 2 theta h D_h; DampedKick and theta:
// runtime/bodies/reduced/integrators/solve/damping.h. fm is the load's average over the step. Where
// the damping depends on q, it couples all rows and the middle is that of imexv_rows.h. While the
// high rows are solved the low ones are constant, so the unknowns and the rows that are evaluated
// are the high ones only.
//
// Second order, also with load and damping; time-reversible without damping. Symplectic only where
// V does not couple low and high rows. All low: it is `verlet`; all high and undamped: it is
// `midpoint`. A free linear mode loses e^{-D h} of the area of its phase plane in a step: exactly
// on low rows, to O((D h)^2) of the exponent on high ones. `dissipated` is that of
// runtime/bodies/reduced/integrators/solve/damping.h.
//
// Conditionally stable: linearly iff h omega < 2 on the low rows (damped somewhat beyond), which
// deformation that stiffens the solid may end. Of the thesis's 36 runs at 3 ms (six models, three
// loads, damped or not) 33 reach 30 s, with three times the loads 27, with ten times 12.
#include "runtime/bodies/reduced/integrators/imexv/imexv_step.h"

namespace tremolo {
namespace {

class Imexv final : public ImexvStep {
 public:
  Imexv(Model::Pointer model, const IntegratorOptions& options, Split split)
      : ImexvStep("imexv", std::move(model), options, split, kWantEnergy | kWantForce, kUsePoint),
        high_(*model_, split, options, HighDamping::kMeanVelocity, SolveNorm::kRelative) {}

  StepReport step(State& state, const StepLoad& load) noexcept override {
    z0_ = state;
    return finish(split_step(high_, state, load), state);
  }

 private:
  HighRows high_;
};

}  // namespace

MadeIntegrator make_imexv(Model::Pointer model, const IntegratorOptions& options) {
  return make_split_method<Imexv>(std::move(model), options);
}

}  // namespace tremolo
