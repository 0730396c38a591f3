#include "runtime/integrators/newmark.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "runtime/integrators/solve/damping.h"
#include "runtime/integrators/solve/newton.h"

namespace tremolo {
namespace {

class Newmark final : public Integrator {
 public:
  Newmark(Model::Pointer model, const IntegratorOptions& options)
      : model_(std::move(model)),
        options_(options),
        rates_(damping_rates(model_->lambda(), options.alpha, options.beta)),
        workspace_(model_->potential().make_workspace(kUseTangent)),
        evaluation_(model_->potential().make_evaluation()),
        force_at_(
            Eigen::VectorXd::Constant(model_->modes(), std::numeric_limits<double>::quiet_NaN())),
        acceleration_(Eigen::VectorXd::Zero(model_->modes())),
        q1_(acceleration_),
        v1_(acceleration_),
        end_{acceleration_, acceleration_},
        expected_(acceleration_),
        missed_(acceleration_),
        stiff_(acceleration_),
        newton_(model_->modes()) {}

  StepReport step(State& state, const StepLoad& load) noexcept override {
    const double h = options_.step;
    // The last evaluation of the step before was made at the q it ended with.
    if (force_at_ != state.q)
      model_->potential().evaluate(state.q, kWantForce, workspace_, evaluation_);
    acceleration_ = load.start - rates_.cwiseProduct(state.p) - evaluation_.force;
    start_force_ = evaluation_.force.norm();
    newton_.unknowns = (h * h) * acceleration_;
    if (!newton_.unknowns.allFinite())
      return {.residual = newton_.unknowns.norm(), .converged = false};
    predicted_ =
        newton_.frozen && options_.newmark_beta > 0.0 && end_.q == state.q && end_.p == state.p;
    if (predicted_) {
      predict(state, load);
    } else {
      newton_.frozen = false;
      missed_.setZero();
    }
    StepReport report = solve_frozen(newton_, options_.max_iterations, [&](bool jacobian) {
      return evaluate(state, load, jacobian);
    });
    force_at_ = q1_;
    if (!report.converged) return report;
    report.dissipated = ((q1_ - state.q).array().square() * rates_.array()).sum() / h;
    state.q = q1_;
    state.p = v1_;
    end_ = state;
    return report;
  }

  std::string_view name() const override { return "newmark"; }

 private:
  // unknowns from h^2 a0 to the solution with R(q) = R(q0) + K (q - q0) + what the same guess
  // missed at the step before; K and the factor of the Jacobian are that step's.
  void predict(const State& state, const StepLoad& load) {
    const double h = options_.step;
    const double beta = options_.newmark_beta;
    const double gamma = options_.newmark_gamma;
    Eigen::VectorXd& w = newton_.unknowns;
    v1_ = state.p + (1.0 - gamma) * h * acceleration_ + (gamma / h) * w;
    q1_ = h * state.p + (0.5 - beta) * h * h * acceleration_ + beta * w;  // - q0
    stiff_.noalias() = newton_.jacobian * q1_;
    stiff_ -= q1_ + gamma * h * rates_.cwiseProduct(q1_);
    stiff_ /= beta * h * h;
    expected_ = evaluation_.force + stiff_;
    newton_.correction = w + (h * h) * (rates_.cwiseProduct(v1_) + expected_ + missed_ - load.end);
    newton_.cholesky.solve(newton_.correction);
    w -= newton_.correction;
    q1_ = -beta * newton_.correction;
    stiff_.noalias() = newton_.jacobian * q1_;
    stiff_ -= q1_ + gamma * h * rates_.cwiseProduct(q1_);
    expected_ += stiff_ / (beta * h * h);
  }

  double evaluate(const State& state, const StepLoad& load, bool jacobian) {
    const double h = options_.step;
    const double beta = options_.newmark_beta;
    const double gamma = options_.newmark_gamma;
    const Eigen::VectorXd& w = newton_.unknowns;
    q1_ = state.q + h * state.p + (0.5 - beta) * h * h * acceleration_ + beta * w;
    v1_ = state.p + (1.0 - gamma) * h * acceleration_ + (gamma / h) * w;
    const bool tangent = jacobian && beta > 0.0;
    const unsigned want = tangent ? kWantForce | kWantTangent : kWantForce;
    model_->potential().evaluate(q1_, want, workspace_, evaluation_);
    if (jacobian && predicted_) {
      missed_ = evaluation_.force - expected_;
      predicted_ = false;
    }
    newton_.residual = w + (h * h) * (rates_.cwiseProduct(v1_) + evaluation_.force - load.end);
    if (jacobian) {
      if (tangent)
        newton_.jacobian = (beta * h * h) * evaluation_.tangent;
      else
        newton_.jacobian.setZero();
      newton_.jacobian.diagonal().array() += 1.0 + gamma * h * rates_.array();
    }
    const double scale = std::max({h * state.p.norm(), h * h * start_force_,
                                   h * h * load.start.norm(), h * h * load.end.norm()});
    return relative_size(newton_.residual.norm(), options_.tolerance, scale);
  }

  Model::Pointer model_;
  IntegratorOptions options_;
  Eigen::VectorXd rates_;
  PotentialWorkspace workspace_;
  Evaluation evaluation_;
  Eigen::VectorXd force_at_;  // the q that evaluation_.force belongs to
  Eigen::VectorXd acceleration_;
  double start_force_ = 0.0;
  Eigen::VectorXd q1_;
  Eigen::VectorXd v1_;
  bool predicted_ = false;    // the unknowns at first are those of predict()
  State end_;                 // of the last step that was made
  Eigen::VectorXd expected_;  // R(q1) by predict()
  Eigen::VectorXd missed_;    // by that, at the step before
  Eigen::VectorXd stiff_;     // K times something
  NewtonWorkspace newton_;
};

}  // namespace

std::unique_ptr<Integrator> make_newmark(Model::Pointer model, const IntegratorOptions& options) {
  return std::make_unique<Newmark>(std::move(model), options);
}

}  // namespace tremolo
