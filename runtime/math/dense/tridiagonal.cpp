#include "runtime/math/dense/tridiagonal.h"

#include <algorithm>
#include <cmath>

#include "runtime/math/kernels/lanes.h"

namespace tremolo {
namespace {

// r columns `stride` apart, aligned to 64 bytes, zeros from row r on.
template <class Number>
struct PaddedMatrix {
  Number* columns;
  std::size_t r;
  std::size_t stride;
};

// Results of reduce() (Tridiagonal has the names), and scratch w.
struct Reduction {
  double* diagonal;
  double* off;
  double* u;
  double* f;
  double* w;
};

// Results of PartialFractions::compute() (tridiagonal.h has the names), and scratch; r each.
struct PoleFactors {
  std::size_t r;
  const ComplexLanes* inverse;
  const ComplexLanes* ratio;
  ComplexLanes* scratch;
};

}  // namespace
}  // namespace tremolo

#define TREMOLO_KERNEL "runtime/math/dense/tridiagonal.inc"
#include "runtime/math/kernels/every_instruction_set.inc"

namespace tremolo {

using std::size_t;

Tridiagonal::Tridiagonal(Eigen::Index size)
    : r_(static_cast<size_t>(size)),
      stride_(padded(r_)),
      diagonal_(Eigen::VectorXd::Zero(size)),
      off_(Eigen::VectorXd::Zero(std::max<Eigen::Index>(size - 1, 0))),
      a_(stride_ * stride_, 0.0),
      u_(stride_ * stride_, 0.0),
      f_(stride_, 0.0),
      basis_(stride_ * stride_, 0.0),
      image_(stride_ + kVectorLanes, 0.0),
      vector_(2 * stride_ + kVectorLanes, 0.0) {}

void Tridiagonal::compute(const Eigen::MatrixXd& a) {
  if (r_ == 0) return;
  for (size_t j = 0; j < r_; ++j)
    for (size_t i = j; i < r_; ++i)
      a_[i * stride_ + j] = a_[j * stride_ + i] = a.data()[j * r_ + i];
  const Reduction reduction{diagonal_.data(), off_.data(), u_.data(), f_.data(), image_.data()};
  TREMOLO_CALL(reduce, {a_.data(), r_, stride_}, reduction);
  // The padding may contain overflowed numbers too; the next matrix needs zeros there.
  if (!diagonal_.allFinite() || !off_.allFinite()) std::fill(a_.begin(), a_.end(), 0.0);
  TREMOLO_CALL(accumulate, reduction, {basis_.data(), r_, stride_});
}

void Tridiagonal::to_basis(Eigen::VectorXd& x) const {
  std::copy(x.data(), x.data() + r_, vector_.begin());
  double* image = vector_.data() + stride_;
  TREMOLO_CALL(multiply, {basis_.data(), r_, stride_}, vector_.data(), image);
  std::copy_n(image, r_, x.data());
}

void Tridiagonal::from_basis(Eigen::VectorXd& x) const {
  std::copy(x.data(), x.data() + r_, vector_.begin());
  double* image = vector_.data() + stride_;
  TREMOLO_CALL(multiply_transposed, {basis_.data(), r_, stride_}, vector_.data(), image);
  std::copy_n(image, r_, x.data());
}

PartialFractions::PartialFractions(Eigen::Index size, const ComplexLanes& poles)
    : poles_(poles), inverse_(static_cast<size_t>(size)), ratio_(inverse_), scratch_(inverse_) {}

void PartialFractions::compute(const Tridiagonal& t) {
  if (inverse_.empty()) return;
  TREMOLO_CALL(factor_poles, t.diagonal().data(), t.off().data(), poles_, inverse_.size(),
               inverse_.data(), ratio_.data());
}

void PartialFractions::apply(const ComplexLanes& residues, double limit, Eigen::VectorXd& x) {
  if (inverse_.empty()) return;
  const PoleFactors factors{inverse_.size(), inverse_.data(), ratio_.data(), scratch_.data()};
  TREMOLO_CALL(sum_fractions, factors, residues, limit, x.data());
}

}  // namespace tremolo
