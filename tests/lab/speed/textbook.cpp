#include "tests/lab/speed/textbook.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <dlfcn.h>

#include <Eigen/Cholesky>

#include "common/packed_index.h"
#include "common/processor.h"

namespace tremolo::bench {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

using CoreName = char* (*)();

// nullptr: there is none. An OpenBLAS that has not recognised the processor is loaded once more:
// otherwise the comparison with the textbook would look too good.
void* open_blas(const char* library) {
  constexpr const char* kVariable = "OPENBLAS_CORETYPE";
  void* handle = ::dlopen(library, RTLD_NOW | RTLD_LOCAL);  // stays open: the process is short
  if (handle == nullptr || std::getenv(kVariable) != nullptr) return handle;
  const auto core = reinterpret_cast<CoreName>(::dlsym(handle, "openblas_get_corename"));
  const char* better = core == nullptr ? nullptr : better_blas_core(core());
  if (better == nullptr) return handle;
  ::dlclose(handle);
  ::setenv(kVariable, better, 1);
  return ::dlopen(library, RTLD_NOW | RTLD_LOCAL);
}

}  // namespace

// BLAS by its Fortran names.
struct MatrixVector {
  using Dgemv = void (*)(const char*, const int*, const int*, const double*, const double*,
                         const int*, const double*, const int*, const double*, double*, const int*);
  Dgemv dgemv = nullptr;
  std::string name = "Eigen (no BLAS library found)";

  MatrixVector() {
    for (const char* library : {"libopenblas.so.0", "libblas.so.3"}) {
      void* handle = open_blas(library);
      if (handle == nullptr) continue;
      dgemv = reinterpret_cast<Dgemv>(::dlsym(handle, "dgemv_"));
      if (dgemv == nullptr) continue;
      name = library;
      using SetThreads = void (*)(int);
      if (const auto set =
              reinterpret_cast<SetThreads>(::dlsym(handle, "openblas_set_num_threads")))
        set(1);
      if (const auto core = reinterpret_cast<CoreName>(::dlsym(handle, "openblas_get_corename")))
        name += std::string(" (") + core() + ")";
      break;
    }
  }

  void operator()(const MatrixXd& a, const VectorXd& x, VectorXd& y) const {
    if (dgemv == nullptr) {
      y.noalias() = a * x;
      return;
    }
    const int rows = static_cast<int>(a.rows()), columns = static_cast<int>(a.cols()), unit = 1;
    const double one = 1.0, zero = 0.0;
    dgemv("N", &rows, &columns, &one, a.data(), &rows, x.data(), &unit, &zero, y.data(), &unit);
  }
};

namespace {

// Hess V and grad V of the parts of `potential`, at q: probes from which the tables are read.
struct Probe {
  const Potential& potential;
  PotentialWorkspace workspace = potential.make_workspace();
  Evaluation evaluation = potential.make_evaluation();

  const Evaluation& at(const VectorXd& q) {
    potential.evaluate(q, kWantForce | kWantTangent, workspace, evaluation);
    return evaluation;
  }
};

}  // namespace

// The tables are read from the potential by evaluating its tangent, a quadratic polynomial in q, at
// 0, +-e_i and e_i + e_j: the textbook then certainly multiplies the same polynomial.
Textbook::Textbook(const Potential& potential) : r_(potential.size()) {
  const std::size_t r = r_;
  const Index pairs = pair_count(r);
  const Index triples = triple_count(r);
  Probe probe{potential};
  const auto packed = [&](const VectorXd& q) {
    const MatrixXd& k = probe.at(q).tangent;
    VectorXd v(pairs);
    for (Index j = 0, at = 0; j < r_; ++j)
      for (Index i = 0; i <= j; ++i) v[at++] = k(i, j);
    return v;
  };
  const auto unit = [&](Index i) { return VectorXd::Unit(r_, i); };
  tangent0_ = packed(VectorXd::Zero(r_));
  tangent1_.resize(pairs, r_);
  tangent2_.resize(pairs, pairs);
  for (Index j = 0; j < r_; ++j) {
    const VectorXd plus = packed(unit(j)), minus = packed(-unit(j));
    tangent1_.col(j) = 0.5 * (plus - minus);
    tangent2_.col(pair_index(j, j)) = 0.5 * (plus + minus) - tangent0_;
  }
  for (Index j = 0; j < r_; ++j)
    for (Index i = 0; i < j; ++i)
      tangent2_.col(pair_index(i, j)) = packed(unit(i) + unit(j)) - tangent0_ - tangent1_.col(i) -
                                        tangent1_.col(j) - tangent2_.col(pair_index(i, i)) -
                                        tangent2_.col(pair_index(j, j));
  // grad V = K0 q + 1/2 K1[q] q + 1/3 K2[q,q] q.
  const auto entry = [](const MatrixXd& table, Index i, Index j, Index column) {
    return table(static_cast<Index>(
                     pair_index_any(static_cast<std::size_t>(i), static_cast<std::size_t>(j))),
                 column);
  };
  force1_.resize(r_, r_);
  force2_.setZero(r_, pairs);
  force3_.setZero(r_, triples);
  for (Index a = 0; a < r_; ++a)
    for (Index j = 0; j < r_; ++j) {
      force1_(a, j) = entry(tangent0_, a, j, 0);
      for (Index k = 0; k < r_; ++k)
        force2_(a, static_cast<Index>(pair_index_any(j, k))) += 0.5 * entry(tangent1_, a, j, k);
      for (Index l = 0; l < r_; ++l)
        for (Index k = 0; k <= l; ++k)
          force3_(a, static_cast<Index>(triple_index_any(j, k, l))) +=
              entry(tangent2_, a, j, static_cast<Index>(pair_index(k, l))) / 3.0;
    }
  quadratic_.setZero(pairs);
  cubic_.setZero(triples);
  for (VectorXd& part : parts_) part.setZero(r_);
  force_.setZero(r_);
  packed_.setZero(pairs);
  tangent_.setZero(r_, r_);
  multiply_ = std::make_shared<MatrixVector>();
}

