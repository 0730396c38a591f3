#include "precompute/dense/sparse_rows.h"

namespace tremolo {
namespace {

// Multiplies `Width` columns in one pass over the matrix.
template <int Width>
void multiply_columns(const SparseRows& a, const double* x, Eigen::Index x_stride, double* y,
                      Eigen::Index y_stride) {
  for (int row = 0; row < a.rows; ++row) {
    double sum[Width] = {};
    for (int at = a.start[row]; at < a.start[row + 1]; ++at) {
      const double value = a.value[at];
      const double* entry = x + a.column[at];
      for (int c = 0; c < Width; ++c) sum[c] += value * entry[c * x_stride];
    }
    for (int c = 0; c < Width; ++c) y[row + c * y_stride] = sum[c];
  }
}

}  // namespace

SparseRows sparse_rows(Mat matrix) {
  constexpr const char* kDoing = "read a sparse matrix";
  SparseRows view;
  PetscBool done = PETSC_FALSE;
  const PetscInt *start = nullptr, *column = nullptr;
  check_petsc(MatGetRowIJ(matrix, 0, PETSC_FALSE, PETSC_FALSE, &view.rows, &start, &column, &done),
              kDoing);
  check_petsc(MatSeqAIJGetArrayRead(matrix, &view.value), kDoing);
  view.start = start;
  view.column = column;
  // The arrays remain valid; restoring only ends PETSc's read access.
  const double* value = view.value;
  PetscInt rows = view.rows;
  check_petsc(MatSeqAIJRestoreArrayRead(matrix, &value), kDoing);
  check_petsc(MatRestoreRowIJ(matrix, 0, PETSC_FALSE, PETSC_FALSE, &rows, &start, &column, &done),
              kDoing);
  return view;
}

void multiply(const SparseRows& a, const ColumnsRef& x, ColumnsOut y) {
  Eigen::Index c = 0;
  const Eigen::Index x_stride = x.outerStride(), y_stride = y.outerStride();
  for (; c + 4 <= x.cols(); c += 4)
    multiply_columns<4>(a, x.data() + c * x_stride, x_stride, y.data() + c * y_stride, y_stride);
  for (; c < x.cols(); ++c)
    multiply_columns<1>(a, x.data() + c * x_stride, x_stride, y.data() + c * y_stride, y_stride);
}

SparseProduct::SparseProduct(Mat matrix) : matrix_(matrix) {
  if (mpi_ranks() == 1) rows_ = sparse_rows(matrix);
}

Columns SparseProduct::operator()(const Columns& x) const {
  if (rows_.start == nullptr) return multiply(matrix_, x);
  Columns product(x.rows(), x.cols());
  multiply(rows_, x, product);
  return product;
}

}  // namespace tremolo
