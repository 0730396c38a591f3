// The step of a linear model, V = 1/2 q^T Lambda q: its coordinates do not couple, and each is a
// damped driven oscillator whose solution is known
// (runtime/bodies/reduced/integrators/solve/damping.h). With f inside the step the quadratic of
// runtime/load.h, f = g0 + g1 s + g2 s^2, s = (t - t0)/h, and J_k, u of that header, a = D h, b =
// lambda h^2,
//
//     q1 = (u' + D u) q0 + h J_0 p0 + h^2 (g0 J_1 + g1 J_2 + 2 g2 J_3)
//     p1 =  -(b/h) J_0 q0 +  u' p0  + h   (g0 J_0 + g1 J_1 + 2 g2 J_2)
//
// for any h: exact for free motion and for loads that are such quadratics, constant ones among
// them; of another smooth load the error is that of the quadratic, O(h^4).
//
// Without damping the free part is the rotation by h omega. It is made of three shears,
//
//     q += t p,  p -= s q,  q += t p,     t = tan(h omega/2)/omega,  s = omega sin(h omega),
//
// h omega taken modulo pi and the sign put right: their product keeps areas whatever the rounding
// of t and s, so that energy does not drift, as it would by 1e-16 a step with the rounded matrix.
//
// Work and dissipation are exact: `extra_work` is the integral of (f - average).p over the step,
// `dissipated` is work - (H1 - H0), rounding included, and zero without damping. A damped
// coordinate that has fallen below 1e-290 becomes zero, before it becomes a denormal number, with
// which processors are slow. O(r) a step, nothing is solved: `iterations` is 0.
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "common/processor.h"
#include "runtime/bodies/reduced/integrators/methods.h"
#include "runtime/bodies/reduced/integrators/solve/damping.h"

namespace tremolo {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;

constexpr double kNothing = 1e-290;  // of q and p, in their units

// A quantity of the step as q q0 + p p0 + g0 g0 + g1 g1 + g2 g2: the five coefficients, each r
// long.
struct Combination {
  explicit Combination(Index r) : q(r), p(r), g0(r), g1(r), g2(r) {}
  ArrayXd q, p, g0, g1, g2;
};

// The free, undamped motion: q += t p, p -= s q, q += t p, all times sign; each r long.
struct Shears {
  explicit Shears(Index r) : t(r), s(r), sign(r) {}
  ArrayXd t, s, sign;
};

void set_shear(double lambda, double h, Index i, Shears& shears) {
  const double omega = std::sqrt(lambda);
  int turns = 0;
  const double angle = std::remquo(h * omega, std::numbers::pi, &turns);
  shears.t[i] = omega == 0.0 ? 0.5 * h : std::tan(0.5 * angle) / omega;
  shears.s[i] = omega * std::sin(angle);
  shears.sign[i] = turns % 2 == 0 ? 1.0 : -1.0;
}

// ---- one pass over the coordinates each ----

TREMOLO_CLONES void rotate(const Shears& shears, Index r, double* q, double* p) {
  const double *t = shears.t.data(), *s = shears.s.data(), *sign = shears.sign.data();
#pragma omp simd
  for (Index i = 0; i < r; ++i) {
    const double middle = q[i] + t[i] * p[i];
    const double end = p[i] - s[i] * middle;
    q[i] = sign[i] * (middle + t[i] * end);
    p[i] = sign[i] * end;
  }
}

TREMOLO_CLONES void decay(const Combination& to_q, const Combination& to_p, Index r, double* q,
                          double* p) {
  const double *qq = to_q.q.data(), *qp = to_q.p.data();
  const double *pq = to_p.q.data(), *pp = to_p.p.data();
#pragma omp simd
  for (Index i = 0; i < r; ++i) {
    const double next = qq[i] * q[i] + qp[i] * p[i];
    const double end = pq[i] * q[i] + pp[i] * p[i];
    q[i] = std::abs(next) < kNothing ? 0.0 : next;
    p[i] = std::abs(end) < kNothing ? 0.0 : end;
  }
}

TREMOLO_CLONES void add_load(const Combination& to_q, const Combination& to_p, const StepLoad& load,
                             Index r, double* q, double* p) {
  const double *f0 = load.start.data(), *mean = load.average.data(), *f1 = load.end.data();
  const double *q0 = to_q.g0.data(), *q1 = to_q.g1.data(), *q2 = to_q.g2.data();
  const double *p0 = to_p.g0.data(), *p1 = to_p.g1.data(), *p2 = to_p.g2.data();
#pragma omp simd
  for (Index i = 0; i < r; ++i) {
    const double g1 = 6.0 * mean[i] - 4.0 * f0[i] - 2.0 * f1[i];
    const double g2 = 3.0 * (f0[i] + f1[i]) - 6.0 * mean[i];
    q[i] += f0[i] * q0[i] + g1 * q1[i] + g2 * q2[i];
    p[i] += f0[i] * p0[i] + g1 * p1[i] + g2 * p2[i];
  }
}

// H1 - H0, J, as products of differences and sums: a small change of a large energy is not lost.
TREMOLO_CLONES double energy_change(const double* lambda, const State& from, const State& to,
                                    Index r) {
  const double *q0 = from.q.data(), *p0 = from.p.data(), *q1 = to.q.data(), *p1 = to.p.data();
  double sum = 0.0;
#pragma omp simd reduction(+ : sum)
  for (Index i = 0; i < r; ++i)
    sum += (p1[i] - p0[i]) * (p1[i] + p0[i]) + lambda[i] * (q1[i] - q0[i]) * (q1[i] + q0[i]);
  return 0.5 * sum;
}

// The integral of (f - average).p over the step, J. By parts, with the averages of q and of s q:
//     f - average = g1 (s - 1/2) + g2 (s^2 - 1/3).
// mean: the average of q. double_integral: that of q, over h^2; mean - double_integral is the
// average of s q.
TREMOLO_CLONES double extra_work(const Combination& mean, const Combination& double_integral,
                                 const State& from, const State& to, const StepLoad& load,
                                 Index r) {
  const double *f0 = load.start.data(), *average = load.average.data(), *f1 = load.end.data();
  const double *q0 = from.q.data(), *p0 = from.p.data(), *q1 = to.q.data();
  const double *mq = mean.q.data(), *mp = mean.p.data(), *m0 = mean.g0.data();
  const double *m1 = mean.g1.data(), *m2 = mean.g2.data();
  const double *dq = double_integral.q.data(), *dp = double_integral.p.data(),
               *d0 = double_integral.g0.data();
  const double *d1 = double_integral.g1.data(), *d2 = double_integral.g2.data();
  double sum = 0.0;
#pragma omp simd reduction(+ : sum)
  for (Index i = 0; i < r; ++i) {
    const double g1 = 6.0 * average[i] - 4.0 * f0[i] - 2.0 * f1[i];
    const double g2 = 3.0 * (f0[i] + f1[i]) - 6.0 * average[i];
    const double of_q = mq[i] * q0[i] + mp[i] * p0[i] + m0[i] * f0[i] + m1[i] * g1 + m2[i] * g2;
    const double of_sq =
        of_q - (dq[i] * q0[i] + dp[i] * p0[i] + d0[i] * f0[i] + d1[i] * g1 + d2[i] * g2);
    sum += g1 * (0.5 * (q0[i] + q1[i]) - of_q) + g2 * ((2.0 * q1[i] + q0[i]) / 3.0 - 2.0 * of_sq);
  }
  return sum;
}

// ---- the method ----

class ExactLinear final : public Integrator {
 public:
  ExactLinear(std::string_view name, Model::Pointer model, const IntegratorOptions& options)
      : name_(name),
        model_(std::move(model)),
        shears_(model_->modes()),
        to_q_(model_->modes()),
        to_p_(model_->modes()),
        mean_q_(model_->modes()),
        double_integral_(model_->modes()),
        z0_{model_->lambda(), model_->lambda()} {
    const Eigen::VectorXd D = damping_rates(model_->lambda(), options);
    damped_ = D.size() > 0 && D.maxCoeff() > 0.0;
    for (Index i = 0; i < model_->modes(); ++i) {
      set_shear(model_->lambda()[i], options.step, i, shears_);
      set_rows(model_->lambda()[i], D[i], options.step, i);
    }
  }

