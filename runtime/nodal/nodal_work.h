// Where the energy of a step went.
#pragma once

#include "runtime/nodal/nodal_integrator.h"

namespace tremolo {

// 1/2 m v^2 of the nodes that are not held, J.
double free_kinetic(const NodalSystem& system, const Eigen::VectorXd& v);

// -f . (x1 - x0) over the nodes that are held: what those that move gave, J. f: the force on the
// nodes in the step.
double held_work(const NodalSystem& system, const Eigen::VectorXd& f, const Eigen::VectorXd& x0,
                 const Eigen::VectorXd& x1);

// Keeps what a step begins with, and tells at its end what its energy did (NodalReport). Nothing is
// allocated after the first.
class StepLedger {
 public:
  explicit StepLedger(const NodalSystem& system);
  void begin(const NodalState& state);
  // Of a method whose step is not told by step_force(): damping and wind by their power in the
  // middle of the step, what held nodes give by the force there.
  void end(const NodalState& state, double h, NodalReport& report);
  // Of one whose step is.
  void end(const NodalState& state, const StepWork& work, double held, NodalReport& report);

 private:
  const NodalSystem& system_;
  double energy_ = 0.0;
  Eigen::VectorXd x0_, x_, v_, f_;
};

}  // namespace tremolo
