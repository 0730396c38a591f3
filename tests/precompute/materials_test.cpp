// Several materials and orthotropic ones against what defines them: invariance, derivatives, the
// isotropic special case, closed forms of bars.
#include <cmath>
#include <numbers>
#include <random>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "common/mesh/mesh_check.h"
#include "precompute/dense/dense_decompositions.h"
#include "precompute/fem/element_group.h"
#include "precompute/problem/point_mass.h"
#include "precompute/ranks/halo.h"
#include "precompute/reduction/basis.h"
#include "precompute/reduction/coefficients.h"
#include "precompute/reduction/derivatives.h"
#include "precompute/reduction/polynomial_check.h"
#include "tests/support/assembled_body.h"
#include "tests/support/meshes/box_mesh.h"
#include "tests/support/random_field.h"
#include "tests/support/solved_pencil.h"

namespace tremolo {
namespace {

using testing::box_mesh;
using testing::random_field;
using testing::vertices_on_plane;
using Body = testing::AssembledBody;

// Like a wood: nine constants of their own, axes askew to the mesh.
Material askew_wood() {
  Material wood;
  wood.density = 600;
  wood.orthotropic = OrthotropicElasticity{{11e9, 0.9e9, 0.5e9},
                                           {0.37, 0.47, 0.02},
                                           {0.75e9, 0.04e9, 0.7e9},
                                           *material_axes({1, 2, -0.5}, {0.3, -1, 2})};
  return wood;
}

// An isotropic material written as an orthotropic one.
Material as_orthotropic(const Material& material, const Eigen::Matrix3d& axes) {
  Material same = material;
  const double e = material.young, nu = material.poisson, g = lame_mu(material);
  same.orthotropic = OrthotropicElasticity{{e, e, e}, {nu, nu, nu}, {g, g, g}, axes};
  return same;
}

const Material kSteel{2e11, 0.3, 7800};

TetMesh sample_mesh() {
  return box_mesh({4, 2, 2}, {0.4, 0.2, 0.25});
}

// The material alternates from element to element.
MaterialTable mixed(const TetMesh& mesh) {
  MaterialTable table;
  table.materials = {{"wood", askew_wood()}, {"gel", Material{1e9, 0.45, 1000}}};
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t)
    table.of_tet.push_back(static_cast<std::int32_t>(t / 3 % 2));
  return table;
}

Eigen::Matrix3d some_turn() {
  return Eigen::AngleAxisd(1.1, Eigen::Vector3d(0.2, 1, 3).normalized()).toRotationMatrix();
}

TetMesh turned(const TetMesh& mesh, const Eigen::Matrix3d& turn) {
  TetMesh result = mesh;
  for (Eigen::Vector3d& x : result.vertices) x = turn * x;
  return result;
}

Field turned(const Field& u, const Eigen::Matrix3d& turn) {
  Field result(u.size());
  for (Eigen::Index v = 0; v < u.size(); v += 3) result.segment<3>(v) = turn * u.segment<3>(v);
  return result;
}

// Stiffness of all vertices.
Eigen::MatrixXd dense_stiffness(const Solid& solid) {
  const auto size = 3 * static_cast<Eigen::Index>(solid.mesh.vertices.size());
  Eigen::MatrixXd k = Eigen::MatrixXd::Zero(size, size);
  for (std::size_t e = 0; e < solid.elements.size(); ++e) {
    const auto element = rest_stiffness(solid, e);
    for (int a = 0; a < 4; ++a)
      for (int b = 0; b < 4; ++b)
        k.block<3, 3>(3 * Eigen::Index{solid.mesh.tetrahedra[e][a]},
                      3 * Eigen::Index{solid.mesh.tetrahedra[e][b]}) +=
            element.block<3, 3>(3 * a, 3 * b);
  }
  return k;
}

TEST(Materials, TheTensorOfAnOrthotropicMaterialInvertsItsCompliance) {
  const Material wood = askew_wood();
  const OrthotropicElasticity& o = *wood.orthotropic;
  const Elasticity elasticity = make_elasticity(wood);
  // Stress along one axis alone strains by 1/E along it and by -nu/E across; a shear by 1/2G.
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    Eigen::Matrix3d strain = Eigen::Matrix3d::Zero();
    strain(i, i) = 1.0 / o.young[i];
    strain(j, j) = -o.poisson[i] / o.young[i];
    strain(k, k) = -o.poisson[k] / o.young[k];  // nu_ik / E_i = nu_ki / E_k
    Eigen::Matrix3d s =
        o.axes.transpose() * stress(elasticity, o.axes * strain * o.axes.transpose()) * o.axes;
    s(i, i) -= 1.0;
    EXPECT_LE(s.cwiseAbs().maxCoeff(), 1e-12) << i;  // rounding, conditioned by E1/E3
    strain.setZero();
    strain(i, j) = strain(j, i) = 0.5 / o.shear[i];
    s = o.axes.transpose() * stress(elasticity, o.axes * strain * o.axes.transpose()) * o.axes;
    s(i, j) -= 1.0;
    s(j, i) -= 1.0;
    EXPECT_LE(s.cwiseAbs().maxCoeff(), 1e-12) << i;
  }
  EXPECT_LE((elasticity.root.transpose() * elasticity.root - elasticity.tensor).norm(),
            1e-14 * elasticity.tensor.norm());
}

