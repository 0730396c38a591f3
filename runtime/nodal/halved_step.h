// A step that fails is divided into parts.
#pragma once

#include "runtime/nodal/nodal_work.h"

namespace tremolo {

// The methods' common part. A method implements one advance by h; where that fails it must leave
// the state unchanged, and smaller parts are tried.
class HalvedIntegrator : public NodalIntegrator {
 public:
  HalvedIntegrator(const NodalSystem& system, const NodalOptions& options);
  NodalReport step(NodalState& state) final;
  void reset() override {}

 protected:
  // Adds to the report's iterations, residual and energies. False: the step failed.
  virtual bool advance(NodalState& state, double h, NodalReport& report) = 0;

  // Moves the state to x1, v1, which receive the state before the step; fixed nodes are set. share:
  // same as for NodalContact::keep(). Adds its energies to the report.
  void take_step(NodalState& state, double h, double share, Eigen::VectorXd& x1,
                 Eigen::VectorXd& v1, NodalReport& report);

  const NodalSystem& system() const { return system_; }
  const NodalOptions& options() const { return options_; }
  StepLedger& ledger() { return ledger_; }

 private:
  const NodalSystem& system_;
  NodalOptions options_;
  StepLedger ledger_;
  NodalState before_;
};

// Sets v of the fixed nodes to (x1 - x0)/h, and their x to their positions at the time.
void put_held_nodes(const NodalSystem& system, double time, double h, const Eigen::VectorXd& x0,
                    Eigen::VectorXd& x, Eigen::VectorXd& v);

}  // namespace tremolo
