// The state at rest under a constant force.
#pragma once

#include <Eigen/Core>

#include "common/result.h"
#include "runtime/math/kernels/potential.h"

namespace tremolo {

// Solves grad V(q) = force (r) from rest, the force in growing parts. Error: kContent if the
// stiffness stops being positive on the way (the force buckles the body), with the fraction of the
// force at which it does.
Result<Eigen::VectorXd> static_state(const Potential& potential, const Eigen::VectorXd& force);

}  // namespace tremolo
