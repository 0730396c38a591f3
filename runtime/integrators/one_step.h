// What most methods have in common, in the symbols of docs/theory.md:
//
//     q'' + D q' + R(q) = f(t),     R = grad V,   K = grad R,   p = q'
//
// from (q0, p0) to (q1, p1) in the step h. A method derives from OneStep, opens its file with its
// equation and writes that down in step().
#pragma once

#include <string_view>
#include <utility>

#include "runtime/integrators/methods.h"
#include "runtime/integrators/solve/damping.h"
#include "runtime/integrators/solve/potential_cache.h"

namespace tremolo {

class OneStep : public Integrator {
 public:
  std::string_view name() const final { return name_; }
  std::optional<double> known_potential(const Eigen::VectorXd& q) const final {
    return V_.known_energy(q);
  }
  void carry(StateStream& stream) override { stream(V_); }

 protected:
  // want, uses: those of the PotentialCache.
  OneStep(std::string_view name, Model::Pointer model, const IntegratorOptions& options,
          unsigned want = kWantEnergy | kWantForce, unsigned uses = kUsePoint)
      : name_(name),
        model_(std::move(model)),
        h_(options.step),
        D_(damping_rates(model_->lambda(), options.alpha, options.beta)),
        V_(model_->potential(), want, uses),
        z0_{D_, D_} {}

  // Ends the step that began at z0_: where its solve failed or a number is not finite, the state is
  // put back to z0_ and the report says so.
  StepReport finish(StepReport report, State& state) const {
    report.converged = report.converged && state.q.allFinite() && state.p.allFinite();
    if (!report.converged) state = z0_;
    return report;
  }

  // k = F(t, z), the rates of z = (q, p) under the load f:  q' = p,  p' = f - R(q) - D p.
  void rates(const State& z, const Eigen::VectorXd& f, State& k) const {
    k.q = z.p;
    k.p = f - V_.force(z.q) - D_.cwiseProduct(z.p);
  }

  // to = from + s k.
  static void advance(const State& from, double s, const State& k, State& to) {
    to.q = from.q + s * k.q;
    to.p = from.p + s * k.p;
  }

  // p.D p, W: what damping takes at the velocity p.
  template <class Velocity>
  double dissipation(const Eigen::MatrixBase<Velocity>& p) const {
    return (p.array().square() * D_.array()).sum();
  }

  std::string_view name_;
  Model::Pointer model_;
  double h_;                  // s
  Eigen::VectorXd D_;         // the diagonal of D, 1/s, r
  mutable PotentialCache V_;  // V, R and K
  State z0_;                  // (q0, p0), for methods that change the state before they know
};

}  // namespace tremolo
