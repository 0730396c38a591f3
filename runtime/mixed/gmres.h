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
  bool solve(const Multiply& multiply, const Precondition& precondition,
             const Eigen::Ref<const Eigen::VectorXd>& b, double tolerance, int most,
             Eigen::Ref<Eigen::VectorXd> x) {
    n_ = b.size();
    x.setZero();
    reserve();
    const double stop = tolerance * b.norm();
    iterations_ = 0;
    residual_.head(n_) = b;
    for (;;) {
      const double size = residual();
      if (!(size > stop)) return std::isfinite(size);
      if (iterations_ >= most) return false;
      const Eigen::Index count = fill(multiply, precondition, size, stop, most);
      // y = H^-1 g, x += P V y.
      auto solution = solution_.head(count);
      solution = rotated_.head(count);
      hessenberg_.topLeftCorner(count, count).triangularView<Eigen::Upper>().solveInPlace(solution);
      work_.head(n_).noalias() = basis_.topLeftCorner(n_, count) * solution_.head(count);
      precondition(work_.head(n_), step_.head(n_));
      x += step_.head(n_);
      multiply(x, work_.head(n_));
      residual_.head(n_) = b - work_.head(n_);
    }
  }
  // Of the last solve.
  int iterations() const { return iterations_; }
  double residual() const { return residual_.head(n_).norm(); }

 private:
  void reserve() {
    if (basis_.rows() >= n_) return;
    basis_.resize(n_, kMostVectors + 1);
    hessenberg_.resize(kMostVectors + 1, kMostVectors);
    rotated_.resize(kMostVectors + 1);
    solution_.resize(kMostVectors);
    for (Eigen::VectorXd* v : {&work_, &step_, &residual_}) v->resize(n_);
    rotations_.resize(static_cast<std::size_t>(kMostVectors));
  }

  // Builds the basis until its residual is small; returns the number of its vectors.
  template <class Multiply, class Precondition>
  Eigen::Index fill(const Multiply& multiply, const Precondition& precondition, double size,
                    double stop, int most) {
    rotated_.setZero();
    rotated_[0] = size;
    basis_.col(0).head(n_) = residual_.head(n_) / size;
    Eigen::Index k = 0;
    auto work = work_.head(n_), step = step_.head(n_);
    while (k < kMostVectors && iterations_ < most && std::abs(rotated_[k]) > 0.5 * stop) {
      ++iterations_;
      work = basis_.col(k).head(n_);
      precondition(work, step);
      multiply(step, work);
      // Twice, so that the basis stays orthogonal to rounding.
      hessenberg_.col(k).setZero();
      const auto known = basis_.topLeftCorner(n_, k + 1);
      for (int pass = 0; pass < 2; ++pass) {
        solution_.head(k + 1).noalias() = known.transpose() * work;
        work.noalias() -= known * solution_.head(k + 1);
        hessenberg_.col(k).head(k + 1) += solution_.head(k + 1);
      }
      const double length = work.norm();
      hessenberg_(k + 1, k) = length;
      for (Eigen::Index i = 0; i < k; ++i)
        rotate(hessenberg_(i, k), hessenberg_(i + 1, k), rotations_[static_cast<std::size_t>(i)]);
      Eigen::JacobiRotation<double>& rotation = rotations_[static_cast<std::size_t>(k)];
      rotation.makeGivens(hessenberg_(k, k), hessenberg_(k + 1, k));
      rotate(hessenberg_(k, k), hessenberg_(k + 1, k), rotation);
      rotate(rotated_[k], rotated_[k + 1], rotation);
      ++k;
      if (!(length > 0.0)) break;
      basis_.col(k).head(n_) = work / length;
    }
    return k;
  }

  // The adjoint of the rotation, applied to two entries of a column.
  static void rotate(double& upper, double& lower, const Eigen::JacobiRotation<double>& by) {
    const double above = by.c() * upper - by.s() * lower;
    lower = by.s() * upper + by.c() * lower;
    upper = above;
  }

  Eigen::Index n_ = 0;  // of the present system; the buffers may be larger
  Eigen::MatrixXd basis_, hessenberg_;
  Eigen::VectorXd rotated_, solution_, work_, step_, residual_;
  std::vector<Eigen::JacobiRotation<double>> rotations_;
  int iterations_ = 0;
};

}  // namespace tremolo
