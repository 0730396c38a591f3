// Stage "derivatives": the modal derivatives K Phi_ij = -H[Psi_i, Psi_j] (thesis (4.1.11); Barbic &
// James 2005), all on the factorisation that shift-invert made.
#pragma once

#include "formats/basis/basis_data.h"
#include "precompute/fem/stvk.h"
#include "precompute/solver/shifted_solver.h"

namespace tremolo {

// columns: local dofs x (k + k(k+1)/2), the modes and after them the derivatives, column
// k + pair_index(i, j): together what the basis is made of. residual: largest |K Phi + H| / |H| of
// the derivatives (made self-balancing for a free body): it also tells a factor that is not K's, as
// PETSc options can bring about.
struct ModalDerivatives {
  Columns columns;
  Eigen::Index modes = 0;
  double residual = 0;
  auto vectors() const { return columns.rightCols(columns.cols() - modes); }
};

// modes: local dofs x k, M-orthonormal; psi: the same at all vertices, 3n x k. solver: prepared.
// Blocks of columns are loaded, solved and checked one after the other, on CHOLMOD's factor as many
// at a time as there are threads: only those blocks exist twice.
// A body with rigid motions has a singular K: the load is made self-balancing, the factor of
// K + sM is used in an iteration that converges to the solution on the complement of the motions,
// and nothing of them is left in Phi. Throws Failure (kSolver) when that does not converge.
ModalDerivatives modal_derivatives(const Solid& solid, const LocalDofs& local, const Pencil& pencil,
                                   const ShiftedSolver& solver, const Columns& modes,
                                   const BasisRows& psi);

}  // namespace tremolo
