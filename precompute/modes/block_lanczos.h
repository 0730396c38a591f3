// The eigenvectors of a large symmetric pencil nearest to a shift, many solves at a time.
//
// Lanczos with blocks for A = (K - sigma M)^-1 M, which is self-adjoint in the inner product of M.
// One pass over the factor serves a whole block: it is the reading of the factor that a single
// solve spends its time on. The basis is kept orthonormal by full orthogonalisation and is not
// restarted; the lowest modes of a solid are there before it grows large.
#pragma once

#include "precompute/solver/shifted_solver.h"

namespace tremolo {

inline constexpr int kLanczosBlock = 8;  // columns of a block: a vector of the triangular solves

// X <- (K - sigma M)^-1 M X without the rigid part, in place; sigma is the one that the solver is
// prepared for. Columns are divided among threads in a fixed way, so that the result does not
// depend on their number.
void apply_inverse(const Pencil& pencil, const ShiftedSolver& solver, ColumnsOut x);

// vectors: this rank's rows x wanted, M-orthonormal; values: theta = 1 / (lambda - shift), largest
// first. converged: all residuals |A x - theta x| / theta are at most the tolerance. If not, the
// basis reached its largest size and the rest is not filled.
struct LanczosPairs {
  bool converged = false;
  int solves = 0;
  Eigen::VectorXd values;
  Columns vectors;
};
LanczosPairs block_lanczos(const Pencil& pencil, const ShiftedSolver& solver, int wanted,
                           double tolerance);

}  // namespace tremolo
