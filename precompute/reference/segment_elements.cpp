#include "precompute/reference/segment_elements.h"

#include <numbers>

namespace tremolo {
namespace {

struct Deformation {
  Eigen::Matrix3d gradient;  // F = I + G
  Eigen::Matrix3d stress;    // S
};

Deformation deform(const Solid& solid, std::size_t element, const Eigen::Matrix3d& g) {
  return {Eigen::Matrix3d::Identity() + g, stress(solid.elasticity(element), green_strain(g))};
}

// Returns the derivative of the strain, in Mandel's notation, with respect to one corner: 6 x 3.
Eigen::Matrix<double, 6, 3> strain_change(const Eigen::Matrix3d& f, const Eigen::Vector3d& g) {
  constexpr double h = std::numbers::sqrt2 / 2.0;
  Eigen::Matrix<double, 6, 3> b;
  for (int x = 0; x < 3; ++x) {
    const Eigen::Vector3d r = f.row(x);
    b.col(x) << r.x() * g.x(), r.y() * g.y(), r.z() * g.z(), h * (r.y() * g.z() + r.z() * g.y()),
        h * (r.x() * g.z() + r.z() * g.x()), h * (r.x() * g.y() + r.y() * g.x());
  }
  return b;
}

void add_isotropic(const Elasticity& law, const Deformation& at, const StrainSample& sample,
                   double weight, ElementTangent& tangent) {
  const Eigen::Matrix<double, 3, 4>& g = sample.gradients;
  const Eigen::Matrix<double, 3, 4> moved = at.gradient * g;
  const Eigen::Matrix<double, 3, 4> pulled = at.stress * g;
  const Eigen::Matrix3d left = (weight * law.mu) * at.gradient * at.gradient.transpose();
  for (int a = 0; a < 4; ++a)
    for (int b = a; b < 4; ++b) {
      Eigen::Matrix3d& block = tangent[element_block(a, b)];
      block += g.col(a).dot(g.col(b)) * left;
      block += ((weight * law.lambda) * moved.col(a)) * moved.col(b).transpose();
      block += ((weight * law.mu) * moved.col(b)) * moved.col(a).transpose();
      block.diagonal().array() += weight * g.col(a).dot(pulled.col(b));
    }
}

void add_general(const Elasticity& law, const Deformation& at, const StrainSample& sample,
                 double weight, ElementTangent& tangent) {
  const Eigen::Matrix<double, 3, 4> pulled = at.stress * sample.gradients;
  Eigen::Matrix<double, 6, 3> change[4], stressed[4];
  for (int a = 0; a < 4; ++a) {
    change[a] = strain_change(at.gradient, sample.gradients.col(a));
    stressed[a] = weight * law.tensor * change[a];
  }
  for (int a = 0; a < 4; ++a)
    for (int b = a; b < 4; ++b) {
      Eigen::Matrix3d& block = tangent[element_block(a, b)];
      block += change[a].transpose() * stressed[b];
      block.diagonal().array() += weight * sample.gradients.col(a).dot(pulled.col(b));
    }
}

}  // namespace

double element_energy(const Solid& solid, std::size_t element, const Field& u) {
  const Eigen::Matrix3d strain = green_strain(displacement_gradient(solid, element, u));
  return 0.5 * solid.samples[element].weight *
         stress(solid.elasticity(element), strain).cwiseProduct(strain).sum();
}

ElementForce element_force(const Solid& solid, std::size_t element,
                           const std::vector<SegmentPoint>& points, const Field& u,
                           const Field& d) {
  const Eigen::Matrix3d start = displacement_gradient(solid, element, u);
  const Eigen::Matrix3d change = displacement_gradient(solid, element, d);
  const StrainSample& sample = solid.samples[element];
  Eigen::Matrix3d piola = Eigen::Matrix3d::Zero();
  for (const SegmentPoint& point : points) {
    const Deformation at = deform(solid, element, start + point.fraction * change);
    piola += (point.weight * sample.weight) * at.gradient * at.stress;
  }
  return piola * sample.gradients;
}

ElementTangent element_tangent(const Solid& solid, std::size_t element,
                               const std::vector<SegmentPoint>& points, const Field& u,
                               const Field& d) {
  const Eigen::Matrix3d start = displacement_gradient(solid, element, u);
  const Eigen::Matrix3d change = displacement_gradient(solid, element, d);
  const StrainSample& sample = solid.samples[element];
  const Elasticity& law = solid.elasticity(element);
  ElementTangent tangent;
  tangent.fill(Eigen::Matrix3d::Zero());
  for (const SegmentPoint& point : points) {
    const Deformation at = deform(solid, element, start + point.fraction * change);
    const double weight = point.weight * point.fraction * sample.weight;
    if (law.isotropic)
      add_isotropic(law, at, sample, weight, tangent);
    else
      add_general(law, at, sample, weight, tangent);
  }
  return tangent;
}

}  // namespace tremolo
