// Newmark's method with the numbers beta and gamma (thesis 3.4.10-3.4.12), on
// a + D v + R(q) = f, with v = p since M = I:
//
//     q1 = q0 + h v0 + h^2 [(1/2 - beta) a0 + beta a1]
//     v1 = v0 + h [(1 - gamma) a0 + gamma a1]
//     a1 + D v1 + R(q1) = f((t+h)-)             D with its rest at q1 (solve/strain_damping.h)
//
// a0 is not carried over but recomputed from the left end's own load, a0 = f(t+) - D v0 - R(q0):
// where f jumps between two steps each step then sees the value on its side. The unknown is
// w = h^2 a1, which also serves beta = 0 (explicit in q, a diagonal solve):
//
//     w + h^2 [D v1 + R(q1) - f] = 0,   Jacobian I + gamma h D + beta h^2 K(q1)
//
// Second order for gamma = 1/2, first otherwise. beta = 1/4, gamma = 1/2, the default, is linearly
// stable for every h and time-reversible; beta = 0, gamma = 1/2 is Stoermer-Verlet without damping.
// `dissipated` is d.D d/h with d = q1 - q0, and d times the mean of the rest of D at the ends,
// which is its work in the step: second order.
//
// The solve begins at a prediction where the step before left one: with the Jacobian J of that step
// and its factor, K d = (J d - d - gamma h D d)/(beta h^2) gives R(q1) = R(q0) + K d + e, where e
// is the error of the same prediction in the step before.
#include <algorithm>

#include "runtime/bodies/reduced/integrators/implicit_step.h"

namespace tremolo {
namespace {

using Eigen::VectorXd;

class Newmark final : public ImplicitStep {
 public:
  Newmark(Model::Pointer model, const IntegratorOptions& options)
      : ImplicitStep("newmark", std::move(model), options),
        beta_(options.newmark_beta),
        gamma_(options.newmark_gamma),
        z1_{VectorXd::Zero(model_->modes()), VectorXd::Zero(model_->modes())} {
    for (VectorXd* v : {&a0_, &q1_, &v1_, &R_predicted_, &R_missed_, &Kd_, &rest0_, &rest1_})
      v->setZero(model_->modes());
  }

  StepReport step(State& state, const StepLoad& load) noexcept override {
    const VectorXd& R0 = V_.force(state.q);  // the last that the step before evaluated
    a0_ = load.start - D_.cwiseProduct(state.p) - R0;
    R0_norm_ = R0.norm();
    if (strain_.present()) begin_rest(state);
    VectorXd& w = newton_.unknowns;
    w = (h_ * h_) * a0_;
    if (!w.allFinite()) return {.residual = w.norm(), .converged = false};
    predicted_ = newton_.frozen && beta_ > 0.0 && z1_.q == state.q && z1_.p == state.p;
    if (predicted_) {
      predict(state, load, R0);
    } else {
      newton_.frozen = false;
      R_missed_.setZero();
    }
    StepReport report = solve_frozen(
        newton_, max_iterations_, [&](bool jacobian) { return evaluate(state, load, jacobian); });
    if (!report.converged) return report;
    report.dissipated = dissipation(q1_ - state.q) / h_;
    if (strain_.present()) report.dissipated += 0.5 * (q1_ - state.q).dot(rest0_ + rest_);
    state.q = q1_;
    state.p = v1_;
    z1_ = state;
    if (strain_.present()) rest1_ = rest_;
    return report;
  }

  void carry(StateStream& stream) override {
    stream(V_, newton_.frozen);
    if (newton_.frozen && stream.good()) stream(newton_.jacobian, newton_.cholesky, z1_, R_missed_);
    if (strain_.present()) stream(rest1_, z1_);
  }

 private:
  // The rest of the damping at the start.
  void begin_rest(const State& z0) {
    q1_ = z0.q + h_ * z0.p;
    strain_.stand_at(q1_);
    if (z1_.q == z0.q && z1_.p == z0.p)
      rest0_ = rest1_;
    else
      strain_.force(z0.q, z0.p, rest0_);
    a0_ -= rest0_;
  }

