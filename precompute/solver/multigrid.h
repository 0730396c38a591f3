// Smoothed aggregation multigrid (PETSc's GAMG) as a preconditioner for elasticity.
#pragma once

#include <vector>

#include "precompute/system/petsc.h"

namespace tremolo {

// Sets up multigrid for `definite`, a positive definite matrix, whose near null space becomes the
// six rigid motions. positions: of this rank's nodes, m.
void set_multigrid(PC preconditioner, Mat definite, const std::vector<Eigen::Vector3d>& positions);

}  // namespace tremolo
