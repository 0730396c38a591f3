// Stage "matrices": M and K of the free dofs as distributed PETSc matrices.
#pragma once

#include "precompute/fem/assembly.h"
#include "precompute/system/petsc.h"

namespace tremolo {

// Both 3N x 3N, symmetric positive (semi-)definite, in the order of the DofMap.
// mass: kg, one entry a node pair and axis. stiffness: N/m, 3x3 blocks.
struct Matrices {
  PetscMatrix mass;
  PetscMatrix stiffness;
};

// solid: of this rank's part of the mesh.
Matrices assemble(const Solid& solid, const DofMap& map, const LocalDofs& local, MassKind kind);

// K - shift M, a matrix of its own.
PetscMatrix shifted_stiffness(const Matrices& matrices, double shift);

}  // namespace tremolo
