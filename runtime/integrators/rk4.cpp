#include "runtime/integrators/rk4.h"

#include <array>
#include <utility>

#include "runtime/integrators/solve/damping.h"

namespace tremolo {
namespace {

// node: where the stage stands, in steps. It is reached with the rates of the stage before it.
struct Stage {
  double node;
  double weight;
};
constexpr std::array kStages = {Stage{0.0, 1.0 / 6.0}, Stage{0.5, 1.0 / 3.0}, Stage{0.5, 1.0 / 3.0},
                                Stage{1.0, 1.0 / 6.0}};

class Rk4 final : public Integrator {
 public:
  Rk4(Model::Pointer model, const IntegratorOptions& options)
      : model_(std::move(model)),
        step_(options.step),
        rates_(damping_rates(model_->lambda(), options.alpha, options.beta)),
        workspace_(model_->potential().make_workspace(kUsePoint)),
        evaluation_(model_->potential().make_evaluation()),
        start_{rates_, rates_},
        stage_{rates_, rates_},
        acceleration_(rates_),
        load_(rates_) {}

  StepReport step(State& state, const StepLoad& load) noexcept override {
    StepReport report;
    double work = 0.0;
    start_ = state;
    stage_ = state;
    acceleration_.setZero();
    for (const auto& [node, weight] : kStages) {
      stage_.q = start_.q + (node * step_) * stage_.p;
      stage_.p = start_.p + (node * step_) * acceleration_;
      load_at(load, node, load_);
      model_->potential().evaluate(stage_.q, kWantForce, workspace_, evaluation_);
      acceleration_ = load_ - evaluation_.force - rates_.cwiseProduct(stage_.p);
      const double share = weight * step_;
      state.q += share * stage_.p;
      state.p += share * acceleration_;
      report.dissipated += share * (stage_.p.array().square() * rates_.array()).sum();
      work += share * load_.dot(stage_.p);
    }
    report.extra_work = work - load.average.dot(state.q - start_.q);
    report.converged = state.q.allFinite() && state.p.allFinite();
    if (!report.converged) state = start_;
    return report;
  }

  std::string_view name() const override { return "rk4"; }

 private:
  Model::Pointer model_;
  double step_;
  Eigen::VectorXd rates_;
  PotentialWorkspace workspace_;
  Evaluation evaluation_;
  State start_;
  State stage_;
  Eigen::VectorXd acceleration_;
  Eigen::VectorXd load_;
};

}  // namespace

std::unique_ptr<Integrator> make_rk4(Model::Pointer model, const IntegratorOptions& options) {
  return std::make_unique<Rk4>(std::move(model), options);
}

}  // namespace tremolo
