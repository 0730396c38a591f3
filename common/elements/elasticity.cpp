#include "common/elements/elasticity.h"

#include <numbers>

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace tremolo {
namespace {

// Entry k of Mandel's notation denotes (kRow[k], kColumn[k]) of a symmetric 3x3 matrix.
constexpr int kRow[6] = {0, 1, 2, 1, 0, 0};
constexpr int kColumn[6] = {0, 1, 2, 2, 2, 1};

using Vector6 = Eigen::Matrix<double, 6, 1>;

double scale(int k) {
  return k < 3 ? 1.0 : std::numbers::sqrt2;
}

Vector6 to_mandel(const Eigen::Matrix3d& a) {
  Vector6 v;
  for (int k = 0; k < 6; ++k) v[k] = scale(k) * a(kRow[k], kColumn[k]);
  return v;
}

Eigen::Matrix3d from_mandel(const Vector6& v) {
  Eigen::Matrix3d a;
  for (int k = 0; k < 6; ++k) {
    a(kRow[k], kColumn[k]) = v[k] / scale(k);
    a(kColumn[k], kRow[k]) = a(kRow[k], kColumn[k]);
  }
  return a;
}

Matrix6 isotropic_tensor(double lambda, double mu) {
  Matrix6 c = 2.0 * mu * Matrix6::Identity();
  c.topLeftCorner<3, 3>().array() += lambda;
  return c;
}

// Inverts the compliance, in the frame of the axes. The shear entries are 2 G, since both stress
// and strain carry a factor sqrt(2).
Matrix6 orthotropic_tensor(const OrthotropicElasticity& constants) {
  Eigen::Matrix3d compliance;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    compliance(i, i) = 1.0 / constants.young[i];
    compliance(i, j) = compliance(j, i) = -constants.poisson[i] / constants.young[i];
  }
  Matrix6 c = Matrix6::Zero();
  const Eigen::Matrix3d normal = compliance.inverse();
  c.topLeftCorner<3, 3>() = 0.5 * (normal + normal.transpose());
  c(3, 3) = 2.0 * constants.shear[1];  // yz: G23
  c(4, 4) = 2.0 * constants.shear[2];  // xz: G31
  c(5, 5) = 2.0 * constants.shear[0];  // xy: G12
  return c;
}

}  // namespace

Matrix6 mandel_rotation(const Eigen::Matrix3d& axes) {
  Matrix6 rotation;
  for (int k = 0; k < 6; ++k)
    rotation.col(k) = to_mandel(axes * from_mandel(Vector6::Unit(k)) * axes.transpose());
  return rotation;
}

Elasticity make_elasticity(const Material& material) {
  Elasticity elasticity;
  elasticity.isotropic = !material.orthotropic.has_value();
  if (elasticity.isotropic) {
    elasticity.lambda = lame_lambda(material);
    elasticity.mu = lame_mu(material);
    elasticity.tensor = isotropic_tensor(elasticity.lambda, elasticity.mu);
  } else {
    const Matrix6 turn = mandel_rotation(material.orthotropic->axes);
    const Matrix6 tensor = turn * orthotropic_tensor(*material.orthotropic) * turn.transpose();
    elasticity.tensor = 0.5 * (tensor + tensor.transpose());
  }
  elasticity.root = elasticity.tensor.llt().matrixU();
  return elasticity;
}

Eigen::Matrix3d stress(const Elasticity& elasticity, const Eigen::Matrix3d& strain) {
  if (!elasticity.isotropic) return from_mandel(elasticity.tensor * to_mandel(strain));
  Eigen::Matrix3d s = 2.0 * elasticity.mu * strain;
  s.diagonal().array() += elasticity.lambda * strain.trace();
  return s;
}

}  // namespace tremolo
