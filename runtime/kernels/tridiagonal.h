// Symmetric matrix -> tridiagonal by Householder reflections: A = W T W^T, W orthogonal. Functions
// of A then cost O(r) a vector: f(A) x = W f(T) W^T x.
#pragma once

#include <Eigen/Core>

#include "runtime/kernels/aligned.h"

namespace tremolo {

// diagonal: r. off: r - 1 entries, T_{i,i+1}. All is sized by the constructor; nothing is allocated
// later.
class Tridiagonal {
 public:
  explicit Tridiagonal(Eigen::Index size);

  // a: r x r, symmetric; its lower triangle is read. Columns whose entries beyond the first
  // subdiagonal are all below some 1e-140 count as tridiagonal already.
  void compute(const Eigen::MatrixXd& a);

  void to_basis(Eigen::VectorXd& x) const;    // x <- W^T x
  void from_basis(Eigen::VectorXd& x) const;  // x <- W x

  const Eigen::VectorXd& diagonal() const { return diagonal_; }
  const Eigen::VectorXd& off() const { return off_; }

 private:
  std::size_t r_;
  std::size_t stride_;
  Eigen::VectorXd diagonal_;
  Eigen::VectorXd off_;
  AlignedDoubles masks_;
  AlignedDoubles work_;         // A, then what is left of it
  AlignedDoubles reflections_;  // column k: u_k of I - f_k u_k u_k^T, below row k
  AlignedDoubles factors_;      // f_k = 2/|u_k|^2, or 0 where there is nothing to reflect
  AlignedDoubles basis_;        // W^T, column by column
  AlignedDoubles image_;
  mutable AlignedDoubles vector_;
};

}  // namespace tremolo
