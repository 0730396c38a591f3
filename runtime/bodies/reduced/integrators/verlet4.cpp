// A fourth-order explicit splitting: seven kicks around six drifts (Blanes & Moan 2002, "Practical
// symplectic partitioned Runge-Kutta and Runge-Kutta-Nystroem methods", J. Comput. Appl. Math.
// 142, the method SRKN_6^b).
//
// The motion is cut into two that can be solved exactly, time going with the drift:
//
//     drift by s:  q <- q + (1 - e^{-D s})/D p,  p <- e^{-D s} p,  t <- t + s   (q' = p, p' = -D p)
//     kick by s:   p <- p + s (f(t) - R(q))                          D = alpha + beta lambda_i
//
// and a step is  kick b1 h, drift a1 h, kick b2 h, ..., kick b4 h, ..., drift a1 h, kick b1 h,
// the same forwards and backwards. A symmetric composition has no even powers of h in its error, so
// the order is four as soon as the two terms of third order vanish, whatever the two flows are;
// damping and load keep it. That seven kicks then have freedom left for a small fifth-order term is
// because, with g = f - R, the fields A = (p, -D p) of the drift and B = (0, g(q, t)) of the kick
// have
//     [B, A] = (g, -D g - g_q p - g_t),   [B, [B, A]] = (0, -2 g_q g),   [B, [B, [B, A]]] = 0:
// the second is a function of q and t alone, as without damping. The coefficients are the paper's;
// they meet the conditions of third order to 3e-16, and tests check the observed order and the
// angle by which a linear mode turns.
//
// The part of the damping that depends on q (solve/strain_damping.h) is in the kicks, whose flow is
// then that of p' = f - R(q) - rest(q) p, exact too.
//
// f inside the step is the quadratic of runtime/load.h; the rule of nodes and weights b integrates
// it exactly, so that the impulse of any load is exact.
//
// The last force of a step is the first of the next: six forces a step. Symplectic and
// time-reversible without damping. Conditionally stable: linearly for h omega < 3.1634 (measured),
// that is 0.527 for each force (Verlet: 2). Of the drifts two go backwards, by 0.350 h: there
// damping puts energy in, and what it takes from a free momentum in the whole step is still exactly
// e^{-D h}.
//
// `dissipated` is the kinetic energy that the damped drifts take, exact for this composition and
// so fourth order. extra_work is the work of f in the kicks less average.(q1 - q0): fourth order.
#include <array>
#include <cmath>

#include "runtime/bodies/reduced/integrators/one_step.h"
#include "runtime/bodies/reduced/integrators/solve/strain_damping.h"

namespace tremolo {
namespace {

constexpr double kB1 = 0.0829844064174052;
constexpr double kB2 = 0.396309801498368;
constexpr double kB3 = -0.0390563049223486;
constexpr double kB4 = 1.0 - 2.0 * (kB1 + kB2 + kB3);
constexpr double kA1 = 0.245298957184271;
constexpr double kA2 = 0.604872665711080;
constexpr double kA3 = 0.5 - (kA1 + kA2);

constexpr std::array kDrifts = {kA1, kA2, kA3};  // in steps; then backwards

// Each kick except the last is followed by the drift of that number in kDrifts.
struct Kick {
  double weight;
  double node;  // in steps
  int drift;
};
constexpr std::array kKicks = {Kick{kB1, 0.0, 0}, Kick{kB2, kA1, 1},       Kick{kB3, kA1 + kA2, 2},
                               Kick{kB4, 0.5, 2}, Kick{kB3, 0.5 + kA3, 1}, Kick{kB2, 1.0 - kA1, 0},
                               Kick{kB1, 1.0, -1}};

// The exact flow of q' = p, p' = -D p over one drift.
struct Drift {
  Eigen::VectorXd reach;  // (1 - e^{-D s})/D, s
  Eigen::VectorXd decay;  // e^{-D s}
};

Drift make_drift(const Eigen::VectorXd& D, double s) {
  return {D.unaryExpr([s](double rate) {
            const double x = rate * s;  // zero also where a tiny rate underflows
            return x == 0.0 ? s : s * (-std::expm1(-x) / x);
          }),
          (-s * D.array()).exp().matrix()};
}

class Verlet4 final : public OneStep {
 public:
  Verlet4(Model::Pointer model, const IntegratorOptions& options)
      : OneStep("verlet4", std::move(model), options),
        damped_(D_.maxCoeff() > 0.0),
        f_(D_),
        dp_(D_),
        flow_{D_, D_, D_} {
    for (std::size_t i = 0; i < kDrifts.size(); ++i) drifts_[i] = make_drift(D_, kDrifts[i] * h_);
  }

  StepReport step(State& state, const StepLoad& load) noexcept override {
    auto& [q, p] = state;
    StepReport report;
    double work = 0.0;
    z0_ = state;
    for (const auto& [weight, node, drift] : kKicks) {
      const double share = weight * h_;
      load_at(load, node, f_);
      if (strain_.present()) {
        dp_ = f_ - V_.force(q);
        report.dissipated += flow_with_strain_damping(strain_, q, dp_, share, p, flow_);
        work += f_.dot(flow_.path);
      } else {
        dp_ = share * (f_ - V_.force(q));
        work += share * f_.dot(p + 0.5 * dp_);
        p += dp_;
      }
      if (drift < 0) break;
      const auto& [reach, decay] = drifts_[drift];
      q.array() += reach.array() * p.array();
      if (damped_) report.dissipated += decay_momentum(decay, p);
    }
    report.extra_work = work - load.average.dot(q - z0_.q);
    return finish(report, state);
  }

 private:
  bool damped_;
  std::array<Drift, kDrifts.size()> drifts_;
  Eigen::VectorXd f_;
  Eigen::VectorXd dp_;  // of one kick
  StrainFlowScratch flow_;
};

}  // namespace

double verlet4_cosine(double z) {
  // The step's columns, from (q, h p) = (1, 0) and (0, 1).
  double trace = 0.0;
  for (const bool second : {false, true}) {
    double q = second ? 0.0 : 1.0, p = second ? 1.0 : 0.0;
    for (const Kick& kick : kKicks) {
      p -= kick.weight * z * z * q;
      if (kick.drift >= 0) q += kDrifts[static_cast<std::size_t>(kick.drift)] * p;
    }
    trace += second ? p : q;
  }
  return 0.5 * trace;
}

IntegratorPointer make_verlet4(Model::Pointer model, const IntegratorOptions& options) {
  return std::make_unique<Verlet4>(std::move(model), options);
}

}  // namespace tremolo
