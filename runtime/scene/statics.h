// Solves for the shapes in which a model is in equilibrium.
#pragma once

#include <Eigen/Core>

#include "common/result.h"
#include "runtime/kernels/potential.h"

namespace tremolo {

// Linear constraints rows q = target. rows: c x r, of full rank; target: c; c = 0: none.
struct Hold {
  Eigen::MatrixXd rows;
  Eigen::VectorXd target;
};

// The q (r) with grad V(q) = force + rows^T x and rows q = target, x being the constraint forces.
// The path from rest is followed by load increments, each solved by Newton's method and halved
// where that does not converge. Errors: kContent if the constrained rows are not independent,
// kSolver if the path cannot be followed to its end or the equilibrium there is not stable.
Result<Eigen::VectorXd> standing_shape(const Potential& potential, const Eigen::VectorXd& force,
                                       const Hold& hold = {});

}  // namespace tremolo
