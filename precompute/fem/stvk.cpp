#include "precompute/fem/stvk.h"

#include <numbers>

#include <Eigen/LU>

namespace tremolo {
namespace {

Eigen::Matrix3d symmetric_part(const Eigen::Matrix3d& a) {
  return 0.5 * (a + a.transpose());
}

// Returns V B^T C B, where B maps the corners' displacements to the strain in Mandel's notation.
Eigen::Matrix<double, 12, 12> general_stiffness(const Elasticity& elasticity,
                                                const StrainSample& sample) {
  Eigen::Matrix<double, 6, 12> b;
  for (int a = 0; a < 4; ++a) {
    const Eigen::Vector3d g = sample.gradients.col(a);
    const double h = std::numbers::sqrt2 / 2.0;
    b.middleCols<3>(3 * a) << g.x(), 0, 0, 0, g.y(), 0, 0, 0, g.z(), 0, h * g.z(), h * g.y(),
        h * g.z(), 0, h * g.x(), h * g.y(), h * g.x(), 0;
  }
  return sample.weight * b.transpose() * elasticity.tensor * b;
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
  return make_solid(mesh, MaterialTable{{{"", material}}, {}});
}

Solid make_solid(const TetMesh& mesh, const MaterialTable& table) {
  Solid solid{mesh, strain_samples(mesh), {}, {}, table.of_tet, {}};
  for (const NamedMaterial& named : table.materials) {
    solid.elasticities.push_back(make_elasticity(named.material));
    solid.densities.push_back(named.material.density);
  }
  return solid;
}

Solid make_solid(const TetMesh& part, const std::vector<std::size_t>& tetrahedra,
                 const MaterialTable& table) {
  MaterialTable chosen{table.materials, {}};
  if (!table.of_tet.empty())
    for (const std::size_t e : tetrahedra) chosen.of_tet.push_back(table.of_tet[e]);
  return make_solid(part, chosen);
}

Eigen::Matrix3d displacement_gradient(const Solid& solid, std::size_t element, const FieldRef& u) {
  const Tetrahedron& tet = solid.mesh.tetrahedra[element];
  Eigen::Matrix<double, 3, 4> corners;
  for (int a = 0; a < 4; ++a) corners.col(a) = u.segment<3>(3 * Eigen::Index{tet[a]});
  return corners * solid.samples[element].gradients.transpose();
}

Eigen::Matrix3d green_strain(const Eigen::Matrix3d& g) {
  return symmetric_part(g) + 0.5 * g.transpose() * g;
}

double strain_energy(const Solid& solid, const FieldRef& u) {
  double energy = 0;
  for (std::size_t e = 0; e < solid.samples.size(); ++e) {
    const Eigen::Matrix3d strain = green_strain(displacement_gradient(solid, e, u));
    energy += 0.5 * solid.samples[e].weight *
              stress(solid.elasticity(e), strain).cwiseProduct(strain).sum();
  }
  return energy;
}

Field internal_force(const Solid& solid, const FieldRef& u) {
  return internal_force(solid, u, solid.samples.size());
}

Field internal_force(const Solid& solid, const FieldRef& u, std::size_t count) {
  Field force = Field::Zero(u.size());
  for (std::size_t e = 0; e < count; ++e) {
    const Eigen::Matrix3d g = displacement_gradient(solid, e, u);
    const Eigen::Matrix3d piola =
        (Eigen::Matrix3d::Identity() + g) * stress(solid.elasticity(e), green_strain(g));
    const Eigen::Matrix<double, 3, 4> corners =
        solid.samples[e].weight * piola * solid.samples[e].gradients;
    for (int a = 0; a < 4; ++a)
      force.segment<3>(3 * Eigen::Index{solid.mesh.tetrahedra[e][a]}) += corners.col(a);
  }
  return force;
}

void add_second_derivative(const Solid& solid, const std::vector<int>& elements, const FieldRef& a,
                           const FieldRef& b, const std::vector<int>& row_of_vertex, double* out) {
  for (int element : elements) {
    const std::size_t e = element;
    const Elasticity& elasticity = solid.elasticity(e);
    const Eigen::Matrix3d ga = displacement_gradient(solid, e, a);
    const Eigen::Matrix3d gb = displacement_gradient(solid, e, b);
    const Eigen::Matrix3d piola = stress(elasticity, symmetric_part(ga.transpose() * gb)) +
                                  ga * stress(elasticity, symmetric_part(gb)) +
                                  gb * stress(elasticity, symmetric_part(ga));
    const Eigen::Matrix<double, 3, 4> corners =
        solid.samples[e].weight * piola * solid.samples[e].gradients;
    for (int corner = 0; corner < 4; ++corner) {
      const int row = row_of_vertex[solid.mesh.tetrahedra[e][corner]];
      if (row >= 0) Eigen::Map<Eigen::Vector3d>(out + row) += corners.col(corner);
    }
  }
}

Eigen::Matrix<double, 12, 12> rest_stiffness(const Elasticity& elasticity,
                                             const StrainSample& sample) {
  if (!elasticity.isotropic) return general_stiffness(elasticity, sample);
  const double lambda = elasticity.lambda;
  const double mu = elasticity.mu;
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
