// The step of a free body without coordinates: that of its frame alone
// (runtime/bodies/reduced/frames/free_frame.h), which keeps energy and both momenta.
#include <utility>

#include "runtime/bodies/reduced/frames/step_coupling.h"
#include "runtime/bodies/reduced/integrators/methods.h"

namespace tremolo {
namespace {

class RigidStep final : public Integrator {
 public:
  RigidStep(std::string_view name, double step, int halvings)
      : name_(name), step_(step), halvings_(halvings) {}

  StepReport step(State& state, const StepLoad& load) noexcept override {
    StepReport report;
    report.converged = load.coupling != nullptr;
    if (!report.converged) return report;
    report.parts = 0;
    take(*load.coupling, state, step_, halvings_, report);
    return report;
  }
  void carry(StateStream&) override {}
  std::string_view name() const override { return name_; }

 private:
  // Takes a step of h, or two of half that if the spin at the end of h cannot be found.
  void take(StepCoupling& coupling, State& state, double h, int halvings, StepReport& report) {
    coupling.begin(h, state.q, state.p);
    coupling.evaluate(none_, none_, change_, force_);
    report.residual = coupling.unsolved();
    if (report.residual == 0.0) {
      report.converged = coupling.finish(none_, 0.0, state.p);
      ++report.parts;
      return;
    }
    ++report.iterations;
    report.converged = halvings > 0;
    for (int part = 0; part < 2 && report.converged; ++part)
      take(coupling, state, 0.5 * h, halvings - 1, report);
  }

  std::string_view name_;
  double step_;
  int halvings_;
  Eigen::VectorXd none_, change_, force_;  // of no entries
};

}  // namespace

IntegratorPointer make_rigid_step(std::string_view name, const IntegratorOptions& options) {
  return std::make_unique<RigidStep>(name, options.step, options.halvings);
}

}  // namespace tremolo
