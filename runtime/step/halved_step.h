// A step that fails is divided into parts.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>

#include "runtime/step/nodal_integrator.h"

namespace tremolo {

// 1/2 m v^2 of the nodes that are not fixed, J.
double free_kinetic(const NodalSystem& system, const Eigen::VectorXd& v);

// -f . (x1 - x0) over the fixed nodes: the work of those that are moved, J. f: the force on the
// nodes in the step.
double held_work(const NodalSystem& system, const Eigen::VectorXd& f, const Eigen::VectorXd& x0,
                 const Eigen::VectorXd& x1);

// Stores the values at the start of a step, and reports its energies at the end (NodalReport). The
// potential at the end of a step is that at the start of the next one, unless the system has
// another version. Nothing is allocated after the first step.
class StepLedger {
 public:
  // asked: false evaluates and reports nothing.
  StepLedger(const NodalSystem& system, bool asked);
  void begin(const NodalState& state);
  // Ends the step of a method without step_force(). Damping and wind are computed from their power
  // in the middle of the step, the work of fixed nodes from the force there. share: same as for
  // NodalContact.
  void end(const NodalState& state, double h, double share, NodalReport& report);
  // Ends the step of a method that reports its work.
  void end(const NodalState& state, const StepWork& work, double held, NodalReport& report);
  // Kinetic energy at the last end plus the size of the potential's change in that step, J.
  double turnover() const { return turnover_; }

 private:
  void tell(const NodalState& state, const StepWork& work, double held, double pressed,
            NodalReport& report);
  bool held_nodes_move(const Eigen::VectorXd& x1) const;

  const NodalSystem& system_;
  bool asked_;
  double energy_ = 0.0;
  double turnover_ = 0.0;
  double potential_ = 0.0;                // at x0_
  std::optional<std::uint64_t> version_;  // of potential_
  Eigen::VectorXd x0_, x_, v_, f_;
};

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

// The methods' makers; nodal_factory.cpp maps names to them.
std::unique_ptr<NodalIntegrator> make_explicit(std::string_view name, const NodalSystem& system,
                                               const NodalOptions& options);
Result<std::unique_ptr<NodalIntegrator>> make_implicit(std::string_view name,
                                                       const NodalSystem& system,
                                                       const NodalOptions& options);
Result<std::unique_ptr<NodalIntegrator>> make_split(const NodalSystem& system,
                                                    const NodalOptions& options);

}  // namespace tremolo
