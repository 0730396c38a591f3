// The implicit-explicit method of a variational split whose implicit part is linear (Stern &
// Grinspun 2009, "Implicit-explicit variational integration of highly oscillatory problems").
//
// The potential is cut in two, V = V_slow + V_fast with V_fast = 1/2 q_h^T Lambda_h q_h on the high
// rows h of the split (runtime/split.h). The discrete Lagrangian takes V_slow by the trapezoid rule
// and V_fast at the midpoint; its step, with R_s = R - Lambda_h q_h the slow force and M = I, is
//
//     p   <- p + (h/2) (f(t+) - R_s(q0))          on all rows; low rows: DampedKick
//     q_l <- q_l + h p_l
//     d_h  = (h p_h - g (h^2/2) Lambda_h q_h) / (1 + g ((h^2/4) Lambda_h + (h/2) D_h))
//     q_h <- q_h + d_h,  p_h <- p_h + (2/g) (d_h/h - p_h)
//     p   <- p + (h/2) (f((t+h)-) - R_s(q1))      on all rows; low rows: DampedKick
//
// with g = 1 + 2 theta h D_h; DampedKick and theta:
// runtime/bodies/reduced/integrators/solve/damping.h. Where the damping depends on q
// (solve/strain_damping.h), all of it is between the kicks, on all rows:
//
//     (1 + (h/2) (D + rest(qm)) + (h^2/4) Lambda_h) d = h p - (h^2/2) Lambda_h q0,
//     q <- q + d,  p <- p + 2 (d/h - p)
//
// linear in d, with the middle qm from a first solve at q0. There is no theta: in a slow motion the
// kicks and the middle balance each other, and it would take energy from the change of p in
// between. Damping in the kicks themselves does the same: at h omega of 20 it took a thousand times
// the body's energy, which the middle put in again.
//
// Without such damping no equation is left to solve: one force a step. Second order, also with load
// and damping;
// symplectic and time-reversible without damping, for any coupling of low and high rows. All low:
// it is `verlet`.
//
// Conditionally stable: linearly iff h omega < 2 on the low rows. But the part of V beyond
// its quadratic part on the high rows is kicked explicitly: where deformation stiffens the solid it
// is the first of the implicit-explicit methods to explode. Of the six sample models under their
// own loads beam, basket, horse and tower do so within 0.3 s at 3 ms, none in 10 s at 1 ms
// (`tremolo run build/models/NAME.tremolo --integrator imexv-linear --step H --duration 10`). To be
// chosen where the motion is known to be small for the step. `dissipated` is that of
// runtime/bodies/reduced/integrators/solve/damping.h.
#include <vector>

#include "runtime/bodies/reduced/integrators/imexv/imexv_step.h"
#include "runtime/bodies/reduced/integrators/imexv/linear_rows.h"
#include "runtime/bodies/reduced/integrators/solve/strain_damping.h"

namespace tremolo {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

class ImexvLinear final : public OneStep {
 public:
  ImexvLinear(Model::Pointer model, const IntegratorOptions& options, Split split)
      : OneStep("imexv-linear", std::move(model), options),
        split_(split),
        kick_(D_, h_),
        lambda_(model_->lambda().tail(split.high)),
        midpoint_(make_damped_midpoint(D_.tail(split.high), lambda_, h_)),
        d_(lambda_),
        dp_(lambda_) {
    for (Index i = 0; i < split.high; ++i)
      rows_.push_back(make_linear_row(midpoint_.D[i], midpoint_.g[i], lambda_[i], h_));
    if (!strain_.present()) return;
    VectorXd weights = VectorXd::Ones(D_.size()) + (0.5 * h_) * D_;
    weights.tail(split.high) += (0.25 * h_ * h_) * lambda_;
    strain_midpoint_ = StrainMidpoint(std::move(weights), h_);
    change_ = b_ = qm_ = rest_;
  }

  StepReport step(State& state, const StepLoad& load) noexcept override {
    StepReport report;
    z0_ = state;
    if (strain_.present()) {
      kick_slow(state, load.start);
      report.dissipated = damped_middle(state);
      kick_slow(state, load.end);
      return finish(report, state);
    }
    report.dissipated += kick(state, load.start);
    state.q.head(split_.low) += h_ * state.p.head(split_.low);
    for (Index i = 0; i < split_.high; ++i)
      advance_linear_row(rows_[i], h_, state.q[split_.low + i], state.p[split_.low + i], d_[i],
                         dp_[i]);
    report.dissipated += midpoint_.dissipated(d_, dp_);
    report.dissipated += kick(state, load.end);
    return finish(report, state);
  }

  std::optional<Split> split() const override { return split_; }

 private:
  // Returns the energy that damping took from the low rows, J.
  double kick(State& state, const VectorXd& f) {
    const VectorXd& R = V_.force(state.q);
    kick_high(state, f, R);
    return kick_((f - R).head(split_.low), state.p);
  }
  void kick_high(State& state, const VectorXd& f, const VectorXd& R) {
    auto p = state.p.tail(split_.high);
    p += 0.5 * h_ * (f - R).tail(split_.high);
    p.array() += 0.5 * h_ * lambda_.array() * state.q.tail(split_.high).array();
  }

  // The same on all rows, without damping.
  void kick_slow(State& state, const VectorXd& f) {
    const VectorXd& R = V_.force(state.q);
    kick_high(state, f, R);
    state.p.head(split_.low) += 0.5 * h_ * (f - R).head(split_.low);
  }
  // The rows between the kicks with damping that depends on q. Returns what it took, J.
  double damped_middle(State& state) {
    constexpr double kRough = 1e-4, kFine = 1e-13;  // of the two solves
    b_ = h_ * state.p;
    b_.tail(split_.high).array() -=
        0.5 * h_ * h_ * lambda_.array() * state.q.tail(split_.high).array();
    change_.setZero();
    strain_midpoint_.solve(strain_, state.q, b_, kRough, change_);
    qm_ = state.q + 0.5 * change_;
    const double rest = strain_midpoint_.solve(strain_, qm_, b_, kFine, change_);
    state.q += change_;
    state.p += 2.0 * (change_ / h_ - state.p);
    return (change_.cwiseAbs2().dot(D_) + rest) / h_;
  }

  Split split_;
  DampedKick kick_;  // of the low rows
  StrainMidpoint strain_midpoint_;
  VectorXd change_, b_, qm_;  // d, the right side and the middle, with damping that depends on q
  // These belong to the high rows.
  VectorXd lambda_;
  DampedMidpoint midpoint_;
  std::vector<LinearRow> rows_;
  VectorXd d_;   // q1 - q0
  VectorXd dp_;  // the change of p in the midpoint rule
};

}  // namespace

MadeIntegrator make_imexv_linear(Model::Pointer model, const IntegratorOptions& options) {
  return make_split_method<ImexvLinear>(std::move(model), options);
}

}  // namespace tremolo
