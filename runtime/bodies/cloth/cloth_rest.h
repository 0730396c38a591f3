// The equilibrium of a cloth under its pins, gravity and constant forces on its particles.
#pragma once

#include <Eigen/Core>

#include "common/result.h"
#include "runtime/bodies/cloth/cloth_model.h"

namespace tremolo {

// Positions, 3n, m, at which springs, gravity and `forces` (3n, N) balance; fixed particles stay
// where they are at `start`, 3n, where the search begins. The model has no wind. Errors: kContent
// without fixed particles; kSolver if no equilibrium is found, or if the one that is found is not
// stable or moves without resistance, so that it is not the only one.
Result<Eigen::VectorXd> cloth_at_rest(const ClothModel& model, const Eigen::VectorXd& forces,
                                      const Eigen::VectorXd& start);

}  // namespace tremolo
