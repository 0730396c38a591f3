// The implicit-explicit method of a variational split whose implicit part contains every coupling.
//
// The potential is cut in two, V = V_slow + V_fast, with V_slow(q) = V(q_l, 0) the part that the
// low rows l of the split (runtime/split.h) have alone, and V_fast = V - V_slow all that the high
// rows h take part in. The discrete Lagrangian takes V_slow by the trapezoid rule and V_fast at the
// midpoint; its step, with S = grad V_slow on the low rows and 0 on the high ones, d = q1 - q0,
// qm = (q0 + q1)/2 and M = I, is
//
//     p_l <- p_l + (h/2) (f_l(t+) - S_l(q0))
//     solve for d:  (d - h p)/g + (h^2/2) [R(qm) - S(qm) + D d/h - f] = 0        on all rows
//                   Jacobian  1/g + (h^2/4) (K(qm) - dS/dq(qm)) + (h/2) D        symmetric
//     q   <- q + d,  p <- p + (2/g) (d/h - p)
//     p_l <- p_l + (h/2) (f_l((t+h)-) - S_l(q1))
//
// On the high rows f is the load's average over the step, on the low rows zero. g = 1 + 2 theta h
// D, theta of runtime/bodies/reduced/integrators/solve/damping.h; on the low rows theta = 0. There
// the kicks S and the middle's R - S balance each other in a slow motion, p changes by h S within
// the step, and a theta would take energy from that change. To D belongs the rest at qm
// (solve/strain_damping.h).
//
// Second order, also with load and damping; symplectic and time-reversible without damping, for any
// coupling of low and high rows, at the price of as many unknowns as the midpoint rule. Undamped
// and all low it is `verlet`, all high `midpoint`. Conditionally stable: linearly iff h omega < 2
// on the low rows, as `imexv`. `dissipated` is that of
// runtime/bodies/reduced/integrators/solve/damping.h.
#include "runtime/bodies/reduced/integrators/imexv/imexv_rows.h"
#include "runtime/bodies/reduced/integrators/imexv/imexv_step.h"
#include "runtime/bodies/reduced/integrators/implicit_step.h"

namespace tremolo {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

class ImexvCoupled final : public ImplicitStep {
 public:
  ImexvCoupled(Model::Pointer model, const IntegratorOptions& options, Split split)
      : ImplicitStep("imexv-coupled", std::move(model), options),
        split_(split),
        midpoint_(make_split_midpoint(*model_, options, split)),
        V_slow_(model_->potential().leading(split.low)),
        S_ends_(V_slow_, kWantEnergy | kWantForce, kUsePoint),
        S_middle_(V_slow_, kWantForce, kUseTangent),
        q_low_(VectorXd::Zero(split.low)),
        dp_(D_) {}

  StepReport step(State& state, const StepLoad& load) noexcept override {
    z0_ = state;
    kick_low(state, load.start);
    StepReport report;
    VectorXd& d = newton_.unknowns;
    if (split_.high == 0 && !strain_.present()) {  // V_fast = 0: a damped drift
      d = h_ * (state.p.array() / (1.0 + 0.5 * h_ * D_.array() * midpoint_.g.array()));
    } else {
      begin_solve(0.5, state);
      report =
          solve_newton(newton_, max_iterations_, [&] { return evaluate(state, load.average); });
    }
    if (report.converged) {
      midpoint_.set_change(d, state.p, dp_);
      report.dissipated = midpoint_.dissipated(d, dp_) + rest_work_;
      state.q += d;
      state.p += dp_;
      kick_low(state, load.end);
    }
    return finish(report, state);
  }

  std::optional<Split> split() const override { return split_; }
  void carry(StateStream& stream) override { stream(V_, S_ends_); }

 private:
  void kick_low(State& state, const VectorXd& f) {
    if (split_.low == 0) return;
    q_low_ = state.q.head(split_.low);
    state.p.head(split_.low) += 0.5 * h_ * (f.head(split_.low) - S_ends_.force(q_low_));
  }

  // The midpoint rule for V_fast, with all of the damping.
  double evaluate(const State& z, const VectorXd& f) {
    const double h = h_;
    const Index low = split_.low, high = split_.high;
    const VectorXd& d = newton_.unknowns;
    qm_ = z.q + 0.5 * d;
    auto& [V, R, K] = V_.evaluate(qm_, kWantForce | kWantTangent);
    // The norm is that of the whole force: its rest on the low rows is rounded like the whole.
    const double R_norm = R.norm();
    newton_.jacobian = (0.5 * h * strain_.beta()) * K;
    if (low > 0) {
      q_low_ = qm_.head(low);
      const auto& [V_slow, S, dS] = S_middle_.evaluate(q_low_, kWantForce | kWantTangent);
      R.head(low) -= S;
      K.topLeftCorner(low, low) -= dS;
    }
    newton_.residual.array() = (d - h * z.p).array() / midpoint_.g.array() +
                               (0.5 * h) * (h * R + D_.cwiseProduct(d)).array();
    newton_.residual.tail(high) -= (0.5 * h * h) * f.tail(high);
    newton_.jacobian += (0.25 * h * h) * K;
    newton_.jacobian.diagonal().array() += midpoint_.g.array().inverse() + (0.5 * h) * D_.array();
    if (strain_.present()) {
      newton_.jacobian.diagonal() -= (0.5 * h * strain_.beta()) * model_->lambda();
      rest_work_ = strain_.force(qm_, d, rest_) / h;
      newton_.residual += (0.5 * h) * rest_;
    }
    return relative_residual(newton_.residual.norm(), tolerance_, h, z.p.norm(), R_norm,
                             f.tail(high).norm());
  }

  Split split_;
  DampedMidpoint midpoint_;
  Potential V_slow_;         // V(q_l, 0)
  PotentialCache S_ends_;    // its gradient at q0 and q1
  PotentialCache S_middle_;  // and at qm
  VectorXd q_low_;           // low rows of a q
  VectorXd dp_;
};

}  // namespace

MadeIntegrator make_imexv_coupled(Model::Pointer model, const IntegratorOptions& options) {
  return make_split_method<ImexvCoupled>(std::move(model), options);
}

}  // namespace tremolo
