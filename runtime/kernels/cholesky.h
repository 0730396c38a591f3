// Cholesky's factor of a small symmetric positive definite matrix, in vectors. Eigen's code is
// compiled for the plain machine, because the library must run everywhere.
#pragma once

#include <Eigen/Core>

#include "common/state_stream.h"
#include "runtime/kernels/aligned.h"

namespace tremolo {

// A = L D L^T, L with a unit diagonal: the same without roots. A diagonal A, as in every step of a
// linear model, is its own D: it is detected, and costs no products. The constructor allocates all
// memory.
class SmallCholesky {
 public:
  explicit SmallCholesky(Eigen::Index size);

  // a: size x size, its lower triangle is read. False, and no solve until the next, if A is not
  // positive definite or not finite.
  bool compute(const Eigen::MatrixXd& a);

  // x <- A^-1 x.
  void solve(Eigen::VectorXd& x) const;

  // Saves or restores the results of compute().
  void carry(StateStream& stream) { stream(diagonal_, columns_, rows_, inverse_); }

 private:
  std::size_t n_;
  std::size_t stride_;
  bool diagonal_ = false;
  AlignedDoubles columns_;  // L column by column, padded, zeros above the diagonal
  AlignedDoubles rows_;     // L D row by row, without the diagonal
  AlignedDoubles inverse_;  // of D
  mutable AlignedDoubles scratch_;
};

}  // namespace tremolo
