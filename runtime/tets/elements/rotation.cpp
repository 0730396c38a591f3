#include "runtime/tets/elements/rotation.h"

#include <cmath>

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

}  // namespace tremolo
