#include "runtime/sparse/conjugate_gradients.h"

#include <cmath>

#include <Eigen/LU>

namespace tremolo {

ConjugateGradients::ConjugateGradients(const BlockPattern& pattern)
    : inverse_(pattern.size(), Eigen::Matrix3d::Identity()) {
  const auto n = static_cast<Eigen::Index>(3 * pattern.size());
  for (Eigen::VectorXd* v : {&r_, &z_, &p_, &q_}) *v = Eigen::VectorXd::Zero(n);
}

// The leading minors of each block are positive, or it has no positive inverse.
bool ConjugateGradients::invert_diagonal(const BlockMatrix& a) {
  for (std::size_t i = 0; i < inverse_.size(); ++i) {
    const Eigen::Matrix3d& d = a.diagonal(i);
    const double minor = d(0, 0) * d(1, 1) - d(1, 0) * d(0, 1);
    const double determinant = d.determinant();
    if (!(d(0, 0) > 0.0 && minor > 0.0 && determinant > 0.0 && std::isfinite(determinant)))
      return false;
    inverse_[i] = d.inverse();
  }
  return true;
}

void ConjugateGradients::precondition() {
  for (std::size_t i = 0; i < inverse_.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(3 * i);
    z_.segment<3>(k) = inverse_[i] * r_.segment<3>(k);
  }
}

CgReport ConjugateGradients::solve(const BlockMatrix& a, const Eigen::VectorXd& b,
                                   Eigen::VectorXd& x, double residual, int max_iterations) {
  CgReport report;
  if (!invert_diagonal(a)) {
    report.positive = false;
    return report;
  }
  a.multiply(x, q_);
  r_ = b - q_;
  report.residual = r_.norm();
  precondition();
  p_ = z_;
  double rz = r_.dot(z_);
  while (!(report.converged = report.residual <= residual) &&
         report.iterations < max_iterations) {
    ++report.iterations;
    a.multiply(p_, q_);
    const double curvature = p_.dot(q_);
    if (!(curvature > 0.0)) {
      report.positive = false;
      return report;
    }
    const double alpha = rz / curvature;
    x += alpha * p_;
    r_ -= alpha * q_;
    report.residual = r_.norm();
    precondition();
    const double before = rz;
    rz = r_.dot(z_);
    p_ = z_ + (rz / before) * p_;
  }
  return report;
}

}  // namespace tremolo
