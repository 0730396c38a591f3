#include "precompute/sparse_cholesky.h"

#include <suitesparse/cholmod.h>

#include "precompute/failure.h"

namespace tremolo {
namespace {

[[noreturn]] void fail(const cholmod_common& common) {
  if (common.status == CHOLMOD_OUT_OF_MEMORY || common.status == CHOLMOD_TOO_LARGE)
    throw Failure(system_error("out of memory for the factor of the stiffness"));
  if (common.status == CHOLMOD_NOT_POSDEF)
    throw Failure({ErrorKind::kSolver,
                   "the stiffness is not positive definite: CHOLMOD met a pivot that is not"});
  throw Failure(
      {ErrorKind::kSolver, "CHOLMOD failed with status " + std::to_string(common.status)});
}

cholmod_dense as_cholmod(const double* values, Eigen::Index rows, Eigen::Index columns,
                         Eigen::Index stride) {
  cholmod_dense dense = {};
  dense.nrow = static_cast<std::size_t>(rows);
  dense.ncol = static_cast<std::size_t>(columns);
  dense.d = static_cast<std::size_t>(stride);
  dense.nzmax = dense.d * dense.ncol;
  dense.x = const_cast<double*>(values);
  dense.xtype = CHOLMOD_REAL;
  dense.dtype = CHOLMOD_DOUBLE;
  return dense;
}

}  // namespace

struct SparseCholesky::Factor {
  cholmod_common common = {};
  cholmod_factor* l = nullptr;
  Factor() {
    cholmod_start(&common);
    common.print = 0;
    common.nmethods = 1;
    common.method[0].ordering = CHOLMOD_NATURAL;
    common.postorder = 1;
    common.supernodal = CHOLMOD_SUPERNODAL;  // a simplicial one is no better for small matrices
    common.quick_return_if_not_posdef = 1;
  }
  ~Factor() {
    cholmod_free_factor(&l, &common);
    cholmod_finish(&common);
  }
};

SparseCholesky::SparseCholesky(const SparseRows& matrix) : factor_(std::make_unique<Factor>()) {
  const auto rows = static_cast<std::size_t>(matrix.rows);
  cholmod_sparse a = {};
  a.nrow = a.ncol = rows;
  a.nzmax = static_cast<std::size_t>(matrix.start[rows]);
  a.p = const_cast<int*>(matrix.start);
  a.i = const_cast<int*>(matrix.column);
  a.x = const_cast<double*>(matrix.value);
  a.stype = 1;  // both triangles are there; the upper one is read
  a.itype = CHOLMOD_INT;
  a.xtype = CHOLMOD_REAL;
  a.dtype = CHOLMOD_DOUBLE;
  a.sorted = 1;
  a.packed = 1;
  Factor& factor = *factor_;
  factor.l = cholmod_analyze(&a, &factor.common);
  if (factor.l == nullptr) fail(factor.common);
  cholmod_factorize(&a, factor.l, &factor.common);
  if (factor.common.status != CHOLMOD_OK) fail(factor.common);
}

SparseCholesky::~SparseCholesky() = default;

double SparseCholesky::flops() const {
  return factor_->common.fl;
}

std::size_t SparseCholesky::entries() const {
  return factor_->l->xsize;
}

struct SparseCholesky::Workspace::Parts {
  cholmod_common common = {};
  cholmod_dense* x = nullptr;
  cholmod_dense* y = nullptr;
  cholmod_dense* e = nullptr;
  Parts() {
    cholmod_start(&common);
    common.print = 0;
  }
  ~Parts() {
    cholmod_free_dense(&x, &common);
    cholmod_free_dense(&y, &common);
    cholmod_free_dense(&e, &common);
    cholmod_finish(&common);
  }
};

SparseCholesky::Workspace::Workspace() : parts_(std::make_unique<Parts>()) {}
SparseCholesky::Workspace::~Workspace() = default;

void SparseCholesky::solve(const ColumnsRef& b, ColumnsOut x, Workspace& workspace) const {
  Workspace::Parts& parts = *workspace.parts_;
  cholmod_dense right = as_cholmod(b.data(), b.rows(), b.cols(), b.outerStride());
  if (!cholmod_solve2(CHOLMOD_A, factor_->l, &right, nullptr, &parts.x, nullptr, &parts.y, &parts.e,
                      &parts.common))
    fail(parts.common);
  x = Eigen::Map<const Eigen::MatrixXd>(static_cast<const double*>(parts.x->x), b.rows(), b.cols());
}

}  // namespace tremolo
