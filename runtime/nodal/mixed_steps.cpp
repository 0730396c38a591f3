#include "runtime/nodal/mixed_steps.h"

#include <algorithm>

#include <Eigen/Cholesky>

namespace tremolo {

MixedSteps::MixedSteps(Eigen::Index size)
    : dx_(Eigen::MatrixXd::Zero(size, kKept)),
      dp_(Eigen::MatrixXd::Zero(size, kKept)),
      x_(Eigen::VectorXd::Zero(size)),
      p_(x_),
      products_(decltype(products_)::Zero()) {}

bool MixedSteps::mix(const Eigen::VectorXd& x, const Eigen::VectorXd& p, Eigen::VectorXd& mixed) {
  // Rounding would choose among differences that are closer to linear dependence.
  constexpr double kLeastShare = 1e-10;
  if (total_++ > 0) {
    const Eigen::Index column = (total_ - 2) % kKept;
    dx_.col(column) = x - x_;
    dp_.col(column) = p - p_;
    count_ = std::min(count_ + 1, kKept);
    for (Eigen::Index k = 0; k < count_; ++k)
      products_(k, column) = products_(column, k) = dp_.col(k).dot(dp_.col(column));
  }
  x_ = x;
  p_ = p;
  if (count_ == 0) return false;
  Small matrix = products_.topLeftCorner(count_, count_);
  matrix.diagonal() *= 1.0 + kLeastShare;
  Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kKept, 1> g(count_);
  for (Eigen::Index k = 0; k < count_; ++k) g[k] = dp_.col(k).dot(p);
  const Eigen::LLT<Small> factor(matrix);
  if (factor.info() != Eigen::Success) return false;
  factor.solveInPlace(g);
  if (!g.allFinite()) return false;
  mixed = p;
  for (Eigen::Index k = 0; k < count_; ++k) mixed -= g[k] * (dx_.col(k) + dp_.col(k));
  return true;
}

}  // namespace tremolo
