// A sparse matrix of one process as compressed rows: what threads may read side by side.
#pragma once

#include "precompute/dense/blas.h"
#include "precompute/system/petsc.h"

namespace tremolo {

// Borrowed from a sequential AIJ matrix; valid while that one is not changed.
// Entries of row i are start[i] .. start[i+1], columns ascending.
struct SparseRows {
  int rows = 0;
  const int* start = nullptr;
  const int* column = nullptr;
  const double* value = nullptr;
};
SparseRows sparse_rows(Mat matrix);

// Y = A X in the calling thread, without a PETSc call.
void multiply(const SparseRows& a, const ColumnsRef& x, ColumnsOut y);

// A X over this rank's rows. In one process threads may call it side by side; on several ranks all
// call it together.
class SparseProduct {
 public:
  explicit SparseProduct(Mat matrix);
  Columns operator()(const Columns& x) const;

 private:
  Mat matrix_;
  SparseRows rows_;  // in one process
};

}  // namespace tremolo
