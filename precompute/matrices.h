// Stage "matrices": M and K of the free dofs as distributed PETSc matrices.
#pragma once

#include "precompute/assembly.h"
#include "precompute/petsc.h"

namespace tremolo {

// Both 3N x 3N, symmetric positive (semi-)definite, in the order of the DofMap.
// mass: kg, one entry a node pair and axis. stiffness: N/m, 3x3 blocks.
struct Matrices {
  PetscMatrix mass;
  PetscMatrix stiffness;
};

Matrices assemble(const Solid& solid, const DofMap& map, const LocalDofs& local, MassKind kind);

// Values of this rank's rows -> values of all vertices on every rank: 3n x columns, zero where a
// vertex is fixed.
Eigen::MatrixXd expand_to_vertices(const DofMap& map, const LocalDofs& local,
                                   const Columns& columns);

}  // namespace tremolo