TEST(Materials, AMirroredTripleOfAxesIsTheSameMaterial) {
  Material mirrored = askew_wood();
  mirrored.orthotropic->axes.col(1) *= -1.0;
  const Matrix6 tensor = make_elasticity(askew_wood()).tensor;
  EXPECT_LE((make_elasticity(mirrored).tensor - tensor).norm(), 1e-14 * tensor.norm());
}

TEST(Materials, WhatHasNoPositiveEnergyIsRefusedAndNamed) {
  const auto message = [](auto change) {
    Material material = askew_wood();
    change(*material.orthotropic);
    const Status status = check_material(material);
    return status ? std::string() : status.error().message;
  };
  EXPECT_EQ(message([](OrthotropicElasticity&) {}), "");
  EXPECT_NE(message([](auto& o) { o.young[1] = 0; }).find("E2 is 0"), std::string::npos);
  EXPECT_NE(message([](auto& o) { o.shear[2] = -1; }).find("G31 is -1"), std::string::npos);
  EXPECT_NE(message([](auto& o) { o.shear[0] = std::nan(""); }).find("G12"), std::string::npos);
  // sqrt(E2/E3) = 1.34.
  EXPECT_NE(message([](auto& o) { o.poisson[1] = 1.35; }).find("nu23 is 1.35"), std::string::npos);
  EXPECT_EQ(message([](auto& o) { o.poisson = {0, 1.34, 0}; }), "");
  EXPECT_NE(message([](auto& o) {
              o.poisson = {3.4, 0.2, 0.2};
            }).find("together"),
            std::string::npos);
  EXPECT_NE(message([](auto& o) { o.axes(0, 1) += 0.1; }).find("axes"), std::string::npos);
  EXPECT_FALSE(material_axes({1, 2, 3}, {-2, -4, -6}));
  EXPECT_FALSE(material_axes({0, 0, 0}, {1, 0, 0}));
}

// The check's three conditions are exactly that the tensor's root exists.
TEST(Materials, TheCheckAgreesWithTheEigenvaluesOfTheCompliance) {
  std::mt19937 engine(5);
  std::uniform_real_distribution<double> uniform(-1.2, 1.2);
  int good = 0;
  for (int n = 0; n < 300; ++n) {
    OrthotropicElasticity o = *askew_wood().orthotropic;
    for (int i = 0; i < 3; ++i) o.young[i] = std::exp(uniform(engine));
    for (int i = 0; i < 3; ++i) o.poisson[i] = uniform(engine);
    o.shear.setOnes();
    Eigen::Matrix3d compliance;
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3;
      compliance(i, i) = 1.0 / o.young[i];
      compliance(i, j) = compliance(j, i) = -o.poisson[i] / o.young[i];
    }
    const double least =
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(compliance).eigenvalues().minCoeff();
    Material material;
    material.orthotropic = o;
    EXPECT_EQ(static_cast<bool>(check_material(material)), least > 0) << least;
    good += least > 0;
  }
  EXPECT_GT(good, 50);
  EXPECT_LT(good, 250);
}

TEST(Materials, RigidMotionCostsNoEnergy) {
  const TetMesh mesh = sample_mesh();
  const Solid solid = make_solid(mesh, mixed(mesh));
  Field moved(3 * static_cast<Eigen::Index>(mesh.vertices.size()));
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    moved.segment<3>(3 * static_cast<Eigen::Index>(v)) =
        some_turn() * mesh.vertices[v] + Eigen::Vector3d(0.3, -5, 2) - mesh.vertices[v];
  // Against the energy and force of a deformation as large as the body.
  const Field deformed = random_field(mesh, 0.3, 1);
  EXPECT_LE(strain_energy(solid, moved), 1e-12 * strain_energy(solid, deformed));
  EXPECT_LE(internal_force(solid, moved).norm(), 1e-12 * internal_force(solid, deformed).norm());
}

