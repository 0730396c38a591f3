// PETSc's smoothed aggregation multigrid, GAMG, as a preconditioner for elasticity.
#pragma once

#include <vector>

#include "precompute/system/petsc.h"

namespace tremolo {

// Of `definite`, which must be positive definite and learns the six rigid motions. positions: of
// this rank's nodes, m.
void set_multigrid(PC preconditioner, Mat definite, const std::vector<Eigen::Vector3d>& positions);

}  // namespace tremolo
