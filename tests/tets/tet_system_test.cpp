// A mesh of corotated tetrahedra whose edges are of both degrees: forces, energy and matrices.
#include "runtime/bodies/tets/elements/tet_system.h"

#include <gtest/gtest.h>

#include "tests/support/tet_bodies.h"

namespace tremolo {
namespace {

using namespace testing;

struct MixedCase {
  TetModelPointer model = tet_bar({3, 1, 2}, {0.3, 0.1, 0.2}, false);
  TetRandom random{1};
  TetSystem system{model, RotationLaw::kLeastEnergy};
  Eigen::VectorXd x;

  explicit MixedCase(double amplitude = 0.01) {
    system.set_degrees(random_degrees(random, model->edges()));
    x = model->rest() + random_state(random, model->rest().size(), amplitude);
    system.follow_ends(x);
  }
  Eigen::VectorXd free_direction() {
    Eigen::VectorXd d = random_state(random, x.size(), 1.0);
    system.follow_ends(d);
    return d;
  }
  double energy_at(const Eigen::VectorXd& y) {
    system.evaluate(y);
    return system.energy();
  }
  Eigen::VectorXd force_at(const Eigen::VectorXd& y) {
    system.evaluate(y);
    Eigen::VectorXd f = Eigen::VectorXd::Zero(y.size());
    system.add_force(f);
    system.fold(f);
    return f;
  }
};

TEST(TetSystem, FoldedForceIsTheGradientInTheFreeControlPoints) {
  MixedCase c;
  const Eigen::VectorXd force = c.force_at(c.x);
  for (int trial = 0; trial < 5; ++trial) {
    const Eigen::VectorXd d = c.free_direction();
    const double h = 1e-4;  // 1e-3 of an edge, where differences of fourth order serve
    const double slope = (8.0 * (c.energy_at(c.x + h * d) - c.energy_at(c.x - h * d)) -
                          (c.energy_at(c.x + 2.0 * h * d) - c.energy_at(c.x - 2.0 * h * d))) /
                         (12.0 * h);
    EXPECT_NEAR(slope, -force.dot(d), 1e-7 * force.norm() * d.norm());
  }
}

TEST(TetSystem, ForcesOfAFreeMeshHaveNeitherSumNorTorque) {
  MixedCase c(0.02);
  const Eigen::VectorXd f = c.force_at(c.x);
  Eigen::VectorXd damping = Eigen::VectorXd::Zero(f.size());
  c.system.add_damping_force(c.free_direction(), 1.0, damping);
  c.system.fold(damping);
  for (const Eigen::VectorXd& force : {f, damping}) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero(), torque = Eigen::Vector3d::Zero();
    for (Eigen::Index i = 0; i < force.size(); i += 3) {
      sum += force.segment<3>(i);
      torque += Eigen::Vector3d(c.x.segment<3>(i)).cross(Eigen::Vector3d(force.segment<3>(i)));
    }
    EXPECT_LE(sum.norm(), 1e-12 * force.norm());
    EXPECT_LE(torque.norm(), 1e-12 * force.norm());
  }
}

TEST(TetSystem, MatrixIsMassAndTheForcesDerivativeAmongFreeControlPoints) {
  MixedCase c;
  BlockMatrix matrix(c.model->pattern());
  const Eigen::VectorXd d = c.free_direction();
  Eigen::VectorXd free = d;  // entries of condensed control points do not enter
  for (std::size_t i = 0; i < c.model->nodes(); ++i)
    if (c.system.active()[i] == 0) free.segment<3>(3 * i).setZero();
  c.system.evaluate(c.x);
  c.system.assemble({7.0, {1.0, 0.0, TangentKind::kExact}}, matrix);
  Eigen::VectorXd product(d.size());
  matrix.multiply(free, product);
  Eigen::VectorXd expected = d;
  c.system.mass_times_folded(expected);
  expected *= 7.0;
  const double h = 1e-4;
  expected -= (8.0 * (c.force_at(c.x + h * d) - c.force_at(c.x - h * d)) -
               (c.force_at(c.x + 2.0 * h * d) - c.force_at(c.x - 2.0 * h * d))) /
              (12.0 * h);
  // The differences' error.
  EXPECT_LE((product - expected).norm(), 1e-6 * expected.norm());
}

TEST(TetSystem, AllEdgesLinearIsTheLinearMesh) {
  MixedCase c;
  c.system.set_degrees(std::vector<std::uint8_t>(c.model->edges(), 1));
  c.system.follow_ends(c.x);
  const double folded = c.energy_at(c.x);
  // The same, computed as straight quadratic elements: one edge far away is set to quadratic and
  // not moved.
  double plain = 0.0;
  for (const TetModelElement& element : c.model->elements()) {
    NodeVectors local(3, kMostNodes);
    for (int i = 0; i < kMostNodes; ++i)
      local.col(i) = c.x.segment<3>(3 * Eigen::Index{element.nodes[i]});
    plain += tet_energy(element.element, tet_shape(element.element, c.model->elasticity(element),
                                                   RotationLaw::kLeastEnergy, local));
  }
  EXPECT_NEAR(folded, plain, 1e-12 * plain);
}

TEST(TetSystem, PatchOfConstantStrainPullsOnTheBoundaryAlone) {
  // A mesh of odd shapes in one homogeneous deformation: inside no control point is pulled.
  TetRandom random(3);
  TetMesh mesh = testing::box_mesh({3, 3, 3}, {1, 1, 1});
  std::vector<bool> inside;
  for (Eigen::Vector3d& x : mesh.vertices) {
    inside.push_back(x.minCoeff() > 0.1 && x.maxCoeff() < 0.9);
    if (inside.back()) x += random.vector(0.06);
  }
  const auto model = TetModel::create(mesh, {{{"gel", testing::kTetGel}}, {}}, {});
  ASSERT_TRUE(model);
  for (const int degree : {1, 2}) {
    TetSystem system(*model, RotationLaw::kLeastEnergy);
    system.set_degrees(
        std::vector<std::uint8_t>((*model)->edges(), static_cast<std::uint8_t>(degree)));
    Eigen::Matrix3d map = random.rotation();
    map += 0.1 * Eigen::Matrix3d::Identity();
    Eigen::VectorXd x = (*model)->rest();
    for (Eigen::Index i = 0; i < x.size(); i += 3) x.segment<3>(i) = map * x.segment<3>(i);
    system.evaluate(x);
    Eigen::VectorXd f = Eigen::VectorXd::Zero(x.size());
    system.add_force(f);
    system.fold(f);
    double largest = 0.0;
    for (std::size_t v = 0; v < inside.size(); ++v)
      if (inside[v]) largest = std::max(largest, f.segment<3>(3 * v).norm());
    EXPECT_LE(largest, 1e-12 * f.norm());
  }
}

TEST(TetSystem, WrongMeshesAreRefusedByName) {
  TetMesh flat = testing::box_mesh({1, 1, 1}, {1, 1, 1});
  for (Eigen::Vector3d& x : flat.vertices) x.z() = 0.0;
  const auto refused = TetModel::create(flat, {{{"gel", testing::kTetGel}}, {}}, {});
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("tetrahedron 0 has a volume"), std::string::npos);
  TetMesh turned = testing::box_mesh({1, 1, 1}, {1, 1, 1});
  std::swap(turned.tetrahedra[2][0], turned.tetrahedra[2][1]);
  const auto inside_out = TetModel::create(turned, {{{"gel", testing::kTetGel}}, {}}, {});
  ASSERT_FALSE(inside_out);
  EXPECT_NE(inside_out.error().message.find("tetrahedron 2 has a volume of -"), std::string::npos);
  const auto far = TetModel::create(testing::box_mesh({1, 1, 1}, {1, 1, 1}),
                                    {{{"gel", testing::kTetGel}}, {}}, std::vector<VertexId>{99});
  ASSERT_FALSE(far);
  EXPECT_NE(far.error().message.find("held vertex 99"), std::string::npos);
}

}  // namespace
}  // namespace tremolo
