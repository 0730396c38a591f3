#include "runtime/math/sparse/conjugate_gradients.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

namespace tremolo {
namespace {

// The smallest relative residual that floats resolve.
constexpr double kLeastInside = 1e-4;
// The residual of the recurrence has the digits of floats: it is not computed in doubles if at
// least this fraction was requested.
constexpr double kTrusted = 1e-3;

}  // namespace

ConjugateGradients::ConjugateGradients(const BlockPattern& pattern)
    : n_(pattern.size()), storage_(make_cg_runs(pattern)) {
  if (!storage_) storage_ = make_cg_rows(pattern);
  rest_ = image_ = Eigen::VectorXd::Zero(3 * n_);
}

// Sets the matrix in floats. False if a diagonal block is not positive definite: the leading minors
// of a positive definite one are positive.
bool ConjugateGradients::take(const BlockMatrix& a) {
  double largest = 0.0;
  for (std::size_t i = 0; i < n_; ++i) {
    const Eigen::Matrix3d& d = a.diagonal(i);
    const double determinant = d.determinant();
    if (!(d(0, 0) > 0.0 && d(0, 0) * d(1, 1) - d(1, 0) * d(0, 1) > 0.0 && determinant > 0.0 &&
          std::isfinite(determinant)))
      return false;
    largest = std::max(largest, d.diagonal().maxCoeff());
  }
  scale_ = 1.0 / largest;
  if (!(scale_ > 0.0 && std::isfinite(scale_))) return false;
  storage_->take(a, scale_);
  return true;
}

// d = A^-1 r approximately, from |r| = 1 until the residual is `tolerance`. Returns the residual;
// report.positive is false if a direction p has p.A p <= 0.
double ConjugateGradients::search(double tolerance, int most, CgReport& report) {
  double rz = storage_->advance(0.0F).product, size = 1.0;
  storage_->turn(0.0F);
  while (size > tolerance && report.iterations < most) {
    ++report.iterations;
    const double curvature = storage_->multiply();
    report.positive = curvature > 0.0;
    if (!report.positive) return size;
    const CgSizes next = storage_->advance(static_cast<float>(rz / curvature));
    size = std::sqrt(next.square);
    storage_->turn(static_cast<float>(next.product / rz));
    rz = next.product;
  }
  return size;
}

// True if p.A p > 0 in doubles: rounding in floats may give another sign for a stiff matrix.
bool ConjugateGradients::is_positive(const BlockMatrix& a) {
  storage_->copy_direction(rest_);
  a.multiply(rest_, image_);
  return rest_.dot(image_) > 0.0;
}

CgReport ConjugateGradients::solve(const BlockMatrix& a, const Eigen::VectorXd& b,
                                   Eigen::VectorXd& x, double residual, int max_iterations) {
  CgReport report;
  if (!take(a)) {
    report.positive = false;
    return report;
  }
  for (double before = -1.0;; before = report.residual) {
    if (before < 0.0 && x.isZero(0.0)) {
      rest_ = b;
    } else {
      a.multiply(x, image_);
      rest_ = b - image_;
    }
    report.residual = rest_.norm();
    report.converged = report.residual <= residual;
    if (report.converged || report.iterations >= max_iterations) return report;
    // Rounding: another round would find nothing.
    if (!std::isfinite(report.residual) || (before >= 0.0 && report.residual > 0.5 * before))
      return report;
    storage_->start(rest_, 1.0 / report.residual);
    const double wanted = 0.9 * residual / report.residual;
    const double left = search(std::max(wanted, kLeastInside), max_iterations, report);
    storage_->add_found(scale_ * report.residual, x);
    if (!report.positive && !(report.positive = is_positive(a))) return report;
    if (wanted >= kTrusted && left <= wanted) {
      report.residual *= left;
      report.converged = true;
      return report;
    }
  }
}

}  // namespace tremolo
