// imex: the stiff forces by the implicit midpoint rule between two half kicks of the soft ones,
//
//   v+ = v0 + h/2 a_soft(x0, v0)
//   2 M (x1 - x0 - h v+)/h^2 = f_stiff((x0 + x1)/2, (x1 - x0)/h),   v- = 2 (x1 - x0)/h - v+
//   v1 = v- + h/2 a_soft(x1, v1)
//
// The method is of second order, also with soft dampers: the last line uses two sweeps, whose error
// is of third order in h. Soft forces must obey h omega < 2.
#include "runtime/step/halved_step.h"
#include "runtime/step/implicit_solve.h"

namespace tremolo {
namespace {

class SplitStep : public HalvedIntegrator {
 public:
  SplitStep(const NodalSystem& system, const NodalOptions& options,
            std::unique_ptr<ImplicitSolve> solve)
      : HalvedIntegrator(system, options), solve_(std::move(solve)) {
    x1_ = v_ = v1_ = x_hat_ = v_hat_ = f_ = Eigen::VectorXd::Zero(3 * system.mass().size());
  }
  std::string_view name() const override { return "imex"; }
  void carry(StateStream& stream) override { solve_->carry(stream); }

 protected:
  bool advance(NodalState& state, double h, NodalReport& report) override {
    v_ = state.v;
    kick(state.x, state.v, 0.5 * h, v_);
    x_hat_ = state.x + h * v_;
    x1_ = x_hat_;
    put_held_nodes(system(), state.time + h, h, state.x, x1_, v1_);
    const ImplicitEquation equation{.mu = 2.0 / (h * h),
                                    .theta = 0.5,
                                    .kappa = 1.0 / h,
                                    .x0 = &state.x,
                                    .x_hat = &x_hat_,
                                    .v_hat = &v_hat_,
                                    .part = ForcePart::kStiff};
    if (!solve_->solve(equation, x1_, false, report)) return false;
    v_ = (2.0 / h) * (x1_ - state.x) - v_;
    v1_ = v_;
    kick(x1_, v_, 0.5 * h, v1_);
    v_hat_.swap(v1_);
    v1_ = v_;
    kick(x1_, v_hat_, 0.5 * h, v1_);
    v_hat_.setZero();
    put_held_nodes(system(), state.time + h, h, state.x, x1_, v1_);
    if (!x1_.allFinite() || !v1_.allFinite()) return false;
    take_step(state, h, 1.0, x1_, v1_, report);
    return true;
  }

 private:
  // v += h a_soft(x, at); fixed nodes are set afterwards.
  void kick(const Eigen::VectorXd& x, const Eigen::VectorXd& at, double h, Eigen::VectorXd& v) {
    system().force(x, at, ForcePart::kSoft, f_);
    const Eigen::VectorXd& mass = system().mass();
    for (Eigen::Index i = 0; i < mass.size(); ++i)
      if (system().held()[i] == 0) v.segment<3>(3 * i) += (h / mass[i]) * f_.segment<3>(3 * i);
  }

  std::unique_ptr<ImplicitSolve> solve_;
  Eigen::VectorXd x1_, v_, v1_, x_hat_, v_hat_, f_;
};

}  // namespace

Result<std::unique_ptr<NodalIntegrator>> make_split(const NodalSystem& system,
                                                    const NodalOptions& options) {
  Result<std::unique_ptr<ImplicitSolve>> solve = ImplicitSolve::create(system, options);
  if (!solve) return solve.error();
  return std::unique_ptr<NodalIntegrator>(
      std::make_unique<SplitStep>(system, options, std::move(*solve)));
}

}  // namespace tremolo
