#include "runtime/bodies/tets/elements/element_turn.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>

namespace tremolo {
namespace {

// Newton's iteration; false if A is too flat for it.
bool newton_polar(const Eigen::Matrix3d& a, Eigen::Matrix3d& rotation) {
  Eigen::Matrix3d x = a;
  for (int step = 0; step < 12; ++step) {
    const double determinant = x.determinant();
    // Below this the inverse has lost half its digits.
    const double square = x.squaredNorm();
    if (!(determinant > 1e-8 * square * std::sqrt(square))) return false;
    Eigen::Matrix3d cofactors;
    cofactors.col(0) = x.col(1).cross(x.col(2));
    cofactors.col(1) = x.col(2).cross(x.col(0));
    cofactors.col(2) = x.col(0).cross(x.col(1));
    const Eigen::Matrix3d inverse = cofactors / determinant;  // X^-T
    const double near_one = inverse.squaredNorm() / x.squaredNorm();
    const double g = std::abs(near_one - 1.0) < 0.02 ? 1.0 : std::sqrt(std::sqrt(near_one));
    const Eigen::Matrix3d next = 0.5 * (g * x + inverse / g);
    const double change = (next - x).squaredNorm();
    x = next;
    // Convergence is quadratic: half the square of a change of 1e-8 is below rounding.
    if (change < 1e-16) break;
  }
  rotation = x;
  return (x.transpose() * x - Eigen::Matrix3d::Identity()).squaredNorm() < 1e-26;
}

}  // namespace

Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& a) {
  const double largest = a.cwiseAbs().maxCoeff();
  if (!a.allFinite() || !(largest > 0.0)) return Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d scaled = a / largest;
  Eigen::Matrix3d rotation;
  if (newton_polar(scaled, rotation)) return rotation;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(scaled, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d u = svd.matrixU();
  rotation = u * svd.matrixV().transpose();
  if (rotation.determinant() < 0.0) {
    u.col(2) = -u.col(2);
    rotation = u * svd.matrixV().transpose();
  }
  return rotation;
}

Eigen::Matrix3d rotation_by(const Eigen::Vector3d& w) {
  const double angle = w.norm();
  if (!(angle > 1e-300)) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, w / angle).toRotationMatrix();
}

namespace {

Eigen::Matrix3d symmetric(const Eigen::Matrix3d& a) {
  return 0.5 * (a + a.transpose());
}

// [e_j] S: rows of S, one of them removed.
Eigen::Matrix3d unit_turn(int j, const Eigen::Matrix3d& s) {
  const int k = (j + 1) % 3, l = (j + 2) % 3;
  Eigen::Matrix3d turned = Eigen::Matrix3d::Zero();
  turned.row(k) = -s.row(l);
  turned.row(l) = s.row(k);
  return turned;
}

// A^-1 x for a Newton step: a descent direction also where A is not positive definite.
Eigen::Vector3d downhill(const Eigen::Matrix3d& a, const Eigen::Vector3d& gradient) {
  const double determinant = a.determinant();
  const bool positive = a(0, 0) > 0.0 && a(0, 0) * a(1, 1) - a(0, 1) * a(1, 0) > 0.0 &&
                        determinant > 1e-9 * std::pow(a.trace(), 3);
  if (positive) return -a.inverse() * gradient;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen;
  eigen.computeDirect(a);
  const Eigen::Vector3d size = eigen.eigenvalues().cwiseAbs();
  const double least = 1e-6 * size.maxCoeff();
  if (!(least > 0.0)) return Eigen::Vector3d::Zero();
  return -(eigen.eigenvectors() * size.cwiseMax(least).cwiseInverse().asDiagonal() *
           eigen.eigenvectors().transpose() * gradient);
}

}  // namespace

Eigen::Matrix3d trace_minus(const Eigen::Matrix3d& s) {
  return s.trace() * Eigen::Matrix3d::Identity() - s;
}

