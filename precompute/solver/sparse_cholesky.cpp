#include "precompute/solver/sparse_cholesky.h"

#include <suitesparse/cholmod.h>

#include "precompute/system/failure.h"

namespace tremolo {
namespace {

[[noreturn]] void fail(const cholmod_common& common) {
  if (common.status == CHOLMOD_TOO_LARGE)
    throw Failure(
        system_error("the factor of the stiffness has more entries than CHOLMOD can "
                     "count, 2^31: ask for --solver mumps"));
  if (common.status == CHOLMOD_OUT_OF_MEMORY)
    throw Failure(system_error("out of memory for the factor of the stiffness"));
  if (common.status == CHOLMOD_NOT_POSDEF)
    throw Failure({ErrorKind::kSolver,
                   "the stiffness is not positive definite: CHOLMOD met a pivot that is not"});
  throw Failure(
      {ErrorKind::kSolver, "CHOLMOD failed with status " + std::to_string(common.status)});
}

}  // namespace

struct SparseCholesky::Factor {
  cholmod_common common = {};
  cholmod_factor* l = nullptr;
  cholmod_dense *solution = nullptr, *scratch = nullptr,
                *more_scratch = nullptr;  // for one right-hand side
  Supernodes supernodes;
  Factor() {
    cholmod_start(&common);
    common.print = 0;
    common.nmethods = 1;
    common.method[0].ordering = CHOLMOD_NATURAL;
    common.postorder = 1;
    common.supernodal = CHOLMOD_SUPERNODAL;  // a simplicial factor is no better for small matrices
    common.quick_return_if_not_posdef = 1;
  }
  ~Factor() {
    for (cholmod_dense** dense : {&solution, &scratch, &more_scratch})
      cholmod_free_dense(dense, &common);
    cholmod_free_factor(&l, &common);
    cholmod_finish(&common);
  }
};

namespace {

cholmod_sparse as_cholmod(const SparseRows& matrix) {
  const std::size_t rows = matrix.rows;
  cholmod_sparse a = {};
  a.nrow = a.ncol = rows;
  a.nzmax = matrix.start[rows];
  a.p = const_cast<int*>(matrix.start);
  a.i = const_cast<int*>(matrix.column);
  a.x = const_cast<double*>(matrix.value);
  a.stype = 1;  // both triangles are stored; the upper one is read
  a.itype = CHOLMOD_INT;
  a.xtype = CHOLMOD_REAL;
  a.dtype = CHOLMOD_DOUBLE;
  a.sorted = 1;
  a.packed = 1;
  return a;
}

}  // namespace

SparseCholesky::SparseCholesky(const SparseRows& matrix) : factor_(std::make_unique<Factor>()) {
  cholmod_sparse a = as_cholmod(matrix);
  Factor& factor = *factor_;
  factor.l = cholmod_analyze(&a, &factor.common);
  if (factor.l == nullptr) fail(factor.common);
  cholmod_factorize(&a, factor.l, &factor.common);
  if (factor.common.status != CHOLMOD_OK) fail(factor.common);
  const cholmod_factor& l = *factor.l;
  factor.supernodes = {l.nsuper,
                       static_cast<const int*>(l.super),
                       static_cast<const int*>(l.pi),
                       static_cast<const int*>(l.px),
                       static_cast<const int*>(l.s),
                       static_cast<const double*>(l.x)};
  const int* first_row = factor.supernodes.first_row;
  for (std::size_t s = 0; s < l.nsuper; ++s)
    factor.supernodes.most_rows =
        std::max<std::size_t>(factor.supernodes.most_rows, first_row[s + 1] - first_row[s]);
}

SparseCholesky::~SparseCholesky() = default;

void SparseCholesky::factorise(const SparseRows& matrix) {
  cholmod_sparse a = as_cholmod(matrix);
  cholmod_common& common = factor_->common;
  common.status = CHOLMOD_OK;
  cholmod_factorize(&a, factor_->l, &common);
  if (common.status != CHOLMOD_OK) fail(common);
  factor_->supernodes.values = static_cast<const double*>(factor_->l->x);
}

void SparseCholesky::solve(const Eigen::VectorXd& b, Eigen::VectorXd& x) {
  const std::size_t rows = b.size();
  cholmod_dense from = {};
  from.nrow = from.d = from.nzmax = rows;
  from.ncol = 1;
  from.x = const_cast<double*>(b.data());
  from.xtype = CHOLMOD_REAL;
  from.dtype = CHOLMOD_DOUBLE;
  Factor& factor = *factor_;
  if (!cholmod_solve2(CHOLMOD_A, factor.l, &from, nullptr, &factor.solution, nullptr,
                      &factor.scratch, &factor.more_scratch, &factor.common))
    fail(factor.common);
  x = Eigen::Map<const Eigen::VectorXd>(static_cast<const double*>(factor.solution->x), b.size());
}

LdlReport SparseCholesky::count_negative(const SparseRows& matrix, unsigned threads) {
  return factorise_ldl(factor_->supernodes, static_cast<const int*>(factor_->l->Perm), matrix,
                       static_cast<double*>(factor_->l->x), threads);
}

double SparseCholesky::flops() const {
  return factor_->common.fl;
}

std::size_t SparseCholesky::entries() const {
  return factor_->l->xsize;
}

void SparseCholesky::solve(const ColumnsRef& b, ColumnsOut x, Workspace& workspace) const {
  const std::size_t rows = b.rows();
  const int* order = static_cast<const int*>(factor_->l->Perm);
  constexpr Eigen::Index kMost = 2 * kLanes;
  for (Eigen::Index first = 0; first < b.cols(); first += kMost) {
    const Eigen::Index width = std::min(kMost, b.cols() - first);
    const std::size_t vectors = width > static_cast<Eigen::Index>(kLanes) ? 2 : 1;
    workspace.rows.assign(rows * vectors, LaneBlock{});
    workspace.scratch.resize(factor_->supernodes.most_rows * vectors);
    auto* packed = reinterpret_cast<double*>(workspace.rows.data());
    for (Eigen::Index c = 0; c < width; ++c) {
      const double* column = b.col(first + c).data();
      for (std::size_t i = 0; i < rows; ++i) packed[i * vectors * kLanes + c] = column[order[i]];
    }
    solve_supernodes(factor_->supernodes, static_cast<int>(vectors), workspace.rows.data(),
                     workspace.scratch.data());
    for (Eigen::Index c = 0; c < width; ++c) {
      double* column = x.col(first + c).data();
      for (std::size_t i = 0; i < rows; ++i) column[order[i]] = packed[i * vectors * kLanes + c];
    }
  }
}

}  // namespace tremolo
