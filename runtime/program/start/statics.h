// Shapes in which a model stands still.
#pragma once

#include <Eigen/Core>

#include "common/result.h"
#include "runtime/kernels/potential.h"

namespace tremolo {

// What is held in place: rows q = target. rows: c x r, of full rank; target: c. c = 0: nothing.
struct Hold {
  Eigen::MatrixXd rows;
  Eigen::VectorXd target;
};

// The q (r) with grad V(q) = force + rows^T x, rows q = target, x being the forces that hold it:
// the shape that force (r) and hold have pushed the body to, from rest, little by little. Newton's
// method along that way; the increments are halved where it does not converge. Errors: kContent if
// the held rows are not independent, kSolver if the way cannot be followed to its end or the shape
// at its end is not stable.
Result<Eigen::VectorXd> standing_shape(const Potential& potential, const Eigen::VectorXd& force,
                                       const Hold& hold = {});

}  // namespace tremolo