  // Sets w to the solution with the predicted R(q1).
  void predict(const State& z0, const StepLoad& load, const VectorXd& R0) {
    const double h = h_;
    VectorXd& w = newton_.unknowns;
    VectorXd& d = q1_;  // q1 - q0 in here
    v1_ = z0.p + (1.0 - gamma_) * h * a0_ + (gamma_ / h) * w;
    d = h * z0.p + (0.5 - beta_) * h * h * a0_ + beta_ * w;
    multiply_by_tangent(d);
    R_predicted_ = R0 + Kd_;
    if (strain_.present()) {
      rest_ = v1_ - z0.p;
      R_predicted_ += rest0_ + multiply_by_tangent_rest();
    }
    VectorXd& dw = newton_.correction;
    dw = w + (h * h) * (D_.cwiseProduct(v1_) + R_predicted_ + R_missed_ - load.end);
    newton_.cholesky.solve(dw);
    w -= dw;
    d = -beta_ * dw;
    multiply_by_tangent(d);
    R_predicted_ += Kd_;
    if (!strain_.present()) return;
    rest_ = (-gamma_ / h) * dw;
    R_predicted_ += multiply_by_tangent_rest();
  }

  // Kd_ = beta (K - Lambda) v for v = rest_, K as in multiply_by_tangent().
  const VectorXd& multiply_by_tangent_rest() {
    multiply_by_tangent(rest_);
    Kd_ -= model_->lambda().cwiseProduct(rest_);
    Kd_ *= strain_.beta();
    return Kd_;
  }

  // Kd_ = K d, with K from the Jacobian of the step before.
  void multiply_by_tangent(const VectorXd& d) {
    Kd_.noalias() = newton_.jacobian * d;
    Kd_ -= d + gamma_ * h_ * D_.cwiseProduct(d);
    if (strain_.present()) Kd_ += (gamma_ * h_ * strain_.beta()) * model_->lambda().cwiseProduct(d);
    Kd_ /= beta_ * h_ * h_ + gamma_ * h_ * strain_.beta();
  }

  double evaluate(const State& z0, const StepLoad& load, bool jacobian) {
    const double h = h_;
    const VectorXd& w = newton_.unknowns;
    q1_ = z0.q + h * z0.p + (0.5 - beta_) * h * h * a0_ + beta_ * w;
    v1_ = z0.p + (1.0 - gamma_) * h * a0_ + (gamma_ / h) * w;
    const bool tangent = jacobian && beta_ > 0.0;
    const auto& [V, R, K] = V_.evaluate(q1_, tangent ? kWantForce | kWantTangent : kWantForce);
    if (strain_.present()) strain_.force(q1_, v1_, rest_);
    if (jacobian && predicted_) {
      R_missed_ = R - R_predicted_;
      if (strain_.present()) R_missed_ += rest_;
      predicted_ = false;
    }
    newton_.residual = w + (h * h) * (D_.cwiseProduct(v1_) + R - load.end);
    if (strain_.present()) newton_.residual += (h * h) * rest_;
    if (jacobian) {
      const double of_damping = gamma_ * h * strain_.beta();
      if (tangent)
        newton_.jacobian = (beta_ * h * h + of_damping) * K;
      else
        newton_.jacobian.setZero();
      newton_.jacobian.diagonal().array() += 1.0 + gamma_ * h * D_.array();
      if (tangent && strain_.present())
        newton_.jacobian.diagonal() -= of_damping * model_->lambda();
    }
    return relative_residual(newton_.residual.norm(), tolerance_, h, z0.p.norm(), R0_norm_,
                             std::max(load.start.norm(), load.end.norm()));
  }

  double beta_;
  double gamma_;
  VectorXd a0_;
  VectorXd q1_;
  VectorXd v1_;
  double R0_norm_ = 0.0;
  bool predicted_ = false;  // w at first is that of predict()
  State z1_;                // of the last step that was made
  VectorXd R_predicted_;    // R(q1) by predict(), without R_missed_
  VectorXd R_missed_;       // R(q1) less R_predicted_ at the step before
  VectorXd Kd_;
  VectorXd rest0_;  // the rest of the damping at the start; rest_ is that at the end
  VectorXd rest1_;  // at the end of the last step that succeeded
};

}  // namespace

IntegratorPointer make_newmark(Model::Pointer model, const IntegratorOptions& options) {
  return std::make_unique<Newmark>(std::move(model), options);
}

}  // namespace tremolo
