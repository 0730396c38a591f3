// Cholesky's factor of a small symmetric positive definite matrix, in vectors: Eigen's is compiled
// for the plain machine, since a library that runs everywhere must be.
#pragma once

#include <Eigen/Core>

#include "runtime/aligned.h"

namespace tremolo {

// A = L L^T. All is sized by the constructor; nothing is allocated later.
class SmallCholesky {
 public:
  explicit SmallCholesky(Eigen::Index size);

  // a: size x size, its lower triangle is read. False, and no solve until the next, if A is not
  // positive definite or not finite.
  bool compute(const Eigen::MatrixXd& a);

  // x <- A^-1 x.
  void solve(Eigen::VectorXd& x) const;

 private:
  std::size_t n_;
  std::size_t stride_;
  AlignedDoubles lower_;    // L column by column, padded, zeros above the diagonal
  AlignedDoubles upper_;    // L^T column by column, likewise
  AlignedDoubles inverse_;  // of L's diagonal
  mutable AlignedDoubles scratch_;
};

}  // namespace tremolo
