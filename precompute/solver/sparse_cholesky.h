// A Cholesky factor of a symmetric positive definite matrix in one process (CHOLMOD's supernodal
// factor), usable by several threads at once.
#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include "precompute/dense/sparse_rows.h"
#include "precompute/solver/supernodal_ldl.h"

namespace tremolo {

class SparseCholesky {
 public:
  // Factorises the matrix. Its row order is kept apart from a postorder of the elimination tree, so
  // it should be a nested dissection. The number of BLAS threads is that of BlasThreads. Throws
  // Failure: kSolver if the matrix is not positive definite, kSystem if memory runs out.
  explicit SparseCholesky(const SparseRows& matrix);
  ~SparseCholesky();
  SparseCholesky(const SparseCholesky&) = delete;
  SparseCholesky& operator=(const SparseCholesky&) = delete;

  // Buffers for the solves of one thread; they can be reused.
  struct Workspace {
    std::vector<LaneBlock> rows, scratch;
  };

  // Computes x = A^-1 b, n x columns each; b and x may be the same. Threads may call it
  // concurrently with a workspace each. Sixteen columns take one forward and one backward pass over
  // the factor.
  void solve(const ColumnsRef& b, ColumnsOut x, Workspace& workspace) const;

  // Factorises another matrix of the same pattern, definite or not, in place and counts its
  // negative eigenvalues. The old factor is lost: solve() must not be called again.
  LdlReport count_negative(const SparseRows& matrix, unsigned threads);

  // Computes the factor of another matrix of the same pattern in place. Throws as the constructor
  // does; there is no factor then.
  void factorise(const SparseRows& matrix);

  // Computes x = A^-1 b for one vector of length n; one thread at a time.
  void solve(const Eigen::VectorXd& b, Eigen::VectorXd& x);

  double flops() const;  // of the factorisation
  // Returns the number of entries in the supernodes, 8 bytes each; a solve reads them twice.
  std::size_t entries() const;

 private:
  struct Factor;
  std::unique_ptr<Factor> factor_;
};

}  // namespace tremolo
