// Stage "derivatives": the modal derivatives K Phi_ij = -H[Psi_i, Psi_j] (thesis (4.1.11); Barbic &
// James 2005), computed with the factor that shift-invert left.
#pragma once

#include "formats/basis/basis_data.h"
#include "precompute/fem/stvk.h"
#include "precompute/solver/shifted_solver.h"

namespace tremolo {

// columns: local dofs x (k + k(k+1)/2 + thirds), the modes followed by the derivatives, column k +
// pair_index(i, j), and by those of third order (third_derivatives.h); together the input of the
// basis. residual: largest |K X + H| / |H| of the derivatives (H self-balancing for a free body);
// it also reveals a factor that is not that of K, as PETSc options may cause.
struct ModalDerivatives {
  Columns columns;
  Eigen::Index modes = 0;
  double residual = 0;
  auto vectors() const { return columns.rightCols(columns.cols() - modes); }
};

// Computes the modal derivatives. modes: local dofs x k, M-orthonormal; psi: the same at all
// vertices, 3n x k. solver: prepared. Throws Failure as solve_at_rest.
ModalDerivatives modal_derivatives(const Solid& solid, const LocalDofs& local, const Pencil& pencil,
                                   const ShiftedSolver& solver, const Columns& modes,
                                   const BasisRows& psi);

}  // namespace tremolo