TEST(Materials, TheForceIsTheGradientOfTheEnergy) {
  const TetMesh mesh = sample_mesh();
  const Solid solid = make_solid(mesh, mixed(mesh));
  const Field u = random_field(mesh, 0.05, 3);
  const Field direction = random_field(mesh, 0.05, 4);
  const double slope = internal_force(solid, u).dot(direction);
  // The energy is a quartic: central differences of two steps give its slope exactly.
  const auto difference = [&](double step) {
    return (strain_energy(solid, u + step * direction) -
            strain_energy(solid, u - step * direction)) /
           (2 * step);
  };
  const double exact = (4.0 * difference(0.1) - difference(0.2)) / 3.0;
  EXPECT_NEAR(exact, slope, 1e-12 * std::abs(slope));  // rounding of the differences
}

TEST(Materials, StiffnessAndSecondDerivativeAreThoseOfTheForce) {
  const TetMesh mesh = sample_mesh();
  const Solid solid = make_solid(mesh, mixed(mesh));
  const Field a = random_field(mesh, 0.1, 6);
  const Field b = random_field(mesh, 0.2, 7);
  const auto odd = [&](const Field& v) -> Field {
    return internal_force(solid, v) - internal_force(solid, -v);
  };
  const Field linear = (8.0 * odd(0.5 * a) - odd(a)) / 6.0;
  EXPECT_LE((dense_stiffness(solid) * a - linear).norm(), 1e-12 * linear.norm());
  const auto even = [&](const Field& v) -> Field {
    return internal_force(solid, v) + internal_force(solid, -v);
  };
  const Field polar = (even(a + b) - even(a - b)) / 4.0;
  std::vector<int> elements, rows;
  for (std::size_t e = 0; e < mesh.tetrahedra.size(); ++e) elements.push_back(static_cast<int>(e));
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) rows.push_back(static_cast<int>(3 * v));
  Field direct = Field::Zero(a.size());
  add_second_derivative(solid, elements, a, b, rows, direct.data());
  EXPECT_LE((direct - polar).norm(), 1e-12 * polar.norm());
}

TEST(Materials, AnOrthotropicMaterialWithIsotropicConstantsIsIsotropic) {
  const TetMesh mesh = sample_mesh();
  const Material rubber{1e6, 0.4, 1100};
  const Body plain(mesh, {{{"", rubber}}, {}}, vertices_on_plane(mesh, 0, 0.0));
  const Body same(mesh, {{{"", as_orthotropic(rubber, some_turn())}}, {}},
                  vertices_on_plane(mesh, 0, 0.0));
  ASSERT_TRUE(plain.solid.uniform());
  ASSERT_FALSE(same.solid.uniform());
  const Field u = random_field(mesh, 0.1, 8);
  const double energy = strain_energy(plain.solid, u);
  EXPECT_NEAR(strain_energy(same.solid, u), energy, 1e-12 * energy);
  const Field force = internal_force(plain.solid, u);
  EXPECT_LE((internal_force(same.solid, u) - force).norm(), 1e-12 * force.norm());
  const Eigen::MatrixXd k = plain.dense(plain.matrices.stiffness);
  EXPECT_LE((same.dense(same.matrices.stiffness) - k).norm(), 1e-12 * k.norm());

  // The loops over eight elements have a separate path for one isotropic material.
  Eigen::MatrixXd fields(u.size(), 3);
  for (int i = 0; i < 3; ++i) fields.col(i) = random_field(mesh, 0.1, 20 + i);
  const BasisRows rows = fields;
  const std::vector<ColumnPair> pairs{{0, 0}, {0, 1}, {2, 1}};
  const std::size_t stride = plain.local.dofs();
  const auto derivatives = [&](const Body& body) {
    Eigen::MatrixXd out = Eigen::MatrixXd::Zero(body.local.dofs(), 3);
    subtract_second_derivatives(body.solid, body.local.elements, rows, pairs,
                                body.local.row_of_vertex, out.data(), stride);
    return out;
  };
  const Eigen::MatrixXd h = derivatives(plain);
  EXPECT_LE((derivatives(same) - h).norm(), 1e-12 * h.norm());
  const std::size_t m = mesh.tetrahedra.size();
  const Coefficients c = coefficients_from_gram(strain_gram(plain.solid, rows, 0, m, 1), 3);
  const Coefficients d = coefficients_from_gram(strain_gram(same.solid, rows, 0, m, 1), 3);
  for (std::size_t i = 0; i < c.quartic.size(); ++i)
    EXPECT_NEAR(d.quartic[i], c.quartic[i], 1e-12 * std::abs(c.quartic.back()) + 1e-12 * energy);
}

