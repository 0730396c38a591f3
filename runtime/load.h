// Forces in time, in the form that an integrator uses.
//
// A load is a signal s(t) times a reduced vector. A step uses three values of it: the one-sided
// limits at its two ends and the exact average over it (closed form). Methods that kick at the ends
// and methods that kick in the middle then transfer the same impulse. A signal that jumps strictly
// inside a step has its average at all three, so that even a pulse shorter than a step is
// transferred exactly.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "common/load_signal.h"
#include "common/result.h"
#include "runtime/model.h"

namespace tremolo {

// A load in time.
struct Load {
  Signal signal;
  Eigen::VectorXd force;  // reduced, f = sum over vertices of U_vertex^T F, r
};

class StepCoupling;

// The sum of all loads over one step.
struct StepLoad {
  Eigen::VectorXd start;             // r
  Eigen::VectorXd average;           // r
  Eigen::VectorXd end;               // r
  bool active = false;               // some signal is not zero in the step
  StepCoupling* coupling = nullptr;  // effect of a moving frame, for methods that use it; else null
};

StepLoad make_step_load(Eigen::Index modes);  // zero

// Sets `out` to the sum of the loads over [time, time + step]. Nothing is allocated.
void sample_loads(const std::vector<Load>& loads, double time, double step, StepLoad& out);

// Inside a step a load is the quadratic in time that has its two end values and its average; for a
// load that jumps inside the step that is a constant. Methods with stages inside the step and
// subdivided steps evaluate it here; the parts' averages add up to the whole step's exactly.

// The load at the fraction s of the step, 0 <= s <= 1.
void load_at(const StepLoad& load, double s, Eigen::VectorXd& out);

// The part [a, b] of the step as a step of its own, 0 <= a < b <= 1.
void restrict_load(const StepLoad& load, double a, double b, StepLoad& out);

// U_vertex^T F for a force F (N) on a vertex of the source mesh. Errors as Model::vertex, kUsage if
// the force is not finite or |U^T F|^2 overflows.
Result<Eigen::VectorXd> reduce_force(const Model& model, VertexId vertex,
                                     const Eigen::Vector3d& force);

// The same for forces on several vertices, each times `scale`.
Result<Eigen::VectorXd> reduce_load(const Model& model, const DefaultLoad& load,
                                    double scale = 1.0);

}  // namespace tremolo
