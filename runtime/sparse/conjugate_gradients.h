// A x = b by conjugate gradients, preconditioned by the inverses of the diagonal's blocks
// (Hestenes and Stiefel 1952), in single precision inside a refinement in double precision:
//
//     r = b - A x,   A d ~ r by conjugate gradients in floats,   x <- x + d,   and again.
//
// What takes the time is A, read from memory in every iteration: in floats it is half as long, and
// in runs (cg_storage.h) it need not be read for both of its triangles.
#pragma once

#include <cstddef>
#include <memory>

#include <Eigen/Core>

#include "runtime/sparse/block_matrix.h"
#include "runtime/sparse/cg_storage.h"

namespace tremolo {

// residual: |b - A x| at the end, in b's unit. converged: it is at most what was asked for.
// positive: no direction with d.A d <= 0 was met, nor a diagonal block without an inverse; where
// one was, x is what had been found before it.
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
  bool take(const BlockMatrix& a);
  double search(double tolerance, int most, CgReport& report);
  bool is_positive(const BlockMatrix& a);

  std::size_t n_ = 0;
  double scale_ = 1.0;  // of the matrix in floats
  std::unique_ptr<CgStorage> storage_;
  Eigen::VectorXd rest_, image_;  // b - A x; a product with A
};

}  // namespace tremolo