TEST(Materials, TheLoopsOverEightElementsAgreeWithTheOneElementForm) {
  const TetMesh mesh = sample_mesh();  // 96 elements of two materials, changing within a group
  const Body body(mesh, mixed(mesh), vertices_on_plane(mesh, 0, 0.0));
  Eigen::MatrixXd fields(3 * static_cast<Eigen::Index>(mesh.vertices.size()), 2);
  for (int i = 0; i < 2; ++i) fields.col(i) = random_field(mesh, 0.1, 30 + i);
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(body.local.dofs(), 1);
  // A group that is not full as well.
  std::vector<int> elements(body.local.elements.begin(), body.local.elements.end() - 3);
  subtract_second_derivatives(body.solid, elements, fields, {{0, 1}}, body.local.row_of_vertex,
                              out.data(), static_cast<std::size_t>(out.rows()));
  Eigen::VectorXd direct = Eigen::VectorXd::Zero(out.rows());
  add_second_derivative(body.solid, elements, fields.col(0), fields.col(1),
                        body.local.row_of_vertex, direct.data());
  EXPECT_LE((out.col(0) + direct).norm(), 1e-13 * direct.norm());
}

TEST(Materials, TurningMeshAndAxesTogetherChangesNothing) {
  const TetMesh mesh = sample_mesh();
  const Eigen::Matrix3d turn = some_turn();
  const TetMesh other = turned(mesh, turn);
  MaterialTable table = mixed(mesh);
  const Solid solid = make_solid(mesh, table);
  table.materials[0].material.orthotropic->axes =
      turn * table.materials[0].material.orthotropic->axes;
  const Solid moved = make_solid(other, table);
  const Field u = random_field(mesh, 0.1, 9);
  const double energy = strain_energy(solid, u);
  EXPECT_NEAR(strain_energy(moved, turned(u, turn)), energy, 1e-12 * energy);
  const Field force = turned(internal_force(solid, u), turn);
  EXPECT_LE((internal_force(moved, turned(u, turn)) - force).norm(), 1e-12 * force.norm());
  // Turning the mesh alone is another body.
  const Solid skewed = make_solid(other, mixed(other));
  EXPECT_GT(std::abs(strain_energy(skewed, turned(u, turn)) / energy - 1.0), 1e-3);
}

TEST(Materials, ThePolynomialIsTheProjectedForceOfTheMixedMesh) {
  const TetMesh mesh = sample_mesh();
  const Body body(mesh, mixed(mesh), vertices_on_plane(mesh, 0, 0.0));
  testing::SolvedPencil solved(body.matrices);
  const Modes modes = solved.modes(4);
  const Eigen::MatrixXd psi = expand_to_vertices(body.map, body.local, modes.vectors);
  ModalDerivatives derivatives =
      modal_derivatives(body.solid, body.local, solved.pencil, *solved.solver, modes.vectors, psi);
  EXPECT_LE(derivatives.residual, 1e-9);  // condition of K times rounding
  const Basis basis = make_basis(body.matrices, std::move(derivatives.columns),
                                 modes.squared_frequencies, 0.05, {9, 1});
  const BasisRows rows = expand_to_vertices(body.map, body.local, basis.vectors);
  const Coefficients c =
      coefficients_from_gram(strain_gram(body.solid, rows, 0, body.solid.elements.size(), 2), 9);
  for (double reach : {1e-3, 0.3})
    EXPECT_LE(polynomial_error(body.solid, body.solid.elements.size(), rows, basis.lambda, c.cubic,
                               c.quartic, reach),
              1e-12);
  EXPECT_LE((c.quadratic - Eigen::MatrixXd(basis.lambda.asDiagonal())).cwiseAbs().maxCoeff(),
            1e-10 * basis.lambda.maxCoeff());
}

