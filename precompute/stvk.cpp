#include "precompute/stvk.h"

#include <Eigen/LU>

namespace tremolo {
namespace {

Eigen::Matrix3d symmetric_part(const Eigen::Matrix3d& a) {
  return 0.5 * (a + a.transpose());
}

Eigen::Matrix3d green_strain(const Eigen::Matrix3d& g) {
  return symmetric_part(g) + 0.5 * g.transpose() * g;
}

}  // namespace

std::vector<StrainSample> strain_samples(const TetMesh& mesh) {
  std::vector<StrainSample> samples;
  samples.reserve(mesh.tetrahedra.size());
  for (const Tetrahedron& tet : mesh.tetrahedra) {
    Eigen::Matrix3d edges;
    for (int a = 0; a < 3; ++a) edges.col(a) = mesh.vertices[tet[a + 1]] - mesh.vertices[tet[0]];
    StrainSample sample;
    sample.weight = edges.determinant() / 6.0;
    sample.gradients.rightCols<3>() = edges.inverse().transpose();
    sample.gradients.col(0) = -sample.gradients.rightCols<3>().rowwise().sum();
    samples.push_back(sample);
  }
  return samples;
}

Solid make_solid(const TetMesh& mesh, const Material& material) {
  return {mesh, material, strain_samples(mesh)};
}

Eigen::Matrix3d displacement_gradient(const Solid& solid, std::size_t element, const FieldRef& u) {
  const Tetrahedron& tet = solid.mesh.tetrahedra[element];
  Eigen::Matrix<double, 3, 4> corners;
  for (int a = 0; a < 4; ++a) corners.col(a) = u.segment<3>(3 * Eigen::Index{tet[a]});
  return corners * solid.samples[element].gradients.transpose();
}

Eigen::Matrix3d stress(const Material& material, const Eigen::Matrix3d& strain) {
  Eigen::Matrix3d s = 2.0 * lame_mu(material) * strain;
  s.diagonal().array() += lame_lambda(material) * strain.trace();
  return s;
}

double strain_energy(const Solid& solid, const FieldRef& u) {
  double energy = 0;
  for (std::size_t e = 0; e < solid.samples.size(); ++e) {
    const Eigen::Matrix3d strain = green_strain(displacement_gradient(solid, e, u));
    energy +=
        0.5 * solid.samples[e].weight * stress(solid.material, strain).cwiseProduct(strain).sum();
  }
  return energy;
}

Field internal_force(const Solid& solid, const FieldRef& u) {
  Field force = Field::Zero(u.size());
  for (std::size_t e = 0; e < solid.samples.size(); ++e) {
    const Eigen::Matrix3d g = displacement_gradient(solid, e, u);
    const Eigen::Matrix3d piola =
        (Eigen::Matrix3d::Identity() + g) * stress(solid.material, green_strain(g));
    const Eigen::Matrix<double, 3, 4> corners =
        solid.samples[e].weight * piola * solid.samples[e].gradients;
    for (int a = 0; a < 4; ++a)
      force.segment<3>(3 * Eigen::Index{solid.mesh.tetrahedra[e][a]}) += corners.col(a);
  }
  return force;
}

void add_second_derivative(const Solid& solid, const std::vector<int>& elements, const FieldRef& a,
                           const FieldRef& b, const std::vector<int>& row_of_vertex, double* out) {
  const Material& material = solid.material;
  for (int element : elements) {
    const auto e = static_cast<std::size_t>(element);
    const Eigen::Matrix3d ga = displacement_gradient(solid, e, a);
    const Eigen::Matrix3d gb = displacement_gradient(solid, e, b);
    const Eigen::Matrix3d piola = stress(material, symmetric_part(ga.transpose() * gb)) +
                                  ga * stress(material, symmetric_part(gb)) +
                                  gb * stress(material, symmetric_part(ga));
    const Eigen::Matrix<double, 3, 4> corners =
        solid.samples[e].weight * piola * solid.samples[e].gradients;
    for (int corner = 0; corner < 4; ++corner) {
      const int row = row_of_vertex[solid.mesh.tetrahedra[e][corner]];
      if (row >= 0) Eigen::Map<Eigen::Vector3d>(out + row) += corners.col(corner);
    }
  }
}

Eigen::Matrix<double, 12, 12> rest_stiffness(const Material& material, const StrainSample& sample) {
  const double lambda = lame_lambda(material);
  const double mu = lame_mu(material);
  Eigen::Matrix<double, 12, 12> stiffness;
  for (int a = 0; a < 4; ++a)
    for (int b = 0; b < 4; ++b) {
      const Eigen::Vector3d ga = sample.gradients.col(a);
      const Eigen::Vector3d gb = sample.gradients.col(b);
      Eigen::Matrix3d block = lambda * ga * gb.transpose() + mu * gb * ga.transpose();
      block.diagonal().array() += mu * ga.dot(gb);
      stiffness.block<3, 3>(3 * a, 3 * b) = sample.weight * block;
    }
  return stiffness;
}

}  // namespace tremolo
