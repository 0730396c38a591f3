// A sparse matrix of one process as compressed rows, which threads can read concurrently.
#pragma once

#include "precompute/dense/blas.h"
#include "precompute/system/petsc.h"

namespace tremolo {

// Non-owning view of a sequential AIJ matrix, valid until that matrix is changed. The entries of
// row i are start[i] .. start[i+1], columns ascending.
struct SparseRows {
  int rows = 0;
  const int* start = nullptr;
  const int* column = nullptr;
  const double* value = nullptr;
};
SparseRows sparse_rows(Mat matrix);

// Computes Y = A X in the calling thread, without PETSc calls.
void multiply(const SparseRows& a, const ColumnsRef& x, ColumnsOut y);

// Computes A X on this rank's rows. With one process, threads may call it concurrently; with
// several ranks it is collective.
class SparseProduct {
 public:
  explicit SparseProduct(Mat matrix);
  Columns operator()(const Columns& x) const;

 private:
  Mat matrix_;
  SparseRows rows_;  // with one process; else empty
};

}  // namespace tremolo
