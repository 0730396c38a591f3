// The Cholesky factor of a symmetric positive definite matrix in the memory of one process
// (CHOLMOD's supernodal one), used by several threads at once.
#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include "precompute/dense/sparse_rows.h"
#include "precompute/solver/supernodal_ldl.h"

namespace tremolo {

class SparseCholesky {
 public:
  // Factorises; the order of the rows is kept but for a postorder of the elimination tree, so they
  // should come in nested dissection. BLAS uses as many threads as BlasThreads says. Throws
  // Failure: kSolver when the matrix is not positive definite, kSystem when memory runs out.
  explicit SparseCholesky(const SparseRows& matrix);
  ~SparseCholesky();
  SparseCholesky(const SparseCholesky&) = delete;
  SparseCholesky& operator=(const SparseCholesky&) = delete;

  // What one thread needs for its solves; it may serve many.
  struct Workspace {
    std::vector<LaneBlock> rows, scratch;
  };

  // x <- A^-1 b, n x columns each; b and x may be the same. Threads with a workspace each may call
  // it side by side. Sixteen columns take one pass over the factor forwards and one backwards.
  void solve(const ColumnsRef& b, ColumnsOut x, Workspace& workspace) const;

  // Factorises another matrix of the same pattern, definite or not, into the same memory and counts
  // its negative eigenvalues. The factor that was there is lost: solve() may not be called again.
  LdlReport count_negative(const SparseRows& matrix, unsigned threads);

  // The factor of another matrix of the same pattern, in the same memory. Throws as the constructor
  // does; there is no factor then.
  void factorise(const SparseRows& matrix);

  // x <- A^-1 b for one vector, n; one thread at a time.
  void solve(const Eigen::VectorXd& b, Eigen::VectorXd& x);

  double flops() const;  // of the factorisation
  std::size_t entries()
      const;  // of the factor's supernodes, 8 bytes each: a solve reads them twice

 private:
  struct Factor;
  std::unique_ptr<Factor> factor_;
};

}  // namespace tremolo
