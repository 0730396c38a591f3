// The step of a free body without coordinates: that of its frame alone
// (runtime/bodies/reduced/frames/free_frame.h), which keeps energy and both momenta.
#include <utility>

#include "runtime/bodies/reduced/frames/step_coupling.h"
#include "runtime/bodies/reduced/integrators/methods.h"

namespace tremolo {
namespace {

class RigidStep final : public Integrator {
 public:
  RigidStep(std::string_view name, double step) : name_(name), step_(step) {}

  StepReport step(State& state, const StepLoad& load) noexcept override {
    StepReport report;
    report.converged = load.coupling != nullptr;
    if (!report.converged) return report;
    load.coupling->begin(step_, state.q, state.p);
    load.coupling->evaluate(none_, none_, change_, force_);
    report.converged = load.coupling->finish(none_, 0.0, state.p);
    return report;
  }
  void carry(StateStream&) override {}
  std::string_view name() const override { return name_; }

 private:
  std::string_view name_;
  double step_;
  Eigen::VectorXd none_, change_, force_;  // of no entries
};

}  // namespace

IntegratorPointer make_rigid_step(std::string_view name, const IntegratorOptions& options) {
  return std::make_unique<RigidStep>(name, options.step);
}

}  // namespace tremolo
