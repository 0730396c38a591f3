// Numeric factorisation A = L D L^T in given supernodes, without pivoting, for matrices that may be
// indefinite: by Sylvester's law D has as many negative entries as A has negative eigenvalues.
// Independent subtrees of the elimination tree run in parallel; at the top, where few large panels
// are left, BLAS's threads share the work.
#pragma once

#include "precompute/dense/sparse_rows.h"
#include "precompute/solver/supernodes.h"

namespace tremolo {

struct LdlReport {
  std::size_t negative = 0;
  // Largest (|L| |D| |L^T|)_ii / |A_ii|: the computed factors are exact for a matrix that differs
  // from A by this times rounding. 1 for a positive definite matrix; infinite if a pivot is zero.
  double growth = 0;
};

// order: row i of the factor is row order[i] of a. values: memory of the panels, overwritten by L
// (unit diagonal, not stored) and, on the diagonal, D. The result does not depend on `threads`.
LdlReport factorise_ldl(const Supernodes& pattern, const int* order, const SparseRows& a,
                        double* values, unsigned threads);

}  // namespace tremolo
