#include "precompute/dense/large_decompositions.h"

#include <algorithm>
#include <string>

#include "precompute/system/failure.h"

// LAPACK and BLAS, Fortran interface.
// NOLINTBEGIN(readability-identifier-naming)
extern "C" {
void dsyevd_(const char* job, const char* half, const int* n, double* a, const int* lda, double* w,
             double* work, const int* lwork, int* iwork, const int* liwork, int* info);
void dgesdd_(const char* job, const int* m, const int* n, double* a, const int* lda, double* s,
             double* u, const int* ldu, double* vt, const int* ldvt, double* work, const int* lwork,
             int* iwork, int* info);
void dgeqrf_(const int* m, const int* n, double* a, const int* lda, double* tau, double* work,
             const int* lwork, int* info);
void dpstrf_(const char* half, const int* n, double* a, const int* lda, int* pivots, int* rank,
             const double* tolerance, double* work, int* info);
void dpotrf_(const char* half, const int* n, double* a, const int* lda, int* info);
void dtrsm_(const char* side, const char* half, const char* trans, const char* unit, const int* m,
            const int* n, const double* alpha, const double* a, const int* lda, double* b,
            const int* ldb);
void dtrmm_(const char* side, const char* half, const char* trans, const char* unit, const int* m,
            const int* n, const double* alpha, const double* a, const int* lda, double* b,
            const int* ldb);
}
// NOLINTEND(readability-identifier-naming)

namespace tremolo {
namespace {

int lapack_int(Eigen::Index value) {
  return static_cast<int>(value);
}

[[noreturn]] void fail(const char* routine, int info) {
  throw Failure({ErrorKind::kSolver,
                 std::string("LAPACK's ") + routine + " gave up (" + std::to_string(info) + ")"});
}

std::vector<double> workspace(double size) {
  return std::vector<double>(static_cast<std::size_t>(size));
}

// Returns R of a = Q R with zeros below the diagonal. a: m x n, m >= n; overwritten.
Eigen::MatrixXd upper_of_qr(Eigen::MatrixXd& a) {
  const int m = lapack_int(a.rows()), n = lapack_int(a.cols());
  std::vector<double> tau(n);
  double size = 0;
  int query = -1, info = 0;
  dgeqrf_(&m, &n, a.data(), &m, tau.data(), &size, &query, &info);
  std::vector<double> work = workspace(size);
  const int length = static_cast<int>(work.size());
  dgeqrf_(&m, &n, a.data(), &m, tau.data(), work.data(), &length, &info);
  if (info != 0) fail("dgeqrf", info);
  return a.topRows(n).triangularView<Eigen::Upper>();
}

}  // namespace

EigenPairs large_eigenpairs(const Eigen::MatrixXd& a) {
  const int n = lapack_int(a.rows());
  EigenPairs pairs{Eigen::VectorXd(a.rows()), a, false};
  double size = 0;
  int whole = 0, query = -1, info = 0;
  dsyevd_("V", "L", &n, pairs.vectors.data(), &n, pairs.values.data(), &size, &query, &whole,
          &query, &info);
  std::vector<double> work = workspace(size);
  std::vector<int> numbers(whole);
  const int length = static_cast<int>(work.size());
  dsyevd_("V", "L", &n, pairs.vectors.data(), &n, pairs.values.data(), work.data(), &length,
          numbers.data(), &whole, &info);
  pairs.found = info == 0;
  return pairs;
}

SingularPairs left_singular_pairs(const Eigen::MatrixXd& a) {
  if (a.size() == 0) return {Eigen::VectorXd(0), Eigen::MatrixXd(a.rows(), 0)};
  Eigen::MatrixXd square;
  if (a.cols() > a.rows()) {
    // A^T = Q R: the singular values and left vectors of A are those of R^T.
    Eigen::MatrixXd transposed = a.transpose();
    square = upper_of_qr(transposed).transpose();
  } else {
    square = a;
  }
  const int m = lapack_int(square.rows()), n = lapack_int(square.cols());
  SingularPairs pairs{Eigen::VectorXd(n), Eigen::MatrixXd(m, n)};
  Eigen::MatrixXd right(n, n);
  std::vector<int> numbers(8 * static_cast<std::size_t>(n));
  double size = 0;
  int query = -1, info = 0;
  dgesdd_("S", &m, &n, square.data(), &m, pairs.values.data(), pairs.vectors.data(), &m,
          right.data(), &n, &size, &query, numbers.data(), &info);
  std::vector<double> work = workspace(size);
  const int length = static_cast<int>(work.size());
  dgesdd_("S", &m, &n, square.data(), &m, pairs.values.data(), pairs.vectors.data(), &m,
          right.data(), &n, work.data(), &length, numbers.data(), &info);
  if (info != 0) fail("dgesdd", info);
  return pairs;
}

PivotedCholesky pivoted_cholesky(Eigen::MatrixXd a, double tolerance) {
  const int n = lapack_int(a.rows());
  std::vector<int> pivots(n);
  std::vector<double> work(2 * static_cast<std::size_t>(n));
  int rank = 0, info = 0;
  dpstrf_("U", &n, a.data(), &n, pivots.data(), &rank, &tolerance, work.data(), &info);
  if (info < 0) fail("dpstrf", info);
  PivotedCholesky result;
  for (const int pivot : pivots) result.order.push_back(pivot - 1);
  result.factor = a.topRows(rank).triangularView<Eigen::Upper>();
  return result;
}

Eigen::MatrixXd cholesky_factor(Eigen::MatrixXd a) {
  const int n = lapack_int(a.rows());
  int info = 0;
  dpotrf_("U", &n, a.data(), &n, &info);
  if (info != 0) fail("dpotrf", info);
  a.triangularView<Eigen::StrictlyLower>().setZero();
  return a;
}

void divide_by_upper(const ColumnsRef& r, ColumnsOut b) {
  if (b.size() == 0) return;
  const int m = lapack_int(b.rows()), n = lapack_int(b.cols());
  const int ldr = lapack_int(r.outerStride()), ldb = lapack_int(b.outerStride());
  const double one = 1.0;
  dtrsm_("R", "U", "N", "N", &m, &n, &one, r.data(), &ldr, b.data(), &ldb);
}

void multiply_by_upper(const ColumnsRef& r, ColumnsOut b) {
  if (b.size() == 0) return;
  const int m = lapack_int(b.rows()), n = lapack_int(b.cols());
  const int ldr = lapack_int(r.outerStride()), ldb = lapack_int(b.outerStride());
  const double one = 1.0;
  dtrmm_("L", "U", "N", "N", &m, &n, &one, r.data(), &ldr, b.data(), &ldb);
}

}  // namespace tremolo
