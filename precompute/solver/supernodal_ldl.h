// The numeric factorisation A = L D L^T in given supernodes, without pivoting, for matrices that
// need not be definite: by Sylvester's law D has as many negative entries as A has negative
// eigenvalues. Independent subtrees of the elimination tree run side by side; the top, where a few
// large panels are left, is shared by BLAS's threads.
#pragma once

#include "precompute/dense/sparse_rows.h"
#include "precompute/solver/supernodes.h"

namespace tremolo {

struct LdlReport {
  std::size_t negative = 0;
  // Largest (|L| |D| |L^T|)_ii / |A_ii|: the factors are those of a matrix that differs from A by
  // this times rounding. 1 for a positive definite matrix; infinite when a pivot vanished.
  double growth = 0;
};

// order: row i of the factor is row order[i] of a. values: where the panels lie; overwritten by L
// (below a unit diagonal) and, on the diagonal, D. The result does not depend on `threads`.
LdlReport factorise_ldl(const Supernodes& pattern, const int* order, const SparseRows& a,
                        double* values, unsigned threads);

}  // namespace tremolo
