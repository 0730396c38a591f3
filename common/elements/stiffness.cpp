#include "common/elements/stiffness.h"

#include <numbers>

#include <Eigen/LU>

namespace tremolo {
namespace {

// Adds weight B^T C B, where B maps the nodes' displacements to the strain in Mandel's notation.
void add_general(const Elasticity& elasticity, const NodeGradients& gradients, double weight,
                 ElementStiffness& stiffness) {
  Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::ColMajor, 6, 3 * kMostNodes> b(
      6, 3 * gradients.cols());
  for (int a = 0; a < gradients.cols(); ++a) {
    const Eigen::Vector3d g = gradients.col(a);
    const double h = std::numbers::sqrt2 / 2.0;
    b.middleCols<3>(3 * a) << g.x(), 0, 0, 0, g.y(), 0, 0, 0, g.z(), 0, h * g.z(), h * g.y(),
        h * g.z(), 0, h * g.x(), h * g.y(), h * g.x(), 0;
  }
  stiffness += weight * b.transpose() * elasticity.tensor * b;
}

void add_isotropic(const Elasticity& elasticity, const NodeGradients& gradients, double weight,
                   ElementStiffness& stiffness) {
  const double lambda = elasticity.lambda;
  const double mu = elasticity.mu;
  for (int a = 0; a < gradients.cols(); ++a)
    for (int b = 0; b < gradients.cols(); ++b) {
      const Eigen::Vector3d ga = gradients.col(a);
      const Eigen::Vector3d gb = gradients.col(b);
      Eigen::Matrix3d block = lambda * ga * gb.transpose() + mu * gb * ga.transpose();
      block.diagonal().array() += mu * ga.dot(gb);
      stiffness.block<3, 3>(3 * a, 3 * b) += weight * block;
    }
}

}  // namespace

ElementGeometry element_geometry(const std::array<Eigen::Vector3d, 4>& corners) {
  Eigen::Matrix3d edges;
  for (int a = 0; a < 3; ++a) edges.col(a) = corners[a + 1] - corners[0];
  ElementGeometry element;
  element.volume = edges.determinant() / 6.0;
  element.gradients.rightCols<3>() = edges.inverse().transpose();
  element.gradients.col(0) = -element.gradients.rightCols<3>().rowwise().sum();
  return element;
}

ElementStiffness rest_stiffness(const ElementGeometry& geometry, const Elasticity& elasticity,
                                int order) {
  const int size = 3 * nodes_of_order(order);
  ElementStiffness stiffness = ElementStiffness::Zero(size, size);
  for (const SamplePoint& point : sample_points(order, 2)) {
    const NodeGradients gradients = node_gradients(geometry, order, point);
    const double weight = point.share * geometry.volume;
    if (elasticity.isotropic)
      add_isotropic(elasticity, gradients, weight, stiffness);
    else
      add_general(elasticity, gradients, weight, stiffness);
  }
  return stiffness;
}

}  // namespace tremolo