// Without lateral contraction the strain of a pulled bar is uniform in each half, which linear
// elements hold exactly: 1/k = L1/(E1 A) + L2/(E2 A).
TEST(Bar, OfTwoMaterialsIsTwoSpringsInSeries) {
  const TetMesh mesh = box_mesh({6, 2, 2}, {0.6, 0.1, 0.1});
  MaterialTable table;
  table.materials = {{"a", {3e6, 0.0, 1000}}, {"b", {7e8, 0.0, 2000}}};
  for (const Tetrahedron& tet : mesh.tetrahedra) {
    double x = 0;
    for (VertexId v : tet) x += 0.25 * mesh.vertices[v].x();
    table.of_tet.push_back(x < 0.2 ? 0 : 1);
  }
  const Body body(mesh, table, vertices_on_plane(mesh, 0, 0.0));
  // A traction on the far end: every triangle there gives a third of its force to each corner.
  Eigen::VectorXd load = Eigen::VectorXd::Zero(body.local.dofs());
  const double force = 12.0, area = 0.01;
  for (const Tetrahedron& tet : mesh.tetrahedra) {
    std::vector<VertexId> corners;
    for (VertexId v : tet)
      if (mesh.vertices[v].x() > 0.6 - 1e-9) corners.push_back(v);
    if (corners.size() != 3) continue;
    const Eigen::Vector3d normal =
        (mesh.vertices[corners[1]] - mesh.vertices[corners[0]])
            .cross(mesh.vertices[corners[2]] - mesh.vertices[corners[0]]);
    for (VertexId v : corners)
      load[body.local.row_of_vertex[v]] += force * 0.5 * normal.norm() / area / 3.0;
  }
  const Eigen::VectorXd u = body.dense(body.matrices.stiffness).ldlt().solve(load);
  const double compliance = 0.2 / (3e6 * area) + 0.4 / (7e8 * area);
  for (VertexId v : vertices_on_plane(mesh, 0, 0.6))
    EXPECT_NEAR(u[body.local.row_of_vertex[v]], force * compliance,
                1e-9 * force * compliance);  // condition of K times rounding
  EXPECT_NEAR(total_mass(body.solid), area * (0.2 * 1000 + 0.4 * 2000), 1e-12);
}

// f = sqrt(E1 / rho) / 4L of a bar that is fixed at one end, for any other constants.
TEST(Bar, AnOrthotropicBarsAxialFrequencyGoesWithTheRootOfE1) {
  const double length = 1.0;
  const TetMesh mesh = box_mesh({16, 1, 1}, {length, 0.05, 0.05});
  const auto axial = [&](const Eigen::Vector3d& young) {
    Material material;
    material.density = 500;
    material.orthotropic =
        OrthotropicElasticity{young, {0, 0, 0}, {4e8, 5e8, 6e8}, Eigen::Matrix3d::Identity()};
    const Body body(mesh, {{{"", material}}, {}}, vertices_on_plane(mesh, 0, 0.0));
    const Eigen::MatrixXd m = body.dense(body.matrices.mass);
    const EigenPairs pairs = eigenpairs(body.dense(body.matrices.stiffness), m);
    // The mode that takes the most of a push along the bar.
    Eigen::VectorXd push = Eigen::VectorXd::Zero(body.local.dofs());
    for (Eigen::Index i = 0; i < push.size(); i += 3) push[i] = 1.0;
    Eigen::Index mode = 0;
    (pairs.vectors.transpose() * m * push).cwiseAbs().maxCoeff(&mode);
    return std::sqrt(pairs.values[mode]) / (2 * std::numbers::pi);
  };
  const double f = axial({1e9, 3e8, 2e8});
  // Sixteen linear elements: too high by (pi/32)^2/24, and the corners of the mesh weigh unevenly.
  EXPECT_NEAR(f, std::sqrt(1e9 / 500) / (4 * length), 2e-3 * f);
  EXPECT_NEAR(axial({4e9, 3e8, 2e8}), 2 * f, 2e-3 * f);
  EXPECT_NEAR(axial({1e9, 6e8, 5e8}), f, 2e-3 * f);
}

Result<PointMass> read_point_mass(const std::string& text, const TetMesh& mesh,
                                  const std::vector<VertexId>& fixed) {
  const Result<PointMassRequest> request = parse_point_mass(text);
  if (!request) return request.error();
  return place_point_mass(*request, mesh, fixed);
}

