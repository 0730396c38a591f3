// Solves A x = b for any matrix that can be multiplied: GMRES with right preconditioning (Saad and
// Schultz, 1986), restarted.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Jacobi>

namespace tremolo {

// Memory grows with the largest system so far.
class Gmres {
 public:
  static constexpr Eigen::Index kMostVectors = 80;  // before a restart

  // multiply(x, y): y = A x. precondition(b, x): x near A^-1 b, linear. tolerance: of the residual
  // over that of x = 0. False: it is not reached after `most` iterations; x is the best so far.
  template <class Multiply, class Precondition>
  bool solve(const Multiply& multiply, const Precondition& precondition, const Eigen::VectorXd& b,
             double tolerance, int most, Eigen::VectorXd& x) {
    const Eigen::Index n = b.size();
    x.setZero(n);
    reserve(n);
    const double stop = tolerance * b.norm();
    iterations_ = 0;
    residual_ = b;
    for (;;) {
      double size = residual_.norm();
      if (!(size > stop)) return std::isfinite(size);
      if (iterations_ >= most) return false;
      const Eigen::Index count = fill(multiply, precondition, size, stop, most);
      // y = H^-1 g, x += P V y.
      solution_.head(count) = hessenberg_.topLeftCorner(count, count)
                                  .triangularView<Eigen::Upper>()
                                  .solve(rotated_.head(count));
      work_.noalias() = basis_.leftCols(count) * solution_.head(count);
      precondition(work_, step_);
      x += step_;
      multiply(x, work_);
      residual_ = b - work_;
    }
  }
  // Of the last solve.
  int iterations() const { return iterations_; }
  double residual() const { return residual_.norm(); }

 private:
  void reserve(Eigen::Index n) {
    if (basis_.rows() == n) return;
    basis_.resize(n, kMostVectors + 1);
    hessenberg_.resize(kMostVectors + 1, kMostVectors);
    rotated_.resize(kMostVectors + 1);
    solution_.resize(kMostVectors);
    work_.resize(n);
    step_.resize(n);
    rotations_.resize(static_cast<std::size_t>(kMostVectors));
  }

  // Builds the basis until its residual is small; returns the number of its vectors.
  template <class Multiply, class Precondition>
  Eigen::Index fill(const Multiply& multiply, const Precondition& precondition, double size,
                    double stop, int most) {
    rotated_.setZero();
    rotated_[0] = size;
    basis_.col(0) = residual_ / size;
    Eigen::Index k = 0;
    while (k < kMostVectors && iterations_ < most && std::abs(rotated_[k]) > 0.5 * stop) {
      ++iterations_;
      work_ = basis_.col(k);
      precondition(work_, step_);
      multiply(step_, work_);
      // Twice, so that the basis stays orthogonal to rounding.
      hessenberg_.col(k).setZero();
      for (int pass = 0; pass < 2; ++pass) {
        solution_.head(k + 1).noalias() = basis_.leftCols(k + 1).transpose() * work_;
        work_.noalias() -= basis_.leftCols(k + 1) * solution_.head(k + 1);
        hessenberg_.col(k).head(k + 1) += solution_.head(k + 1);
      }
      const double length = work_.norm();
      hessenberg_(k + 1, k) = length;
      for (Eigen::Index i = 0; i < k; ++i)
        hessenberg_.col(k).applyOnTheLeft(i, i + 1,
                                          rotations_[static_cast<std::size_t>(i)].adjoint());
      Eigen::JacobiRotation<double>& rotation = rotations_[static_cast<std::size_t>(k)];
      rotation.makeGivens(hessenberg_(k, k), hessenberg_(k + 1, k));
      hessenberg_.col(k).applyOnTheLeft(k, k + 1, rotation.adjoint());
      rotated_.applyOnTheLeft(k, k + 1, rotation.adjoint());
      ++k;
      if (!(length > 0.0)) break;
      basis_.col(k) = work_ / length;
    }
    return k;
  }

  Eigen::MatrixXd basis_, hessenberg_;
  Eigen::VectorXd rotated_, solution_, work_, step_, residual_;
  std::vector<Eigen::JacobiRotation<double>> rotations_;
  int iterations_ = 0;
};

}  // namespace tremolo
