// A x = b by conjugate gradients, preconditioned by the inverses of the diagonal's blocks
// (Hestenes and Stiefel 1952).
#pragma once

#include <vector>

#include <Eigen/Core>

#include "runtime/sparse/block_matrix.h"

namespace tremolo {

// residual: |b - A x| at the end, in b's unit. converged: it is at most what was asked for.
// positive: no direction with d.A d <= 0 was met, nor a diagonal block without an inverse; where one
// was, x is what had been found before it.
struct CgReport {
  int iterations = 0;
  double residual = 0.0;
  bool converged = false;
  bool positive = true;
};

class ConjugateGradients {
 public:
  // Sized for matrices of this pattern; nothing is allocated later.
  explicit ConjugateGradients(const BlockPattern& pattern);

  // From x as it comes in. residual: where to stop, absolute, in b's unit, Euclidean norm.
  CgReport solve(const BlockMatrix& a, const Eigen::VectorXd& b, Eigen::VectorXd& x,
                 double residual, int max_iterations);

 private:
  bool invert_diagonal(const BlockMatrix& a);
  void precondition();

  std::vector<Eigen::Matrix3d> inverse_;
  Eigen::VectorXd r_, z_, p_, q_;  // b - A x, r preconditioned, the direction, A p
};

}  // namespace tremolo
