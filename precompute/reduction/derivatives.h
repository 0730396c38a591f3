// Stage "derivatives": the modal derivatives K Phi_ij = -H[Psi_i, Psi_j] (thesis (4.1.11); Barbic &
// James 2005), all on the factorisation that shift-invert made.
#pragma once

#include "formats/basis/basis_data.h"
#include "precompute/fem/stvk.h"
#include "precompute/modes/modes.h"

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

// psi: the modes expanded to all vertices, 3n x k. Blocks of columns are loaded, solved and checked
// one after the other, on CHOLMOD's factor `threads` blocks at a time: only those blocks exist
// twice.
// A body with rigid modes has a singular K: the load is made self-balancing, the factor of
// K + sM is used in an iteration that converges to the solution on the complement of `rigid`
// (M-orthonormal), and nothing of `rigid` is left in Phi.
ModalDerivatives modal_derivatives(const Solid& solid, const LocalDofs& local,
                                   const Matrices& matrices, const Modes& modes,
                                   const BasisRows& psi, const Columns& rigid, unsigned threads);

}  // namespace tremolo