  StepReport step(State& state, const StepLoad& load) noexcept override {
    const Index r = model_->modes();
    StepReport report;
    z0_ = state;
    if (damped_)
      decay(to_q_, to_p_, r, state.q.data(), state.p.data());
    else
      rotate(shears_, r, state.q.data(), state.p.data());
    if (load.active) add_load(to_q_, to_p_, load, r, state.q.data(), state.p.data());
    if (load.active && !(load.start == load.end && load.start == load.average))
      report.extra_work = extra_work(mean_q_, double_integral_, z0_, state, load, r);
    if (damped_) {
      report.dissipated = report.extra_work - energy_change(model_->lambda().data(), z0_, state, r);
      if (load.active) report.dissipated += load.average.dot(state.q - z0_.q);
    }
    report.converged = state.q.allFinite() && state.p.allFinite() &&
                       std::isfinite(report.extra_work) && std::isfinite(report.dissipated);
    if (!report.converged) {
      report.residual = std::numeric_limits<double>::infinity();  // numbers overflowed
      state = z0_;
    }
    return report;
  }

  void carry(StateStream&) override {}  // nothing
  std::string_view name() const override { return name_; }

 private:
  void set_rows(double lambda, double rate, double h, Index i) {
    const double a = rate * h, b = lambda * h * h;
    const LinearResponse response = linear_response(a, b);
    const auto& j = response.integral;
    set(to_q_, i, response.place, h * j[0], h * h, &j[1]);
    set(to_p_, i, -lambda * h * j[0], response.velocity, h, &j[0]);
    set(mean_q_, i, j[0] + a * j[1], h * j[1], h * h, &j[2]);
    set(double_integral_, i, j[1] + a * j[2], h * j[2], h * h, &j[3]);
  }

  // integrals: J_k, J_k+1, J_k+2 for the three parts of the load.
  static void set(Combination& row, Index i, double q, double p, double scale,
                  const double* integrals) {
    row.q[i] = q;
    row.p[i] = p;
    row.g0[i] = scale * integrals[0];
    row.g1[i] = scale * integrals[1];
    row.g2[i] = 2.0 * scale * integrals[2];
  }

  std::string_view name_;
  Model::Pointer model_;
  bool damped_ = false;
  Shears shears_;
  Combination to_q_;             // q1
  Combination to_p_;             // p1
  Combination mean_q_;           // of q over the step
  Combination double_integral_;  // the double integral of q over h^2
  State z0_;
};

}  // namespace

IntegratorPointer make_exact_linear(std::string_view name, Model::Pointer model,
                                    const IntegratorOptions& options) {
  return std::make_unique<ExactLinear>(name, std::move(model), options);
}

}  // namespace tremolo
