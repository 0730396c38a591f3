// Derivatives of frequencies with respect to the materials, against differences of whole solutions.
#include <array>
#include <cmath>
#include <functional>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "precompute/ranks/halo.h"
#include "precompute/sensitivity/modal_forms.h"
#include "tests/support/assembled_body.h"
#include "tests/support/meshes/box_mesh.h"
#include "tests/support/meshes/symmetric_mesh.h"

namespace tremolo {
namespace {

using testing::box_mesh;
using testing::of_order;
using testing::vertices_on_plane;
using Body = testing::AssembledBody;
using Eigen::Index;
using Eigen::VectorXd;

using Eigensolver = Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd>;

struct Setting {
  TetMesh mesh;
  std::vector<VertexId> fixed;
  MaterialTable table;
  MassKind kind = MassKind::kConsistent;

  Body body(const MaterialTable& materials) const { return {mesh, materials, fixed, {}, kind}; }
  VectorXd squared(const MaterialTable& materials, Index count) const {
    const Body made = body(materials);
    const Eigensolver solver(made.dense(made.matrices.stiffness), made.dense(made.matrices.mass),
                             Eigen::EigenvaluesOnly);
    return solver.eigenvalues().head(count);
  }
};

// Of two orders of difference quotients the one without their common error of second order.
VectorXd difference(const std::function<VectorXd(double)>& values, double h) {
  const auto quotient = [&values](double step) {
    return VectorXd((values(step) - values(-step)) / (2.0 * step));
  };
  return (4.0 * quotient(0.5 * h) - quotient(h)) / 3.0;
}

enum class Constant { kStiffness, kPoisson, kDensity };

MaterialTable changed(MaterialTable table, std::size_t m, Constant constant, double by) {
  Material& material = table.materials[m].material;
  const double factor = std::exp(by);
  if (constant == Constant::kPoisson) material.poisson += by;
  if (constant == Constant::kDensity) material.density *= factor;
  if (constant != Constant::kStiffness) return table;
  material.young *= factor;
  if (!material.orthotropic) return table;
  material.orthotropic->young *= factor;
  material.orthotropic->shear *= factor;
  return table;
}

std::vector<ModeDerivatives> derivatives(const Setting& setting, Index count, VectorXd& squared,
                                         double gap = 1e-8) {
  const Body body = setting.body(setting.table);
  const Eigensolver solver(body.dense(body.matrices.stiffness), body.dense(body.matrices.mass));
  squared = solver.eigenvalues().head(count);
  const Columns vectors = solver.eigenvectors().leftCols(count);
  const BasisRows psi = expand_to_vertices(body.map, body.local, vectors);
  const std::vector<Cluster> clusters = find_clusters(squared, {gap});
  std::vector<ModeDerivatives> found;
  for (const ModalForms& forms :
       modal_forms(body.solid, body.mesh.tetrahedra.size(), psi, setting.kind))
    found.push_back(mode_derivatives(forms, squared, clusters));
  return found;
}

Material askew_wood() {
  Material wood;
  wood.density = 600;
  wood.orthotropic = OrthotropicElasticity{{11e9, 0.9e9, 0.5e9},
                                           {0.37, 0.47, 0.02},
                                           {0.75e9, 0.04e9, 0.7e9},
                                           *material_axes({1, 2, -0.5}, {0.3, -1, 2})};
  return wood;
}

Setting mixed(int order, MassKind kind) {
  Setting setting;
  const TetMesh linear = box_mesh({3, 1, 1}, {0.4, 0.2, 0.25});
  setting.mesh = of_order(linear, order);
  setting.fixed = vertices_on_plane(setting.mesh, 0, 0.0);
  setting.kind = kind;
  setting.table.materials = {{"wood", askew_wood()}, {"gel", Material{1e9, 0.4, 1000}}};
  for (std::size_t t = 0; t < linear.tetrahedra.size(); ++t)
    setting.table.of_tet.push_back(static_cast<std::int32_t>(t / 3 % 2));
  return setting;
}

TEST(Sensitivities, AreThoseOfSolutionsWithChangedMaterials) {
  constexpr Index kCount = 6;
  for (const auto& [order, kind] :
       {std::pair{1, MassKind::kConsistent}, {1, MassKind::kLumped}, {2, MassKind::kConsistent}}) {
    const Setting setting = mixed(order, kind);
    VectorXd squared;
    const std::vector<ModeDerivatives> found = derivatives(setting, kCount, squared);
    ASSERT_EQ(found.size(), 2U);
    for (const std::size_t m : {0U, 1U}) {
      const auto expect_near = [&](const VectorXd& got, Constant constant) {
        const VectorXd wanted = difference(
            [&](double by) {
              return setting.squared(changed(setting.table, m, constant, by), kCount);
            },
            2e-3);
        // The quotients' error of fourth order, 1e-11, and the solver's rounding over the step,
        // which is of the largest eigenvalue.
        EXPECT_LE(((got - wanted).array() / squared.array()).abs().maxCoeff(), 1e-7)
            << "order " << order << " material " << m;
      };
      expect_near(found[m].by_log_stiffness, Constant::kStiffness);
      expect_near(found[m].by_log_density, Constant::kDensity);
      if (m == 1) expect_near(found[m].by_poisson, Constant::kPoisson);
    }
    EXPECT_EQ(found[0].by_poisson, VectorXd::Zero(kCount));
    // omega^2 is proportional to a common factor of all stiffness, and to one over that of mass.
    const VectorXd stiffness = found[0].by_log_stiffness + found[1].by_log_stiffness;
    const VectorXd density = found[0].by_log_density + found[1].by_log_density;
    EXPECT_LE((stiffness - squared).cwiseQuotient(squared).norm(), 1e-9);
    EXPECT_LE((density + squared).cwiseQuotient(squared).norm(), 1e-9);
  }
}

// A square bar: bending in both directions has one frequency. The parts far above and below its
// axis alone made stiffer separate them: the values are the slopes of the two branches.
TEST(Sensitivities, OfEqualFrequenciesAreTheSlopesOfTheBranches) {
  Setting setting;
  setting.mesh = testing::symmetric_box({4, 2, 2}, {0.8, 0.1, 0.1});
  setting.fixed = vertices_on_plane(setting.mesh, 0, -0.4);
  setting.table.materials = {{"outer", Material{1e9, 0.3, 1000}},
                             {"rest", Material{1e9, 0.3, 1000}}};
  for (const Tetrahedron& tet : setting.mesh.tetrahedra) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const VertexId v : tet) sum += setting.mesh.vertices[v];
    setting.table.of_tet.push_back(std::abs(sum.z()) > std::abs(sum.y()) ? 0 : 1);
  }
  VectorXd squared;
  const std::vector<ModeDerivatives> found = derivatives(setting, 2, squared, 1e-7);
  ASSERT_NEAR(squared[1] / squared[0], 1.0, 1e-9);
  // From the two branches on either side: ascending values belong to slopes in this order above.
  constexpr double kStep = 1e-4;
  const VectorXd more = setting.squared(changed(setting.table, 0, Constant::kStiffness, kStep), 2);
  const VectorXd less = setting.squared(changed(setting.table, 0, Constant::kStiffness, -kStep), 2);
  const VectorXd slopes = Eigen::Vector2d(more[0] - less[1], more[1] - less[0]) / (2.0 * kStep);
  for (const Index k : {0, 1})
    EXPECT_NEAR(found[0].by_log_stiffness[k], slopes[k], 1e-6 * squared[0]) << k;
  EXPECT_GT(slopes[1] - slopes[0], 1e-3 * squared[0]);
}

}  // namespace
}  // namespace tremolo
