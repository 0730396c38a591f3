// Stage "matrices": M and K on the free dofs as distributed PETSc matrices.
#pragma once

#include "precompute/fem/assembly.h"
#include "precompute/system/petsc.h"

namespace tremolo {

// M and K, both 3N x 3N, symmetric positive (semi-)definite, in the order of the DofMap. mass: kg,
// one entry a node pair and axis. stiffness: N/m, 3x3 blocks.
struct Matrices {
  PetscMatrix mass;
  PetscMatrix stiffness;
};

// solid: this rank's part of the mesh. Throws Failure (kSystem) if a rank has more than 2^31
// entries.
Matrices assemble(const Solid& solid, const DofMap& map, const LocalDofs& local, MassKind kind);

// Returns K - shift M as a new matrix. shift: (rad/s)^2.
PetscMatrix shifted_stiffness(const Matrices& matrices, double shift);

}  // namespace tremolo
