// A x = b by conjugate gradients, preconditioned by the inverses of the diagonal's blocks
// (Hestenes and Stiefel 1952), in single precision inside a refinement in double precision:
//
//     r = b - A x,   A d ~ r by conjugate gradients in floats,   x <- x + d,   and again.
//
// Most of the time is spent reading A from memory in every iteration: in floats it is half as long,
// and in runs (cg_storage.h) only one of its triangles is read.
#pragma once

#include <cstddef>
#include <memory>

#include <Eigen/Core>

#include "runtime/sparse/block_matrix.h"
#include "runtime/sparse/cg_storage.h"

namespace tremolo {

// Result of a solve.
struct CgReport {
  int iterations = 0;
  double residual = 0.0;   // |b - A x| at the end, in b's unit
  bool converged = false;  // the residual is at most the requested one
  // No direction with d.A d <= 0 was met, and every diagonal block has an inverse; otherwise x is
  // the solution before that.
  bool positive = true;
};

class ConjugateGradients {
 public:
  // Sized for matrices of this pattern; nothing is allocated later.
  explicit ConjugateGradients(const BlockPattern& pattern);

  // Starts from the given x. residual: absolute, in b's unit, Euclidean norm, at which the solve
  // stops.
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
