// The classical Runge-Kutta method of four stages, on z = (q, p) with
// z' = F(t, z) = (p, f(t) - R(q) - D p):
//
//     k1 = F(t+, z0)
//     k2 = F(t + h/2, z0 + (h/2) k1)
//     k3 = F(t + h/2, z0 + (h/2) k2)
//     k4 = F((t + h)-, z0 + h k3)
//     z1 = z0 + (h/6) (k1 + 2 k2 + 2 k3 + k4)
//
// f inside the step is the quadratic of runtime/load.h. Its middle is off by O(h^4) of a smooth
// load's, and Simpson's rule is exact for it, so the step hands on the exact impulse of any load.
//
// Four forces a step. Fourth order, also with load and damping. Neither symplectic nor reversible:
// on q'' + omega^2 q = 0 a step multiplies the amplitude by |1 + z + z^2/2 + z^3/6 + z^4/24| at
// z = i y, y = h omega, the square of which is 1 - y^6/72 + y^8/576: it decays for
// y < sqrt 8 = 2.8284 and grows above: conditionally stable.
//
// `dissipated` is the same rule's integral of p.D p, extra_work that of f.p less fm.(q1 - q0), fm
// the average of f over the step: both fourth order.
#include <array>

#include "runtime/bodies/reduced/integrators/one_step.h"

namespace tremolo {
namespace {

// node: time of the stage, in steps. It is reached with the rates of the stage before it.
struct Stage {
  double node;
  double weight;
};
constexpr std::array kStages = {Stage{0.0, 1.0 / 6.0}, Stage{0.5, 1.0 / 3.0}, Stage{0.5, 1.0 / 3.0},
                                Stage{1.0, 1.0 / 6.0}};

class Rk4 final : public OneStep {
 public:
  Rk4(Model::Pointer model, const IntegratorOptions& options)
      : OneStep("rk4", std::move(model), options), z_(z0_), k_(z0_), f_(D_) {}

  StepReport step(State& state, const StepLoad& load) noexcept override {
    StepReport report;
    double work = 0.0;
    z0_ = state;
    k_.q.setZero();
    k_.p.setZero();
    for (const auto& [node, weight] : kStages) {
      const double share = weight * h_;
      advance(z0_, node * h_, k_, z_);
      load_at(load, node, f_);
      report.dissipated += share * rates(z_, f_, k_);
      advance(state, share, k_, state);
      work += share * f_.dot(z_.p);
    }
    report.extra_work = work - load.average.dot(state.q - z0_.q);
    return finish(report, state);
  }

 private:
  State z_;  // of the stage
  State k_;  // its rates
  Eigen::VectorXd f_;
};

}  // namespace

IntegratorPointer make_rk4(Model::Pointer model, const IntegratorOptions& options) {
  return std::make_unique<Rk4>(std::move(model), options);
}

}  // namespace tremolo
