#include "precompute/dense/blas.h"

extern "C" {
// BLAS, Fortran interface: C <- alpha op(A) op(B) + beta C.
// NOLINTNEXTLINE(readability-identifier-naming)
void dgemm_(const char* trans_a, const char* trans_b, const int* m, const int* n, const int* k,
            const double* alpha, const double* a, const int* lda, const double* b, const int* ldb,
            const double* beta, double* c, const int* ldc);
}

namespace tremolo {
namespace {

int blas_int(Eigen::Index value) {
  return static_cast<int>(value);
}

// BLAS requires a leading dimension of at least one, even for empty matrices.
int stride(Eigen::Index value) {
  return blas_int(std::max<Eigen::Index>(value, 1));
}

}  // namespace

Eigen::MatrixXd transposed_product(const ColumnsRef& a, const ColumnsRef& b) {
  Eigen::MatrixXd c = Eigen::MatrixXd::Zero(a.cols(), b.cols());
  if (c.size() == 0 || a.rows() == 0) return c;
  const int m = blas_int(a.cols()), n = blas_int(b.cols()), k = blas_int(a.rows());
  const int lda = stride(a.outerStride()), ldb = stride(b.outerStride());
  const double one = 1.0, zero = 0.0;
  dgemm_("T", "N", &m, &n, &k, &one, a.data(), &lda, b.data(), &ldb, &zero, c.data(), &m);
  return c;
}

void add_product(double alpha, const ColumnsRef& a, const ColumnsRef& b, double beta,
                 ColumnsOut c) {
  if (c.size() == 0) return;
  const int m = blas_int(c.rows()), n = blas_int(c.cols()), k = blas_int(a.cols());
  const int lda = stride(a.outerStride()), ldb = stride(b.outerStride());
  const int ldc = stride(c.outerStride());
  dgemm_("N", "N", &m, &n, &k, &alpha, a.data(), &lda, b.data(), &ldb, &beta, c.data(), &ldc);
}

}  // namespace tremolo
