// Where the energy of a step went.
#pragma once

#include <cstdint>
#include <optional>

#include "runtime/nodal/nodal_integrator.h"

namespace tremolo {

// 1/2 m v^2 of the nodes that are not held, J.
double free_kinetic(const NodalSystem& system, const Eigen::VectorXd& v);

// -f . (x1 - x0) over the nodes that are held: what those that move gave, J. f: the force on the
// nodes in the step.
double held_work(const NodalSystem& system, const Eigen::VectorXd& f, const Eigen::VectorXd& x0,
                 const Eigen::VectorXd& x1);

// Keeps what a step begins with, and tells at its end what its energy did (NodalReport). The
// potential at the end of a step is that at the beginning of the next one, unless the system says
// otherwise. Nothing is allocated after the first.
class StepLedger {
 public:
  // asked: otherwise nothing is evaluated and nothing told.
  StepLedger(const NodalSystem& system, bool asked);
  void begin(const NodalState& state);
  // Ends the step of a method that does not tell it by step_force(): damping and wind by their
  // power in the middle of the step, what held nodes give by the force there. share: as of
  // NodalContact.
  void end(const NodalState& state, double h, double share, NodalReport& report);
  // Ends the step of a method that tells it.
  void end(const NodalState& state, const StepWork& work, double held, NodalReport& report);
  // The kinetic energy at the last end, and how much the potential changed in that step, J.
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

}  // namespace tremolo
