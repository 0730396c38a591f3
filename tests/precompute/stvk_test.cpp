// The elements against what defines them: invariance, derivatives, the closed form of one
// tetrahedron.
#include "precompute/fem/stvk.h"

#include <numbers>
#include <random>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "precompute/fem/assembly.h"
#include "tests/support/meshes/box_mesh.h"
#include "tests/support/random_field.h"

namespace tremolo {
namespace {

using testing::box_mesh;
using testing::random_field;

const Material kSoft{2e5, 0.4, 1000.0};

TetMesh sample_mesh(int order) {
  return testing::of_order(box_mesh({3, 2, 2}, {0.3, 0.2, 0.25}), order);
}

// Every case runs with both orders.
class Elements : public ::testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Orders, Elements, ::testing::Values(1, 2));

Field rigid_motion(const TetMesh& mesh, const Eigen::Matrix3d& rotation,
                   const Eigen::Vector3d& shift) {
  Field u(3 * static_cast<Eigen::Index>(mesh.vertices.size()));
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    u.segment<3>(3 * static_cast<Eigen::Index>(v)) =
        rotation * mesh.vertices[v] + shift - mesh.vertices[v];
  return u;
}

TEST_P(Elements, RigidTranslationAndRotationCostNoEnergy) {
  const TetMesh mesh = sample_mesh(GetParam());
  const Solid solid = make_solid(mesh, kSoft);
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(2.2, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
  const Field moved = rigid_motion(mesh, turn, {0.3, -5.0, 2.0});
  // Against the energy of a deformation as large as the body.
  const double scale = strain_energy(solid, random_field(mesh, 0.3, 1));
  EXPECT_LE(strain_energy(solid, moved), 1e-12 * scale);
  EXPECT_LE(internal_force(solid, moved).norm(),
            1e-12 * internal_force(solid, random_field(mesh, 0.3, 1)).norm());
}

TEST_P(Elements, EnergyDoesNotChangeUnderASuperposedRotation) {
  const TetMesh mesh = sample_mesh(GetParam());
  const Solid solid = make_solid(mesh, kSoft);
  const Field u = random_field(mesh, 0.1, 2);
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(1.1, Eigen::Vector3d(0.2, 1, 3).normalized()).toRotationMatrix();
  Field turned(u.size());
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    const Eigen::Vector3d x = mesh.vertices[v] + u.segment<3>(3 * static_cast<Eigen::Index>(v));
    turned.segment<3>(3 * static_cast<Eigen::Index>(v)) = turn * x - mesh.vertices[v];
  }
  const double energy = strain_energy(solid, u);
  EXPECT_NEAR(strain_energy(solid, turned), energy, 1e-13 * energy);  // rounding of the rotation
}

TEST_P(Elements, ForceIsTheGradientOfTheEnergy) {
  const TetMesh mesh = sample_mesh(GetParam());
  const Solid solid = make_solid(mesh, kSoft);
  const Field u = random_field(mesh, 0.05, 3);
  const Field direction = random_field(mesh, 0.05, 4);
  const double slope = internal_force(solid, u).dot(direction);
  double last = 2.0;
  for (double step : {1e-1, 1e-2, 1e-3}) {
    // The energy is a quartic: the central difference errs by exactly c * step^2.
    const double difference =
        (strain_energy(solid, u + step * direction) - strain_energy(solid, u - step * direction)) /
        (2 * step);
    const double error = std::abs(difference / slope - 1.0);
    EXPECT_LT(error, 0.02 * last);
    last = error;
  }
}

TEST_P(Elements, RestStiffnessIsTheDerivativeOfTheForce) {
  const TetMesh mesh = testing::of_order(box_mesh({1, 1, 1}, {0.1, 0.12, 0.09}), GetParam());
  const Solid solid = make_solid(mesh, kSoft);
  const Field u = random_field(mesh, 1e-3, 5);
  Field product = Field::Zero(u.size());
  for (std::size_t e = 0; e < mesh.tetrahedra.size(); ++e) {
    const auto stiffness = rest_stiffness(solid, e);
    const ElementNodes nodes = element_nodes(mesh, e);
    Eigen::VectorXd moved(3 * nodes.count);
    for (int a = 0; a < nodes.count; ++a)
      moved.segment<3>(3 * a) = u.segment<3>(3 * Eigen::Index{nodes[a]});
    const Eigen::VectorXd force = stiffness * moved;
    for (int a = 0; a < nodes.count; ++a)
      product.segment<3>(3 * Eigen::Index{nodes[a]}) += force.segment<3>(3 * a);
  }
  // The force is a cubic: f(u) - f(-u) = 2 K u + 2 (third order); Richardson takes the third away.
  const Field half = internal_force(solid, 0.5 * u) - internal_force(solid, -0.5 * u);
  const Field full = internal_force(solid, u) - internal_force(solid, -u);
  const Field derivative = (8.0 * half - full) / 6.0;
  EXPECT_LE((derivative - product).norm(), 1e-12 * product.norm());
}

TEST_P(Elements, SecondDerivativeIsThePolarFormOfTheForce) {
  const TetMesh mesh = sample_mesh(GetParam());
  const Solid solid = make_solid(mesh, kSoft);
  const Field a = random_field(mesh, 0.1, 6);
  const Field b = random_field(mesh, 0.2, 7);
  std::vector<int> elements, rows;
  for (std::size_t e = 0; e < mesh.tetrahedra.size(); ++e) elements.push_back(static_cast<int>(e));
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) rows.push_back(static_cast<int>(3 * v));
  Field direct = Field::Zero(a.size());
  add_second_derivative(solid, elements, a, b, rows, direct.data());
  const auto even = [&](const Field& v) -> Field {
    return internal_force(solid, v) + internal_force(solid, -v);
  };
  const Field polar = (even(a + b) - even(a - b)) / 4.0;
  EXPECT_LE((direct - polar).norm(), 1e-12 * polar.norm());
}

