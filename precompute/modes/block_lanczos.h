// The eigenvectors of a large symmetric pencil nearest to a shift, many solves at a time.
//
// Lanczos with blocks for A = (K - shift M)^-1 M, which is self-adjoint in the inner product of M.
// One pass over the factor serves a whole block: it is the reading of the factor that a single
// solve spends its time on. The basis is kept orthonormal by full orthogonalisation and is not
// restarted; the lowest modes of a solid are there before it grows large.
#pragma once

#include <functional>

#include "precompute/solver/sparse_cholesky.h"

namespace tremolo {

inline constexpr int kLanczosBlock = 8;  // columns of a block: a vector of the triangular solves

// Columns are this rank's rows.
struct Pencil {
  std::function<Columns(const ColumnsRef&)> mass;  // M X
  std::function<void(ColumnsOut)> inverse;         // X <- (K - shift M)^-1 M X
  const Columns* deflated = nullptr;  // M-orthonormal columns to stay away from; may be empty
  Eigen::Index rows = 0;              // of this rank
  Eigen::Index all_rows = 0;
};

// In one process: columns side by side on `threads` threads, on a fixed division, so that the
// result does not depend on their number. Borrows the factor.
Pencil thread_pencil(Mat mass, const SparseCholesky& factor, const Columns& deflated,
                     unsigned threads);

// On the ranks of the matrices, with PETSc's factor.
Pencil petsc_pencil(Mat mass, Mat factor, const Columns& deflated);

// X <- A X, without the deflated part.
void apply_inverse(const Pencil& pencil, const ColumnsOut& x);

// vectors: this rank's rows x wanted, M-orthonormal; values: theta = 1 / (lambda - shift), largest
// first. converged: all residuals |A x - theta x| / theta are at most the tolerance. If not, the
// basis reached its largest size and the rest is not filled.
struct LanczosPairs {
  bool converged = false;
  int solves = 0;
  Eigen::VectorXd values;
  Columns vectors;
};
LanczosPairs block_lanczos(const Pencil& pencil, int wanted, double tolerance);

}  // namespace tremolo
