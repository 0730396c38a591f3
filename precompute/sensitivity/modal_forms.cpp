#include "precompute/sensitivity/modal_forms.h"

#include <cmath>
#include <numbers>

#include <Eigen/Core>

#include "common/elements/elasticity.h"
#include "precompute/dense/dense_decompositions.h"
#include "precompute/system/petsc.h"

namespace tremolo {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

// Integrals over a material: (tr E)^2 and E:E of an isotropic one, E:C:E of another.
struct Integrals {
  MatrixXd trace, strain, energy, mass;

  explicit Integrals(Index k)
      : trace(MatrixXd::Zero(k, k)), strain(trace), energy(trace), mass(trace) {}
};

// The strains of all modes at a sample point in Mandel's notation, 6 x k.
MatrixXd strains_at(const SamplePoint& point, const std::vector<GradientField>& fields) {
  constexpr double kRoot = std::numbers::sqrt2 / 2.0;
  MatrixXd strains(6, std::ssize(fields));
  for (std::size_t j = 0; j < fields.size(); ++j) {
    const Eigen::Matrix3d g = fields[j](point);
    strains.col(static_cast<Index>(j)) << g(0, 0), g(1, 1), g(2, 2), kRoot * (g(1, 2) + g(2, 1)),
        kRoot * (g(0, 2) + g(2, 0)), kRoot * (g(0, 1) + g(1, 0));
  }
  return strains;
}

void add_strains(const Solid& solid, std::size_t e, const BasisRows& psi,
                 std::vector<GradientField>& fields, Integrals& sums) {
  const ElementNodes nodes = element_nodes(solid.mesh, e);
  for (std::size_t j = 0; j < fields.size(); ++j)
    fields[j] = gradient_field(solid.elements[e], solid.order(), [&](int node) {
      return Eigen::Vector3d(psi.col(static_cast<Index>(j)).segment<3>(3 * Index{nodes[node]}));
    });
  const Elasticity& material = solid.elasticity(e);
  for (const SamplePoint& point : sample_points(solid.order(), 2)) {
    const double weight = point.share * solid.elements[e].volume;
    const MatrixXd strains = strains_at(point, fields);
    if (!material.isotropic) {
      sums.energy.noalias() += weight * strains.transpose() * (material.tensor * strains);
      continue;
    }
    const Eigen::RowVectorXd trace = strains.topRows<3>().colwise().sum();
    sums.trace.noalias() += weight * trace.transpose() * trace;
    sums.strain.noalias() += weight * strains.transpose() * strains;
  }
}

void add_mass(const Solid& solid, std::size_t e, const BasisRows& psi, MassKind kind,
              Integrals& sums) {
  const ElementNodes nodes = element_nodes(solid.mesh, e);
  MatrixXd moved(3 * nodes.count, psi.cols()), weighed = MatrixXd::Zero(moved.rows(), moved.cols());
  for (int a = 0; a < nodes.count; ++a)
    moved.middleRows<3>(3 * a) = psi.middleRows<3>(3 * Index{nodes[a]});
  for (int a = 0; a < nodes.count; ++a)
    for (int b = 0; b < nodes.count; ++b)
      if (const double mass = element_mass(solid, e, a, b, kind); mass != 0)
        weighed.middleRows<3>(3 * a) += mass * moved.middleRows<3>(3 * b);
  sums.mass.noalias() += moved.transpose() * weighed;
}

}  // namespace

std::vector<ModalForms> modal_forms(const Solid& solid, std::size_t count, const BasisRows& psi,
                                    MassKind kind) {
  const Index k = psi.cols();
  std::vector<Integrals> sums(solid.elasticities.size(), Integrals(k));
  std::vector<GradientField> fields(static_cast<std::size_t>(k));
  for (std::size_t e = 0; e < count; ++e) {
    add_strains(solid, e, psi, fields, sums[solid.material(e)]);
    add_mass(solid, e, psi, kind, sums[solid.material(e)]);
  }
  std::vector<ModalForms> forms(sums.size());
  for (std::size_t m = 0; m < sums.size(); ++m) {
    for (MatrixXd* sum : {&sums[m].trace, &sums[m].strain, &sums[m].energy, &sums[m].mass})
      sum_over_ranks(*sum);
    const Elasticity& material = solid.elasticities[m];
    forms[m].mass = std::move(sums[m].mass);
    if (!material.isotropic) {
      forms[m].stiffness = std::move(sums[m].energy);
      forms[m].poisson = MatrixXd::Zero(k, k);
      continue;
    }
    // nu, E, and the derivatives of Lame's constants with respect to nu.
    const double lambda = material.lambda, mu = material.mu;
    const double nu = 0.5 * lambda / (lambda + mu), young = 2.0 * mu * (1.0 + nu);
    const double by_nu_of_lambda =
        young * (1.0 + 2.0 * nu * nu) / std::pow((1.0 + nu) * (1.0 - 2.0 * nu), 2);
    const double by_nu_of_mu = -0.5 * young / std::pow(1.0 + nu, 2);
    forms[m].stiffness = lambda * sums[m].trace + 2.0 * mu * sums[m].strain;
    forms[m].poisson = by_nu_of_lambda * sums[m].trace + 2.0 * by_nu_of_mu * sums[m].strain;
  }
  return forms;
}

namespace {

// The diagonal, in clusters the eigenvalues of the block.
Eigen::VectorXd split_values(const MatrixXd& form, const std::vector<Cluster>& clusters) {
  Eigen::VectorXd values = form.diagonal();
  for (const Cluster& cluster : clusters) {
    const auto block = form.block(cluster.first, cluster.first, cluster.count, cluster.count);
    const MatrixXd symmetric = 0.5 * (block + block.transpose());
    values.segment(cluster.first, cluster.count) = eigenpairs(symmetric).values;
  }
  return values;
}

}  // namespace

ModeDerivatives mode_derivatives(const ModalForms& forms, const Eigen::VectorXd& squared,
                                 const std::vector<Cluster>& clusters) {
  MatrixXd by_density = forms.mass;
  for (Index j = 0; j < squared.size(); ++j)
    for (Index i = 0; i < squared.size(); ++i) by_density(i, j) *= -0.5 * (squared[i] + squared[j]);
  return {split_values(forms.stiffness, clusters), split_values(forms.poisson, clusters),
          split_values(by_density, clusters)};
}

}  // namespace tremolo
