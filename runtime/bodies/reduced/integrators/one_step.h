// Common base of most methods, in the symbols of docs/theory.md:
//
//     q'' + D q' + R(q) = f(t),     R = grad V,   K = grad R,   p = q'
//
// with D = alpha + beta Lambda + 2 zeta Lambda^(1/2) + rest(q) (solve/damping.h,
// solve/strain_damping.h), from (q0, p0)
// to (q1, p1) in the step h. A method derives from OneStep, starts its file with its equation and
// implements it in step().
#pragma once

#include <string_view>
#include <utility>

#include "runtime/bodies/reduced/integrators/methods.h"
#include "runtime/bodies/reduced/integrators/solve/damping.h"
#include "runtime/bodies/reduced/integrators/solve/potential_cache.h"
#include "runtime/bodies/reduced/integrators/solve/strain_damping.h"

namespace tremolo {

class OneStep : public Integrator {
 public:
  std::string_view name() const final { return name_; }
  std::optional<double> known_potential(const Eigen::VectorXd& q) const final {
    return V_.known_energy(q);
  }
  void carry(StateStream& stream) override { stream(V_); }

 protected:
  // want, uses: arguments of the PotentialCache.
  OneStep(std::string_view name, Model::Pointer model, const IntegratorOptions& options,
          unsigned want = kWantEnergy | kWantForce, unsigned uses = kUsePoint)
      : name_(name),
        model_(std::move(model)),
        h_(options.step),
        D_(damping_rates(model_->lambda(), options)),
        V_(model_->potential(), want, uses),
        z0_{D_, D_},
        strain_(*model_, options.beta),
        rest_(Eigen::VectorXd::Zero(D_.size())) {}

  // Ends the step that started at z0_. If its solve failed or a number is not finite, the state
  // returns to z0_ and the report is not converged.
  StepReport finish(StepReport report, State& state) const {
    report.converged = report.converged && state.q.allFinite() && state.p.allFinite();
    if (!report.converged) state = z0_;
    return report;
  }

  // k = F(t, z), the rates of z = (q, p) under the load f:  q' = p,  p' = f - R(q) - D(q) p.
  // Returns the power taken by damping, W.
  double rates(const State& z, const Eigen::VectorXd& f, State& k) {
    k.q = z.p;
    k.p = f - V_.force(z.q) - D_.cwiseProduct(z.p);
    const double power = dissipation(z.p);
    if (!strain_.present()) return power;
    const double more = strain_.force_at(z.q, z.p, rest_);
    k.p -= rest_;
    return power + more;
  }

  // to = from + s k.
  static void advance(const State& from, double s, const State& k, State& to) {
    to.q = from.q + s * k.q;
    to.p = from.p + s * k.p;
  }

  // p.D p, W: power taken by damping at the velocity p, without the rest of StrainDamping.
  template <class Velocity>
  double dissipation(const Eigen::MatrixBase<Velocity>& p) const {
    return (p.array().square() * D_.array()).sum();
  }

  std::string_view name_;
  Model::Pointer model_;
  double h_;                  // s
  Eigen::VectorXd D_;         // the diagonal of D, 1/s, r
  mutable PotentialCache V_;  // V, R and K
  State z0_;              // (q0, p0), for methods that change the state before they have converged
  StrainDamping strain_;  // the part of the damping that depends on q
  Eigen::VectorXd rest_;  // its force or impulse, r
};

}  // namespace tremolo
