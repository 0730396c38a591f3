#include "runtime/integrators/implicit_euler.h"

#include <algorithm>
#include <utility>

#include "runtime/integrators/solve/damping.h"
#include "runtime/integrators/solve/newton.h"

namespace tremolo {
namespace {

class ImplicitEuler final : public Integrator {
 public:
  ImplicitEuler(Model::Pointer model, const IntegratorOptions& options)
      : model_(std::move(model)),
        options_(options),
        rates_(damping_rates(model_->lambda(), options.alpha, options.beta)),
        workspace_(model_->potential().make_workspace(kUseTangent)),
        evaluation_(model_->potential().make_evaluation()),
        end_(Eigen::VectorXd::Zero(model_->modes())),
        newton_(model_->modes()) {}

  StepReport step(State& state, const StepLoad& load) noexcept override {
    const double h = options_.step;
    Eigen::VectorXd& d = newton_.unknowns;
    d = h * state.p;
    StepReport report =
        solve_newton(newton_, options_.max_iterations, [&] { return evaluate(state, load); });
    if (!report.converged) return report;
    report.dissipated = (d.array().square() * rates_.array()).sum() / h;
    state.q += d;
    state.p = d / h;
    return report;
  }

  std::string_view name() const override { return "implicit-euler"; }

 private:
  double evaluate(const State& state, const StepLoad& load) {
    const double h = options_.step;
    const Eigen::VectorXd& d = newton_.unknowns;
    end_ = state.q + d;
    model_->potential().evaluate(end_, kWantForce | kWantTangent, workspace_, evaluation_);
    newton_.residual =
        d - h * state.p + (h * h) * (evaluation_.force - load.average) + h * rates_.cwiseProduct(d);
    newton_.jacobian = (h * h) * evaluation_.tangent;
    newton_.jacobian.diagonal().array() += 1.0 + h * rates_.array();
    const double scale = std::max(
        {h * state.p.norm(), h * h * evaluation_.force.norm(), h * h * load.average.norm()});
    return relative_size(newton_.residual.norm(), options_.tolerance, scale);
  }

  Model::Pointer model_;
  IntegratorOptions options_;
  Eigen::VectorXd rates_;
  PotentialWorkspace workspace_;
  Evaluation evaluation_;
  Eigen::VectorXd end_;
  NewtonWorkspace newton_;
};

}  // namespace

std::unique_ptr<Integrator> make_implicit_euler(Model::Pointer model,
                                                const IntegratorOptions& options) {
  return std::make_unique<ImplicitEuler>(std::move(model), options);
}

}  // namespace tremolo
