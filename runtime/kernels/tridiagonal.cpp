#include "runtime/kernels/tridiagonal.h"

#include <algorithm>
#include <cmath>

#include "runtime/kernels/lanes.h"

#define TREMOLO_KERNEL "runtime/kernels/tridiagonal.inc"
#include "runtime/kernels/every_machine.inc"

namespace tremolo {

using lanes::kLanes;
using std::size_t;

Tridiagonal::Tridiagonal(Eigen::Index size)
    : r_(static_cast<size_t>(size)),
      stride_(lanes::padded(r_)),
      diagonal_(Eigen::VectorXd::Zero(size)),
      off_(Eigen::VectorXd::Zero(std::max<Eigen::Index>(size - 1, 0))),
      masks_(lane_masks()),
      work_(stride_ * stride_, 0.0),
      reflections_(stride_ * stride_, 0.0),
      factors_(stride_, 0.0),
      basis_(stride_ * stride_, 0.0),
      image_(stride_ + kLanes, 0.0),
      vector_(2 * stride_ + kLanes, 0.0) {}

void Tridiagonal::compute(const Eigen::MatrixXd& a) {
  if (r_ == 0) return;
  for (size_t j = 0; j < r_; ++j)
    for (size_t i = j; i < r_; ++i)
      work_[i * stride_ + j] = work_[j * stride_ + i] = a.data()[j * r_ + i];
  (*TREMOLO_BEST(reduce))(work_.data(), r_, stride_, masks_.data(), diagonal_.data(), off_.data(),
                          reflections_.data(), factors_.data(), image_.data());
  // What overflowed is in the padding too, which the next matrix needs to be zero.
  if (!diagonal_.allFinite() || !off_.allFinite()) std::fill(work_.begin(), work_.end(), 0.0);
  (*TREMOLO_BEST(accumulate))(reflections_.data(), factors_.data(), r_, stride_, basis_.data(),
                              image_.data());
}

void Tridiagonal::to_basis(Eigen::VectorXd& x) const {
  std::copy(x.data(), x.data() + r_, vector_.begin());
  (*TREMOLO_BEST(multiply))(basis_.data(), r_, stride_, vector_.data(), vector_.data() + stride_);
  std::copy_n(vector_.data() + stride_, r_, x.data());
}

void Tridiagonal::from_basis(Eigen::VectorXd& x) const {
  std::copy(x.data(), x.data() + r_, vector_.begin());
  (*TREMOLO_BEST(multiply_transposed))(basis_.data(), r_, stride_, vector_.data(),
                                       vector_.data() + stride_);
  std::copy_n(vector_.data() + stride_, r_, x.data());
}

}  // namespace tremolo