Textbook::~Textbook() = default;
Textbook::Textbook(Textbook&&) noexcept = default;

std::string Textbook::blas() const {
  return multiply_->name;
}

std::size_t Textbook::doubles() const {
  return static_cast<std::size_t>(force1_.size() + force2_.size() + force3_.size() +
                                  tangent0_.size() + tangent1_.size() + tangent2_.size());
}

void Textbook::fill_monomials(const VectorXd& q, bool third) {
  double* pair = quadratic_.data();
  for (Index j = 0; j < r_; ++j)
    for (Index i = 0; i <= j; ++i) *pair++ = q[i] * q[j];
  if (!third) return;
  double* triple = cubic_.data();
  for (Index k = 0; k < r_; ++k) {
    const Index count = pair_count(static_cast<std::size_t>(k) + 1);
    for (Index at = 0; at < count; ++at) *triple++ = quadratic_[at] * q[k];
  }
}

void Textbook::force(const VectorXd& q) {
  fill_monomials(q, true);
  (*multiply_)(force1_, q, parts_[0]);
  (*multiply_)(force2_, quadratic_, parts_[1]);
  (*multiply_)(force3_, cubic_, parts_[2]);
  force_ = parts_[0] + parts_[1] + parts_[2];
}

void Textbook::force_and_tangent(const VectorXd& q, bool energy) {
  force(q);
  if (energy) energy_ = 0.5 * q.dot(parts_[0]) + q.dot(parts_[1]) / 3.0 + 0.25 * q.dot(parts_[2]);
  (*multiply_)(tangent1_, q, packed_);
  const double* constant = tangent0_.data();
  for (Index j = 0, at = 0; j < r_; ++j)
    for (Index i = 0; i <= j; ++i, ++at) tangent_(i, j) = constant[at] + packed_[at];
  (*multiply_)(tangent2_, quadratic_, packed_);
  for (Index j = 0, at = 0; j < r_; ++j)
    for (Index i = 0; i <= j; ++i, ++at) {
      tangent_(i, j) += packed_[at];
      tangent_(j, i) = tangent_(i, j);
    }
}

int textbook_newmark_step(Textbook& textbook, double h, double tolerance, VectorXd& q, VectorXd& v,
                          VectorXd& a) {
  constexpr int kMostEvaluations = 50;
  const VectorXd start = q + h * v + 0.25 * h * h * a;
  VectorXd w = h * h * a;
  const double scale = std::max(h * v.norm(), w.norm());
  MatrixXd jacobian(q.size(), q.size());
  for (int evaluations = 1; evaluations <= kMostEvaluations; ++evaluations) {
    const VectorXd q1 = start + 0.25 * w;
    textbook.force_and_tangent(q1, false);
    VectorXd residual = w + h * h * textbook.force_value();
    if (residual.norm() <= tolerance * scale) {
      v += 0.5 * h * a + (0.5 / h) * w;
      q = q1;
      a = w / (h * h);
      return evaluations;
    }
    jacobian = (0.25 * h * h) * textbook.tangent_value();
    jacobian.diagonal().array() += 1.0;
    w -= jacobian.llt().solve(residual);
  }
  return -1;
}

void textbook_central_difference_step(Textbook& textbook, double h, VectorXd& q, VectorXd& v) {
  textbook.force(q);
  v -= h * textbook.force_value();
  q += h * v;
}

}  // namespace tremolo::bench
