#include "runtime/integrators/midpoint.h"

#include <algorithm>
#include <utility>

#include "runtime/integrators/solve/damping.h"
#include "runtime/integrators/solve/newton.h"

namespace tremolo {
namespace {

class Midpoint final : public Integrator {
 public:
  Midpoint(Model::Pointer model, const IntegratorOptions& options)
      : model_(std::move(model)),
        options_(options),
        rates_(damping_rates(model_->lambda(), options.alpha, options.beta)),
        workspace_(model_->potential().make_workspace(kUseTangent)),
        evaluation_(model_->potential().make_evaluation()),
        middle_(Eigen::VectorXd::Zero(model_->modes())),
        newton_(model_->modes()) {}

  StepReport step(State& state, const StepLoad& load) noexcept override {
    const double h = options_.step;
    Eigen::VectorXd& d = newton_.unknowns;
    d = h * state.p;
    StepReport report = solve_frozen(newton_, options_.max_iterations, [&](bool jacobian) {
      return evaluate(state, load, jacobian);
    });
    if (!report.converged) return report;
    report.dissipated = (d.array().square() * rates_.array()).sum() / h;
    state.q += d;
    state.p = (2.0 / h) * d - state.p;
    return report;
  }

  std::string_view name() const override { return "midpoint"; }

 private:
  double evaluate(const State& state, const StepLoad& load, bool jacobian) {
    const double h = options_.step;
    const Eigen::VectorXd& d = newton_.unknowns;
    middle_ = state.q + 0.5 * d;
    model_->potential().evaluate(middle_, jacobian ? kWantForce | kWantTangent : kWantForce,
                                 workspace_, evaluation_);
    newton_.residual = d - h * state.p + (0.5 * h * h) * (evaluation_.force - load.average) +
                       (0.5 * h) * rates_.cwiseProduct(d);
    if (jacobian) {
      newton_.jacobian = (0.25 * h * h) * evaluation_.tangent;
      newton_.jacobian.diagonal().array() += 1.0 + 0.5 * h * rates_.array();
    }
    const double scale = std::max(
        {h * state.p.norm(), h * h * evaluation_.force.norm(), h * h * load.average.norm()});
    return relative_size(newton_.residual.norm(), options_.tolerance, scale);
  }

  Model::Pointer model_;
  IntegratorOptions options_;
  Eigen::VectorXd rates_;
  PotentialWorkspace workspace_;
  Evaluation evaluation_;
  Eigen::VectorXd middle_;
  NewtonWorkspace newton_;
};

}  // namespace

std::unique_ptr<Integrator> make_midpoint(Model::Pointer model, const IntegratorOptions& options) {
  return std::make_unique<Midpoint>(std::move(model), options);
}

}  // namespace tremolo