TurnDerivatives turn_derivatives(const TetElement& element, const Elasticity& elasticity,
                                 const TetShape& shape) {
  const double weight = element.geometry.volume / shape.samples;
  TurnDerivatives d;
  d.gradient.setZero();
  d.hessian.setZero();
  d.turned.setZero();
  for (std::size_t s = 0; s < static_cast<std::size_t>(shape.samples); ++s) {
    const Eigen::Matrix3d product = shape.seen[s] * shape.stress[s];
    d.gradient -= weight * axial(product);
    d.hessian -= weight * trace_minus(symmetric(product));
    std::array<Eigen::Matrix3d, 3> strain, answer;
    for (int j = 0; j < 3; ++j) {
      strain[j] = symmetric(unit_turn(j, shape.seen[s]));
      answer[j] = stress(elasticity, strain[j]);
    }
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j <= i; ++j) {
        d.turned(i, j) += weight * strain[i].cwiseProduct(answer[j]).sum();
        d.turned(j, i) = d.turned(i, j);
      }
  }
  const Eigen::Matrix3d p = trace_minus(shape.mean);
  const Eigen::Vector3d b = axial(shape.mean);
  const double m = element.couple;
  d.gradient += m * p.transpose() * b;
  d.hessian -= m * (b * b.transpose() + symmetric(cross_matrix(b) * shape.mean));
  d.turned += m * p.transpose() * p;
  d.hessian += d.turned;
  return d;
}

TurnMatrices turn_matrices(const TetElement& element, const Elasticity& elasticity,
                           const TetShape& shape) {
  if (shape.has_turn) return {shape.hessian, shape.turned};
  const TurnDerivatives d = turn_derivatives(element, elasticity, shape);
  return {d.hessian, d.turned};
}

void turn_shape(const TetElement& element, const Elasticity& elasticity, const Eigen::Vector3d& w,
                TetShape& shape) {
  const Eigen::Matrix3d turn = rotation_by(w);
  shape.rotation = shape.rotation * turn;
  shape.mean = turn.transpose() * shape.mean;
  for (std::size_t s = 0; s < static_cast<std::size_t>(shape.samples); ++s) {
    shape.seen[s] = turn.transpose() * shape.seen[s];
    shape.stress[s] = stress(elasticity, symmetric(shape.seen[s]) - Eigen::Matrix3d::Identity());
  }
  shape.couple = element.couple * axial(shape.mean);
}

void find_least_energy(const TetElement& element, const Elasticity& elasticity, TetShape& shape) {
  constexpr int kMostSteps = 40;
  // Newton's error squares: it is below rounding after a step of this size.
  constexpr double kLastStep = 1e-9;
  constexpr double kLongestStep = 0.5;
  constexpr double kSurelyNear = 1e-5;
  double energy = tet_energy(element, shape);
  for (int step = 0; step < kMostSteps; ++step) {
    const TurnDerivatives d = turn_derivatives(element, elasticity, shape);
    Eigen::Vector3d w = downhill(d.hessian, d.gradient);
    const double length = w.norm();
    if (!std::isfinite(length)) break;
    if (length > kLongestStep) w *= kLongestStep / length;
    const TetShape before = shape;
    // Near the minimum the energy has too few digits; Newton's step is accurate there.
    bool lower = false;
    for (int halving = 0; halving < 20 && !lower; ++halving, w *= 0.5) {
      shape = before;
      turn_shape(element, elasticity, w, shape);
      const double now = tet_energy(element, shape);
      lower = now <= energy || length < kSurelyNear;
      if (lower) energy = now;
    }
    if (!lower) shape = before;
    shape.converged = lower && length < kLastStep;
    if (shape.converged || !lower) return;
  }
  shape.converged = false;
}

Eigen::Matrix3d bounded_inverse(const Eigen::Matrix3d& a) {
  // The least eigenvalue of a positive matrix is at least det / tr^2: then no bound applies, and
  // cofactors lose at most six digits.
  const double trace = a.trace(), determinant = a.determinant();
  if (a(0, 0) > 0.0 && a(0, 0) * a(1, 1) - a(0, 1) * a(1, 0) > 0.0 &&
      determinant > 1e-6 * trace * trace * trace)
    return a.inverse();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen;
  eigen.compute(a);
  Eigen::Vector3d values = eigen.eigenvalues();
  const double least = 1e-9 * values.cwiseAbs().maxCoeff();
  if (!(least > 0.0)) return Eigen::Matrix3d::Zero();
  for (double& value : values)
    if (std::abs(value) < least) value = value < 0.0 ? -least : least;
  return eigen.eigenvectors() * values.cwiseInverse().asDiagonal() *
         eigen.eigenvectors().transpose();
}

}  // namespace tremolo