// The odd part of the force without its linear part, f(v) - f(-v) - (f(2v) - f(-2v)) / 2 = -2 C[v,
// v, v]; C[a, b, c] is the difference of such cubes over the signs of b and c.
TEST_P(Elements, ThirdDerivativeIsThePolarFormOfTheForce) {
  const TetMesh mesh = sample_mesh(GetParam());
  const Solid solid = make_solid(mesh, kSoft);
  const std::array<Field, 3> fields{random_field(mesh, 0.1, 6), random_field(mesh, 0.2, 7),
                                    random_field(mesh, 0.15, 8)};
  std::vector<int> elements, rows;
  for (std::size_t e = 0; e < mesh.tetrahedra.size(); ++e) elements.push_back(static_cast<int>(e));
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) rows.push_back(static_cast<int>(3 * v));
  Field direct = Field::Zero(fields[0].size());
  add_third_derivative(solid, elements, fields, rows, direct.data());
  const auto odd = [&](const Field& v) -> Field {
    return internal_force(solid, v) - internal_force(solid, -v);
  };
  const auto cube = [&](const Field& v) -> Field { return odd(2.0 * v) / 2.0 - odd(v); };
  const auto& [a, b, c] = fields;
  const Field polar =
      (cube(a + b + c) - cube(a + b - c) - cube(a - b + c) + cube(a - b - c)) / 24.0;
  EXPECT_LE((direct - polar).norm(), 1e-12 * polar.norm());
}

TEST_P(Elements, StretchedBarHasTheClosedFormEnergy) {
  // Uniform stretch s along x without lateral strain: E_xx = s + s^2/2.
  const TetMesh mesh = sample_mesh(GetParam());
  const Solid solid = make_solid(mesh, kSoft);
  const double stretch = 0.3;
  const Field u = rigid_motion(mesh, Eigen::Vector3d(1 + stretch, 1, 1).asDiagonal(), {0, 0, 0});
  const double strain = stretch + 0.5 * stretch * stretch;
  const double modulus = lame_lambda(kSoft) + 2 * lame_mu(kSoft);
  const double expected = 0.5 * modulus * strain * strain * (0.3 * 0.2 * 0.25);
  EXPECT_NEAR(strain_energy(solid, u), expected, 1e-13 * expected);
}

TEST_P(Elements, TheMassMatricesAddUpToTheMassOfTheBody) {
  const TetMesh mesh = sample_mesh(GetParam());
  const Solid solid = make_solid(mesh, kSoft);
  const double expected = 1000.0 * 0.3 * 0.2 * 0.25;
  EXPECT_NEAR(total_mass(solid), expected, 1e-13 * expected);
  for (MassKind kind : {MassKind::kConsistent, MassKind::kLumped}) {
    if (GetParam() == 2 && kind == MassKind::kLumped) continue;
    double sum = 0;
    const int count = nodes_of_order(GetParam());
    for (std::size_t e = 0; e < mesh.tetrahedra.size(); ++e)
      for (int a = 0; a < count; ++a)
        for (int b = 0; b < count; ++b) sum += element_mass(solid, e, a, b, kind);
    EXPECT_NEAR(sum, expected, 1e-13 * expected);
  }
}

}  // namespace
}  // namespace tremolo
