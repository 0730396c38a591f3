// Block Lanczos for the eigenvectors of a large symmetric pencil nearest to a shift.
//
// The operator A = (K - sigma M)^-1 M is self-adjoint in the inner product of M. Blocks are used
// since a single solve is limited by reading the factor, and one pass over it serves a whole block.
// The basis is kept orthonormal by full orthogonalisation and is not restarted; the lowest modes of
// a solid converge before it grows large.
#pragma once

#include "precompute/solver/shifted_solver.h"

namespace tremolo {

inline constexpr int kLanczosBlock =
    8;  // columns of a block: the SIMD width of the triangular solves

// Replaces X by (K - sigma M)^-1 M X without its rigid components; sigma is the one that the solver
// is prepared for. Columns are assigned to threads in a fixed way, so the result does not depend on
// the number of threads.
void apply_inverse(const Pencil& pencil, const ShiftedSolver& solver, ColumnsOut x);

// vectors: this rank's rows x wanted, M-orthonormal; values: theta = 1 / (lambda - shift),
// descending. converged: all residuals |A x - theta x| / theta are at most the tolerance; if false,
// vectors and values are not valid: either the basis has reached its largest size or it is
// exhausted, which means that rounding hides all further directions.
struct LanczosPairs {
  bool converged = false;
  bool exhausted = false;
  int solves = 0;
  Eigen::VectorXd values;
  Columns vectors;
};
LanczosPairs block_lanczos(const Pencil& pencil, const ShiftedSolver& solver, int wanted,
                           double tolerance);

}  // namespace tremolo
