// The implicit-explicit variational integrator in the thesis's own two-stage form (Huang 2011,
// algorithm 2 and (4.3.31)-(4.3.32)), as far as it makes sense.
//
//     stage 1   p_l <- p_l + h (f_l - R_l(q0) - D_l p_l)            the low rows' whole kick
//     stage 2   q_l <- q_l + h p_l
//               solve for d_h:  d_h - h p_h + (h^2/2) [R(qm) + D p1 - fm]_h = 0,  p1 = 2 d/h - p_h
//               Jacobian  I + (h^2/4) K_hh(qm) + h D_hh
//               p_h <- 2 d_h/h - p_h
//
// Two neighbouring half kicks of the symmetric step (imexv.cpp) are one whole kick here. Hence,
// without damping, the orbit of q is that of `imexv` whose low momenta start half a kick later; and
// the low momenta that are stored lag by half a kick, so an energy must be read from
// synchronized_momentum(), which adds the missing half.
//
// The part of the damping that depends on q (solve/strain_damping.h), which the thesis lacks,
// uses mean velocities: on high rows in the solve, on low rows as a kick after it.
//
// Kept as in the thesis:
//   - the merged kick, and a start that is not staggered: the given p is taken as the lagging one;
//   - damping by the velocity at the end of the step on high rows and by p_k on low ones: first
//     order against damping, and explicit on the low rows (stable only for h D_l < 2);
//   - the absolute tolerance in the maximum norm, |residual|_inf <= tolerance, in units of q;
//   - the Newton Jacobian is evaluated again in each iteration; the solve is over the high rows
//   only.
// Repaired, because the printed formula is wrong or another equation:
//   - (4.4.3) and line 9: the bracket is + (h^2/2) (R - f); line 12: A = I + (h^2/2) (K/2 + ...),
//     with the printed minus it is singular at h omega = 2;
//   - line 3 lacks h; R = -dV/dq contradicts the algorithm, which needs R = +dV/dq;
//   - line 18 starts from p_k^+, not p_k; and p_{k+1} is set also when the loop ends at j = 1;
//   - the damping Jacobian has the wrong sign and lacks the 1/h of its velocity;
//   - the damping matrix is alpha I + beta K(0) as in every other method here; the printed
//     alpha I + beta/2 K(qm), on high rows only, is another equation.
// Chosen, where the thesis is silent: it splits only damping between low and high and evaluates
// loads at q_k, that is at t_k. A whole kick at t_k sees the mean of the load's two one-sided
// values there (the end of the step before and the start of this one), which keeps the second order
// and gives a pulse its true impulse; the high rows see the average over the step. `dissipated` is
// the work of the damping force, first order.
//
// Conditionally stable, as `imexv`.
//
// Uses the default split unless options.split says otherwise.
#include "runtime/bodies/reduced/integrators/imexv/imexv_step.h"

namespace tremolo {
namespace {

class ImexvThesis final : public OneStep {
 public:
  ImexvThesis(Model::Pointer model, const IntegratorOptions& options, Split split)
      : OneStep("imexv-thesis", std::move(model), options),
        split_(split),
        high_(*model_, split, options, HighDamping::kEndVelocity, SolveNorm::kAbsolute),
        f_before_(Eigen::VectorXd::Zero(model_->modes())) {}

  StepReport step(State& state, const StepLoad& load) noexcept override {
    const Eigen::Index low = split_.low;
    z0_ = state;
    double dissipated = 0.0;
    if (low > 0) {
      auto p = state.p.head(low);
      const auto p0 = z0_.p.head(low), D = D_.head(low);
      const auto R = V_.force(state.q).head(low);
      p += h_ * (0.5 * (f_before_ + load.start).head(low) - R - D.cwiseProduct(p0));
      state.q.head(low) += h_ * p;
      dissipated = h_ * (D.array() * p0.array() * p.array()).sum();
    }
    StepReport report = high_.advance(z0_.q, state, load.average);
    report.dissipated += dissipated;
    if (report.converged && strain_.present()) {
      auto p = state.p.head(low);
      const double before = p.squaredNorm();
      p -= high_.rest().head(low);
      report.dissipated += 0.5 * (before - p.squaredNorm());
    }
    report = finish(report, state);
    if (!report.converged) return report;
    f_before_ = load.end;
    // The next step's kick needs it, and so does a caller that reads an energy in between. With the
    // evaluation here, a step's time includes all of its work.
    if (low > 0) V_.force(state.q);
    return report;
  }

  void reset() override { f_before_.setZero(); }
  void carry(StateStream& stream) override { stream(V_, f_before_); }
  void follow(const Integrator& before) override {
    if (const auto* other = dynamic_cast<const ImexvThesis*>(&before)) f_before_ = other->f_before_;
  }
  std::optional<Split> split() const override { return split_; }

  void synchronized_momentum(const State& state, Eigen::VectorXd& p) const override {
    p = state.p;
    if (split_.low == 0) return;
    const Eigen::VectorXd& R = V_.force(state.q);
    p.head(split_.low) += 0.5 * h_ * (f_before_ - R).head(split_.low);
  }

 private:
  Split split_;
  HighRows high_;
  Eigen::VectorXd f_before_;  // f((t_k)-), the load at the end of the step before
};

}  // namespace

MadeIntegrator make_imexv_thesis(Model::Pointer model, const IntegratorOptions& options) {
  return make_split_method<ImexvThesis>(std::move(model), options);
}

}  // namespace tremolo
