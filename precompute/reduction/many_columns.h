// The stage "basis" of many columns (a hundred modes have 5 050 derivatives), by LAPACK: minutes in
// which something is heard.
#pragma once

#include <functional>
#include <string>

#include "precompute/dense/blas.h"
#include "precompute/fem/matrices.h"

namespace tremolo {

// Hears a line about what is under way; may be empty.
using Tell = std::function<void(const std::string&)>;

// A X for some columns.
Columns product(Mat matrix, const ColumnsRef& x, unsigned threads);

// X^T A X by blocks of columns, the upper triangle mirrored.
Eigen::MatrixXd gram(Mat matrix, const ColumnsRef& x, unsigned threads, const Tell& tell = {});

// W = Q T: Q = columns * q, M-orthonormal, once the first `rank` columns have been changed in
// place; T = t, rank x n.
struct Factored {
  Eigen::Index rank;
  Eigen::MatrixXd q;
  Eigen::MatrixXd t;
};

// W = columns * weight. Of the columns, scaled to unit M-norm, a pivoted Cholesky factorisation of
// their Gram matrix chooses those that hold all others to 1e-6: below is what such a matrix has
// lost to rounding. A second one makes Q orthonormal to rounding. Its work is rank^2 n, so few
// rows cost little however many columns there are.
Factored orthonormalise_many(Mat mass, Columns& columns, const Eigen::VectorXd& weight,
                             unsigned threads, const Tell& tell);

// What all that and the singular values will take: seconds, by timing one product of matrices, to a
// factor of two or so, and bytes beside the columns themselves.
struct ManyColumnsCost {
  double seconds = 0;
  double bytes = 0;
};
ManyColumnsCost cost_of_many_columns(Eigen::Index rows, Eigen::Index columns, unsigned threads);

}  // namespace tremolo