TEST(PointMass, EntersBothMassMatricesAndTheTotal) {
  const TetMesh mesh = sample_mesh();
  const std::vector<VertexId> fixed = vertices_on_plane(mesh, 0, 0.0);
  const Result<PointMass> tip = read_point_mass("x>0.39=2.5", mesh, fixed);
  const Result<PointMass> edge = read_point_mass("x<=0.11=0.5", mesh, fixed);
  ASSERT_TRUE(tip && edge);
  EXPECT_EQ(tip->fixed, 0u);
  EXPECT_EQ(edge->fixed, fixed.size());
  const auto masses = mass_of_vertices({*tip, *edge}, mesh.vertices.size());
  const MaterialTable table = mixed(mesh);
  for (MassKind kind : {MassKind::kConsistent, MassKind::kLumped}) {
    const Body bare(mesh, table, fixed, {}, kind);
    const Body laden(mesh, table, fixed, masses, kind);
    EXPECT_NEAR(total_mass(laden.solid), total_mass(bare.solid) + 3.0, 1e-12);
    Eigen::MatrixXd difference = laden.dense(laden.matrices.mass) - bare.dense(bare.matrices.mass);
    for (std::size_t v = 0; v < masses.size(); ++v) {
      const int row = laden.local.row_of_vertex[v];
      if (row < 0) continue;
      for (int axis = 0; axis < 3; ++axis) difference(row + axis, row + axis) -= masses[v];
    }
    EXPECT_LE(difference.cwiseAbs().maxCoeff(), 1e-14);
    // The basis is orthonormal in this matrix.
    const Modes modes = testing::SolvedPencil(laden.matrices).modes(3);
    EXPECT_LE((modes.vectors.transpose() * laden.dense(laden.matrices.mass) * modes.vectors -
               Eigen::MatrixXd::Identity(3, 3))
                  .cwiseAbs()
                  .maxCoeff(),
              1e-10);
  }
}

// A body without mass of its own and a mass on one vertex is an oscillator of three springs.
TEST(PointMass, OnTheTipOfAMasslessCantileverIsAnOscillator) {
  const TetMesh mesh = box_mesh({8, 1, 1}, {0.8, 0.1, 0.1});
  const Material light{1e8, 0.3, 1e-6};
  const std::vector<VertexId> fixed = vertices_on_plane(mesh, 0, 0.0);
  const Result<PointMass> tip = read_point_mass("vertex:8=0.25", mesh, fixed);
  ASSERT_TRUE(tip);
  const Body body(mesh, {{{"", light}}, {}}, fixed, mass_of_vertices({*tip}, mesh.vertices.size()));
  const Eigen::MatrixXd k = body.dense(body.matrices.stiffness);
  const int row = body.local.row_of_vertex[8];
  Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(k.rows(), 3);
  unit.middleRows<3>(row).setIdentity();
  const Eigen::Matrix3d compliance = k.ldlt().solve(unit).middleRows<3>(row);
  const Eigen::Vector3d springs =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(compliance).eigenvalues().cwiseInverse();
  const Modes modes = testing::SolvedPencil(body.matrices).modes(3);
  // The body weighs 8e-9 kg, 3e-8 of the mass.
  for (int i = 0; i < 3; ++i)
    EXPECT_NEAR(modes.squared_frequencies[i], springs[2 - i] / 0.25, 1e-6 * springs[2 - i] / 0.25);
}

TEST(PointMass, TextsThatSayNoMassAreRefused) {
  const TetMesh mesh = sample_mesh();
  const auto kind = [&](const char* text) { return read_point_mass(text, mesh, {}).error().kind; };
  EXPECT_EQ(kind("x>0.1"), ErrorKind::kUsage);
  EXPECT_EQ(kind("=3"), ErrorKind::kUsage);
  EXPECT_EQ(kind("x>0.1=3 kg"), ErrorKind::kUsage);
  EXPECT_EQ(kind("x>=0.1"), ErrorKind::kUsage);  // `x>` is no selector
  EXPECT_EQ(kind("x>0.1=0"), ErrorKind::kContent);
  EXPECT_EQ(kind("x>0.1=-1"), ErrorKind::kContent);
  EXPECT_EQ(kind("x>0.1=nan"), ErrorKind::kContent);
  EXPECT_EQ(kind("x>9=1"), ErrorKind::kContent);
  EXPECT_EQ(kind("none=1"), ErrorKind::kContent);
  const Result<PointMass> both = read_point_mass("x>=0.1=3e-1", mesh, {});
  ASSERT_TRUE(both) << both.error().message;
  EXPECT_EQ(both->selector, "x>=0.1");
  EXPECT_EQ(both->kilograms, 0.3);
}

}  // namespace
}  // namespace tremolo
