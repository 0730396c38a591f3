// Stage "basis" for many columns (a hundred modes have 5 050 derivatives), by LAPACK. It takes
// minutes and reports progress.
#pragma once

#include <functional>
#include <string>

#include "precompute/dense/blas.h"
#include "precompute/fem/matrices.h"

namespace tremolo {

// Receives a progress message; may be empty.
using Progress = std::function<void(const std::string&)>;

// Returns A X.
Columns product(Mat matrix, const ColumnsRef& x, unsigned threads);

// Returns X^T A X, computed by blocks of columns; the upper triangle is mirrored.
Eigen::MatrixXd gram(Mat matrix, const ColumnsRef& x, unsigned threads,
                     const Progress& progress = {});

// W = Q T with Q = columns * q, M-orthonormal, after the first `rank` columns were changed in
// place; T = t, rank x n.
struct Factored {
  Eigen::Index rank;
  Eigen::MatrixXd q;
  Eigen::MatrixXd t;
};

// Factorises W = columns * weight. A pivoted Cholesky factorisation of the Gram matrix of the
// columns, scaled to unit M-norm, selects those that represent all others to 1e-6, the resolution
// of a Gram matrix. A second Cholesky factorisation makes Q orthonormal to rounding. The work is
// rank^2 n, so a low rank costs little for any number of columns.
Factored orthonormalise_many(Mat mass, Columns& columns, const Eigen::VectorXd& weight,
                             unsigned threads, const Progress& progress);

// Estimated cost of the above with the singular values: seconds, from timing one matrix product, to
// a factor of about two; and bytes in addition to the columns.
struct ManyColumnsCost {
  double seconds = 0;
  double bytes = 0;
};
ManyColumnsCost cost_of_many_columns(Eigen::Index rows, Eigen::Index columns, unsigned threads);

}  // namespace tremolo
