// Quadratic elements against what is known independently of how they are computed: products of
// Bernstein polynomials by their closed form, nodal quadratics, linear elements inside them, fields
// that are quadratic in X.
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "common/energy.h"
#include "common/mesh/edge_points.h"
#include "common/mesh/mesh_check.h"
#include "common/packed_index.h"
#include "precompute/fem/assembly.h"
#include "precompute/fem/control_values.h"
#include "precompute/fem/element_group.h"
#include "precompute/reduction/coefficients.h"
#include "tests/support/meshes/box_mesh.h"

namespace tremolo {
namespace {

using testing::box_mesh;

const Material kQuadraticMaterial{2e5, 0.4, 1000.0};

std::mt19937& engine() {
  static std::mt19937 random(7);
  return random;
}

double uniform(double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(engine());
}

Field random_field(const TetMesh& mesh, double size) {
  Field u(3 * static_cast<Eigen::Index>(mesh.vertices.size()));
  for (double& value : u) value = uniform(-size, size);
  return u;
}

// A box whose inner vertices are shifted, so that no two elements are equal.
TetMesh uneven_mesh(const std::array<int, 3>& cells = {2, 2, 2}) {
  const Eigen::Vector3d size(0.3, 0.2, 0.25);
  TetMesh mesh = box_mesh(cells, size);
  for (Eigen::Vector3d& x : mesh.vertices)
    for (int axis = 0; axis < 3; ++axis)
      if (x[axis] > 1e-9 && x[axis] < size[axis] - 1e-9)
        x[axis] += uniform(-0.1, 0.1) * size[axis] / cells[axis];
  return mesh;
}

TetMesh quadratic(TetMesh mesh) {
  EXPECT_TRUE(add_edge_points(mesh));
  return mesh;
}

using Exponents = std::array<int, 4>;

double factorial(int n) {
  return n < 2 ? 1.0 : n * factorial(n - 1);
}

// Integral of l^p over a tetrahedron over its volume (Lyness).
double monomial(const Exponents& p) {
  double product = 6.0;
  int degree = 3;
  for (const int k : p) product *= factorial(k), degree += k;
  return product / factorial(degree);
}

std::vector<Exponents> all_exponents(int degree) {
  std::vector<Exponents> all;
  for (int i = 0; i <= degree; ++i)
    for (int j = 0; i + j <= degree; ++j)
      for (int k = 0; i + j + k <= degree; ++k) all.push_back({i, j, k, degree - i - j - k});
  return all;
}

TEST(QuadraticElement, SamplePointsIntegrateEveryMonomialOfTheirDegree) {
  for (const int degree : {2, 3, 4}) {
    const auto points = sample_points(2, degree);
    for (int d = 0; d <= degree; ++d)
      for (const Exponents& p : all_exponents(d)) {
        double sum = 0;
        for (const SamplePoint& point : points) {
          double value = point.share;
          for (std::size_t a = 0; a < 4; ++a) value *= std::pow(point.lambda[a], p[a]);
          sum += value;
        }
        EXPECT_NEAR(sum, monomial(p), 1e-16) << degree << ": " << p[0] << p[1] << p[2] << p[3];
      }
  }
}

// The energy from the ten Bernstein coefficients of the strain and the closed form of the
// polynomials' products: no sample points.
double energy_from_products(const Solid& solid, const FieldRef& u) {
  std::vector<Exponents> degree_two;
  for (const Exponents& p : all_exponents(2)) degree_two.push_back(p);
  const auto product = [](const Exponents& p, const Exponents& q) {
    double share = 1.0 / 210.0;
    for (std::size_t s = 0; s < 4; ++s)
      share *= factorial(p[s] + q[s]) / (factorial(p[s]) * factorial(q[s]));
    return share;
  };
  double energy = 0;
  for (std::size_t e = 0; e < solid.elements.size(); ++e) {
    const GradientField g = displacement_gradients(solid, e, u);
    std::vector<Eigen::Matrix3d> strain;
    for (const Exponents& p : degree_two) {
      std::vector<int> at;
      for (int a = 0; a < 4; ++a)
        for (int k = 0; k < p[a]; ++k) at.push_back(a);
      const Eigen::Matrix3d &x = g.at[at[0]], &y = g.at[at[1]];
      const Eigen::Matrix3d linear = 0.5 * (x + y);
      const Eigen::Matrix3d square = 0.5 * (x.transpose() * y + y.transpose() * x);
      strain.push_back(0.5 * (linear + linear.transpose() + square));
    }
    for (std::size_t i = 0; i < strain.size(); ++i)
      for (std::size_t j = 0; j < strain.size(); ++j)
        energy += 0.5 * solid.elements[e].volume * product(degree_two[i], degree_two[j]) *
                  stress(solid.elasticity(e), strain[i]).cwiseProduct(strain[j]).sum();
  }
  return energy;
}

TEST(QuadraticElement, EnergyIsTheProductOfBernsteinPolynomials) {
  const TetMesh mesh = quadratic(uneven_mesh());
  const Solid solid = make_solid(mesh, kQuadraticMaterial);
  const Field u = random_field(mesh, 0.05);
  const double expected = energy_from_products(solid, u);
  EXPECT_NEAR(strain_energy(solid, u), expected, 1e-13 * expected);
}

// Degree elevation of a linear field: c_ab = (c_a + c_b) / 2.
Field elevated(const TetMesh& mesh, const Field& linear) {
  Field u = Field::Zero(3 * static_cast<Eigen::Index>(mesh.vertices.size()));
  u.head(linear.size()) = linear;
  for (const MeshEdge& edge : mesh.edges)
    u.segment<3>(3 * Eigen::Index{edge.point}) =
        0.5 * (u.segment<3>(3 * Eigen::Index{edge.a}) + u.segment<3>(3 * Eigen::Index{edge.b}));
  return u;
}

Field transposed_elevation(const TetMesh& mesh, Field force, Eigen::Index size) {
  for (const MeshEdge& edge : mesh.edges)
    for (const VertexId end : {edge.a, edge.b})
      force.segment<3>(3 * Eigen::Index{end}) +=
          0.5 * force.segment<3>(3 * Eigen::Index{edge.point});
  return force.head(size);
}

TEST(QuadraticElement, HoldsTheLinearOneInItself) {
  const TetMesh coarse = uneven_mesh(), mesh = quadratic(coarse);
  const Solid linear = make_solid(coarse, kQuadraticMaterial),
              solid = make_solid(mesh, kQuadraticMaterial);
  const Field u = random_field(coarse, 0.05), up = elevated(mesh, u);
  const double energy = strain_energy(linear, u);
  EXPECT_NEAR(strain_energy(solid, up), energy, 1e-13 * energy);
  const Field force = internal_force(linear, u);
  EXPECT_LE((transposed_elevation(mesh, internal_force(solid, up), u.size()) - force).norm(),
            1e-13 * force.norm());
  // Element matrices: E^T K2 E = K1, E^T M2 E = M1.
  Eigen::MatrixXd raise = Eigen::MatrixXd::Zero(10, 4);
  raise.topRows<4>().setIdentity();
  for (int e = 0; e < 6; ++e)
    for (const int a : kTetEdges[e]) raise(4 + e, a) = 0.5;
  Eigen::MatrixXd raise3 = Eigen::MatrixXd::Zero(30, 12);
  for (int i = 0; i < 10; ++i)
    for (int a = 0; a < 4; ++a)
      raise3.block<3, 3>(3 * i, 3 * a) = raise(i, a) * Eigen::Matrix3d::Identity();
  const Eigen::MatrixXd k1 = rest_stiffness(linear, 3), k2 = rest_stiffness(solid, 3);
  EXPECT_LE((raise3.transpose() * k2 * raise3 - k1).norm(), 1e-13 * k1.norm());
  Eigen::MatrixXd m1(4, 4), m2(10, 10);
  for (int i = 0; i < 10; ++i)
    for (int j = 0; j < 10; ++j) {
      m2(i, j) = element_mass(solid, 3, i, j, MassKind::kConsistent);
      if (i < 4 && j < 4) m1(i, j) = element_mass(linear, 3, i, j, MassKind::kConsistent);
    }
  EXPECT_LE((raise.transpose() * m2 * raise - m1).norm(), 1e-13 * m1.norm());
}

// Gradients of the nodal polynomials l_a (2 l_a - 1) and 4 l_a l_b at a point, from those of l.
std::vector<Eigen::Vector3d> nodal_gradients(const Eigen::Matrix<double, 3, 4>& of_lambda,
                                             const std::array<double, 4>& lambda) {
  std::vector<Eigen::Vector3d> gradients;
  for (int a = 0; a < 4; ++a) gradients.emplace_back((4.0 * lambda[a] - 1.0) * of_lambda.col(a));
  for (const auto& [a, b] : kTetEdges)
    gradients.emplace_back(4.0 * (lambda[a] * of_lambda.col(b) + lambda[b] * of_lambda.col(a)));
  return gradients;
}

// Stiffness of one element of nodal quadratics, by the rule of four points that is exact for
// products of linear gradients.
Eigen::MatrixXd nodal_stiffness(const TetMesh& mesh, const Solid& solid) {
  Eigen::Matrix4d places;  // rows: 1, x, y, z of the corners
  for (int a = 0; a < 4; ++a) places.col(a) << 1.0, mesh.vertices[mesh.tetrahedra[0][a]];
  const Eigen::Matrix4d inverse = places.inverse();
  const Eigen::Matrix<double, 3, 4> of_lambda = inverse.rightCols<3>().transpose();
  const double lame = lame_lambda(kQuadraticMaterial), mu = lame_mu(kQuadraticMaterial);
  const double near = (5.0 + 3.0 * std::sqrt(5.0)) / 20.0, far = (5.0 - std::sqrt(5.0)) / 20.0;
  Eigen::MatrixXd stiffness = Eigen::MatrixXd::Zero(30, 30);
  for (std::size_t point = 0; point < 4; ++point) {
    std::array<double, 4> lambda{far, far, far, far};
    lambda[point] = near;
    const std::vector<Eigen::Vector3d> g = nodal_gradients(of_lambda, lambda);
    for (int i = 0; i < 10; ++i)
      for (int j = 0; j < 10; ++j)
        stiffness.block<3, 3>(3 * i, 3 * j) +=
            0.25 * solid.elements[0].volume *
            (lame * g[i] * g[j].transpose() + mu * g[j] * g[i].transpose() +
             mu * g[i].dot(g[j]) * Eigen::Matrix3d::Identity());
  }
  return stiffness;
}

TEST(QuadraticElement, AgreesWithNodalQuadratics) {
  // Nodal polynomials: l_a (2 l_a - 1) and 4 l_a l_b; nodal values are T times control values.
  const TetMesh mesh = quadratic(uneven_mesh({1, 1, 1}));
  const Solid solid = make_solid(mesh, kQuadraticMaterial);
  Eigen::MatrixXd nodal_of_control = Eigen::MatrixXd::Identity(10, 10);
  for (int e = 0; e < 6; ++e) {
    nodal_of_control(4 + e, 4 + e) = 0.5;
    for (const int a : kTetEdges[e]) nodal_of_control(4 + e, a) = 0.25;
  }
  // Mass of nodal quadratics from monomials.
  const auto nodal_terms = [](int node) {
    std::vector<std::pair<double, Exponents>> terms;
    if (node < 4) {
      Exponents square{}, line{};
      square[node] = 2;
      line[node] = 1;
      return std::vector<std::pair<double, Exponents>>{{2.0, square}, {-1.0, line}};
    }
    Exponents both{};
    for (const int a : kTetEdges[node - 4]) both[a] = 1;
    terms.push_back({4.0, both});
    return terms;
  };
  Eigen::MatrixXd nodal(10, 10), control(10, 10);
  const double mass = solid.density(0) * solid.elements[0].volume;
  for (int i = 0; i < 10; ++i)
    for (int j = 0; j < 10; ++j) {
      double sum = 0;
      for (const auto& [x, p] : nodal_terms(i))
        for (const auto& [y, q] : nodal_terms(j))
          sum += x * y * monomial({p[0] + q[0], p[1] + q[1], p[2] + q[2], p[3] + q[3]});
      nodal(i, j) = mass * sum;
      control(i, j) = element_mass(solid, 0, i, j, MassKind::kConsistent);
    }
  EXPECT_LE((nodal_of_control.transpose() * nodal * nodal_of_control - control).norm(),
            1e-13 * control.norm());
  Eigen::MatrixXd nodal_of_control3 = Eigen::MatrixXd::Zero(30, 30);
  for (int i = 0; i < 10; ++i)
    for (int j = 0; j < 10; ++j)
      nodal_of_control3.block<3, 3>(3 * i, 3 * j) =
          nodal_of_control(i, j) * Eigen::Matrix3d::Identity();
  const Eigen::MatrixXd stiffness = rest_stiffness(solid, 0);
  EXPECT_LE(
      (nodal_of_control3.transpose() * nodal_stiffness(mesh, solid) * nodal_of_control3 - stiffness)
          .norm(),
      1e-13 * stiffness.norm());
}

TEST(QuadraticElement, AFieldQuadraticInXIsExact) {
  // u = X^T A X component by component: its control values are polar forms; the energy of E is
  // integrated by many points of a rule of degree 4 on the refined mesh, which must not change it.
  const TetMesh coarse = uneven_mesh();
  std::array<Eigen::Matrix3d, 3> form;
  for (Eigen::Matrix3d& f : form) {
    for (double& x : f.reshaped()) x = uniform(-1, 1);
    f = (f + f.transpose()).eval();
  }
  const auto field_on = [&form](const TetMesh& mesh) {
    Field u(3 * static_cast<Eigen::Index>(mesh.vertices.size()));
    const auto polar = [&](VertexId a, VertexId b) {
      Eigen::Vector3d value;
      for (int x = 0; x < 3; ++x) value[x] = mesh.vertices[a].dot(form[x] * mesh.vertices[b]);
      return value;
    };
    for (VertexId v = 0; v < static_cast<VertexId>(mesh.vertices.size()); ++v)
      u.segment<3>(3 * Eigen::Index{v}) = polar(v, v);
    for (const MeshEdge& edge : mesh.edges)
      u.segment<3>(3 * Eigen::Index{edge.point}) = polar(edge.a, edge.b);
    return u;
  };
  const TetMesh one = quadratic(box_mesh({1, 1, 1}, {0.3, 0.2, 0.25}));
  const TetMesh many = quadratic(uneven_mesh({3, 2, 4}));
  const Solid of_one = make_solid(one, kQuadraticMaterial),
              of_many = make_solid(many, kQuadraticMaterial);
  const double energy = strain_energy(of_one, field_on(one));
  EXPECT_NEAR(strain_energy(of_many, field_on(many)), energy, 1e-12 * energy);
  // In the middle of an edge the displacement is the field itself.
  BasisRows rows = field_on(many);
  to_displacements(many, rows);
  for (const MeshEdge& edge : many.edges) {
    const Eigen::Vector3d& x = many.vertices[edge.point];
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(rows(3 * edge.point + axis, 0), x.dot(form[axis] * x), 1e-14);
  }
  BasisRows back = rows;
  to_control_values(many, back);
  EXPECT_LE((back - BasisRows(field_on(many))).norm(), 1e-14 * back.norm());
}

// Returns a mesh with columns of fields, of one material or several and orthotropic ones.
struct Fields {
  TetMesh mesh;
  Solid solid;
  BasisRows rows;
};

MaterialTable several_materials(std::size_t tetrahedra) {
  Material wood{1e6, 0.3, 700.0};
  wood.orthotropic = OrthotropicElasticity{};
  wood.orthotropic->young = {9e6, 1e6, 5e5};
  wood.orthotropic->poisson = {0.3, 0.35, 0.02};
  wood.orthotropic->shear = {4e5, 5e5, 6e5};
  MaterialTable table{{{"a", kQuadraticMaterial}, {"b", wood}, {"c", {5e6, 0.45, 1200.0}}}, {}};
  for (std::size_t t = 0; t < tetrahedra; ++t)
    table.of_tet.push_back(static_cast<std::int32_t>(t % 3));
  return table;
}

class QuadraticLoops : public ::testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Materials, QuadraticLoops, ::testing::Values(false, true));

TEST_P(QuadraticLoops, OfEightElementsAreThoseOfOne) {
  const TetMesh mesh = quadratic(uneven_mesh({2, 3, 1}));
  const Solid solid = GetParam() ? make_solid(mesh, several_materials(mesh.tetrahedra.size()))
                                 : make_solid(mesh, kQuadraticMaterial);
  const Eigen::Index size = 3 * static_cast<Eigen::Index>(mesh.vertices.size());
  BasisRows fields(size, 3);
  for (double& x : fields.reshaped()) x = uniform(-0.1, 0.1);
  std::vector<int> elements, rows;
  for (std::size_t e = 0; e + 1 < mesh.tetrahedra.size(); ++e)
    elements.push_back(static_cast<int>(e));
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    rows.push_back(v % 5 == 0 ? -1 : static_cast<int>(3 * v));
  const std::vector<ColumnPair> pairs = {{0, 0}, {0, 1}, {1, 2}};
  Eigen::MatrixXd together = Eigen::MatrixXd::Zero(size, 3);
  subtract_second_derivatives(solid, elements, fields, pairs, rows, together.data(), size);
  for (int p = 0; p < 3; ++p) {
    Field alone = Field::Zero(size);
    add_second_derivative(solid, elements, fields.col(pairs[p].i), fields.col(pairs[p].j), rows,
                          alone.data());
    EXPECT_LE((together.col(p) + alone).norm(), 1e-13 * alone.norm());
  }
}

TEST_P(QuadraticLoops, ThePolynomialIsTheEnergyAndTheForceOfTheMesh) {
  const TetMesh mesh = quadratic(uneven_mesh({2, 1, 3}));
  const Solid solid = GetParam() ? make_solid(mesh, several_materials(mesh.tetrahedra.size()))
                                 : make_solid(mesh, kQuadraticMaterial);
  const int r = 4;
  BasisRows basis(3 * static_cast<Eigen::Index>(mesh.vertices.size()), r);
  for (double& x : basis.reshaped()) x = uniform(-1, 1);
  const Coefficients c =
      coefficients_from_gram(strain_gram(solid, basis, 0, solid.elements.size(), 2), r);
  for (const double reach : {1e-3, 0.05, 1.0}) {
    Eigen::VectorXd q(r);
    for (double& x : q) x = uniform(-reach, reach);
    const Field u = basis * q;
    // The quadratic part of these columns is not diagonal.
    const EnergyAndForce rest = reduced_energy(Eigen::VectorXd::Zero(r), c.cubic, c.quartic, q);
    const Eigen::VectorXd force = c.quadratic * q + rest.force;
    const Eigen::VectorXd expected = basis.transpose() * internal_force(solid, u);
    EXPECT_LE((force - expected).norm(), 1e-12 * expected.norm()) << reach;
    const double energy = energy_from_products(solid, u);
    EXPECT_NEAR(0.5 * q.dot(c.quadratic * q) + rest.energy, energy, 1e-12 * energy) << reach;
  }
}

TEST_P(QuadraticLoops, TheAssembledStiffnessIsTheQuadraticPartOfTheEnergy) {
  const TetMesh mesh = quadratic(uneven_mesh({2, 1, 2}));
  const Solid solid = GetParam() ? make_solid(mesh, several_materials(mesh.tetrahedra.size()))
                                 : make_solid(mesh, kQuadraticMaterial);
  BasisRows basis(3 * static_cast<Eigen::Index>(mesh.vertices.size()), 3);
  for (double& x : basis.reshaped()) x = uniform(-1, 1);
  const Eigen::MatrixXd gram = strain_gram(solid, basis, 0, solid.elements.size(), 1);
  const Eigen::Matrix3d expected = gram.topLeftCorner(3, 3).selfadjointView<Eigen::Lower>();
  Eigen::Matrix3d found = Eigen::Matrix3d::Zero();
  for (std::size_t e = 0; e < solid.elements.size(); ++e) {
    const ElementNodes nodes = element_nodes(mesh, e);
    Eigen::MatrixXd rows(30, 3);
    for (int i = 0; i < 10; ++i)
      rows.middleRows<3>(3 * i) = basis.middleRows<3>(3 * Eigen::Index{nodes[i]});
    found += rows.transpose() * rest_stiffness(solid, e) * rows;
  }
  EXPECT_LE((found - expected).norm(), 1e-13 * expected.norm());
}

TEST(QuadraticElement, PassesThePatchTest) {
  // A linear field needs no force inside, at vertices and at edge points.
  const TetMesh mesh = quadratic(uneven_mesh({3, 3, 2}));
  const Solid solid = make_solid(mesh, kQuadraticMaterial);
  Eigen::Matrix3d gradient;
  for (double& x : gradient.reshaped()) x = uniform(-0.3, 0.3);
  Field u(3 * static_cast<Eigen::Index>(mesh.vertices.size()));
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    u.segment<3>(3 * static_cast<Eigen::Index>(v)) = gradient * mesh.vertices[v];
  const Field force = internal_force(solid, u);
  const Eigen::Vector3d size(0.3, 0.2, 0.25);
  std::size_t inside = 0;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    const Eigen::Vector3d& x = mesh.vertices[v];
    if ((x.array() < 1e-9).any() || (x.array() > size.array() - 1e-9).any()) continue;
    EXPECT_LE(force.segment<3>(3 * static_cast<Eigen::Index>(v)).norm(), 1e-13 * force.norm());
    ++inside;
  }
  EXPECT_GT(inside, 50u);
}

TEST(QuadraticElement, PolynomialsCarryPlacesInsideExactlyAndOutsideStraight) {
  for (const std::array<double, 4> l : {std::array{0.1, 0.2, 0.3, 0.4},
                                        {-0.2, 0.5, 0.3, 0.4},
                                        {-0.1, -0.1, 0.6, 0.6},
                                        {1.0, 0.0, 0.0, 0.0}}) {
    const std::array<double, kMostNodes> weight = polynomials_at(2, l);
    double sum = 0;
    std::array<double, 4> place{};
    for (int i = 0; i < 10; ++i) {
      sum += weight[i];
      if (i < 4) place[i] += weight[i];
      if (i >= 4)
        for (const int a : kTetEdges[i - 4]) place[a] += 0.5 * weight[i];
    }
    EXPECT_NEAR(sum, 1.0, 1e-15);
    for (std::size_t a = 0; a < 4; ++a) EXPECT_NEAR(place[a], l[a], 1e-15);
  }
}

TEST(RefinedMesh, HasEightForOneAndFitsTogether) {
  TetMesh coarse = uneven_mesh({3, 2, 2});
  coarse.region_names = {"a", "b"};
  for (std::size_t t = 0; t < coarse.tetrahedra.size(); ++t)
    coarse.region_of.push_back(static_cast<std::int32_t>(t % 2));
  const TetMesh mesh = quadratic(coarse);
  TetMesh fine = refined_mesh(mesh);
  ASSERT_EQ(fine.tetrahedra.size(), 8 * mesh.tetrahedra.size());
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
    double volume = 0;
    for (std::size_t k = 0; k < 8; ++k) {
      EXPECT_GT(signed_volume(fine, fine.tetrahedra[8 * t + k]), 0);
      volume += signed_volume(fine, fine.tetrahedra[8 * t + k]);
      EXPECT_EQ(fine.region_of[8 * t + k], mesh.region_of[t]);
    }
    EXPECT_NEAR(volume, signed_volume(mesh, mesh.tetrahedra[t]), 1e-17);
  }
  const Result<MeshReport> report = check_mesh(fine);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->unreferenced_vertices, 0u);
  // Faces that did not fit their neighbours would be boundary.
  EXPECT_EQ(boundary_surface(fine).triangles.size(), 4 * boundary_surface(coarse).triangles.size());
}

TEST(EdgePoints, AreSharedAndLieBehindTheVertices) {
  const TetMesh coarse = uneven_mesh();
  const TetMesh mesh = quadratic(coarse);
  EXPECT_EQ(mesh.vertices.size(), coarse.vertices.size() + mesh.edges.size());
  // Euler: vertices - edges + faces - tetrahedra = 1 of a ball; a box of 2x2x2 cells has 48
  // triangles on its boundary.
  const std::size_t faces = (4 * coarse.tetrahedra.size() + 48) / 2;
  EXPECT_EQ(coarse.vertices.size() - mesh.edges.size() + faces - coarse.tetrahedra.size(), 1u);
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t)
    for (std::size_t e = 0; e < 6; ++e) {
      const Eigen::Vector3d middle = 0.5 * (mesh.vertices[mesh.tetrahedra[t][kTetEdges[e][0]]] +
                                            mesh.vertices[mesh.tetrahedra[t][kTetEdges[e][1]]]);
      EXPECT_LE((mesh.vertices[mesh.edge_points[t][e]] - middle).norm(), 1e-15);
    }
}

TEST(EdgePoints, OfAHeldSurfaceAreItsOwnAndNoChords) {
  // One cell between two fixed walls: its space diagonal has both ends fixed and lies inside.
  const TetMesh mesh = quadratic(box_mesh({1, 1, 1}, {1, 1, 1}));
  std::vector<VertexId> held;
  for (VertexId v = 0; v < 8; ++v) held.push_back(v);
  const std::vector<VertexId> surface = held_edge_points(mesh, held, {});
  const std::vector<VertexId> all = held_edge_points(mesh, held, held);
  EXPECT_EQ(all.size(), mesh.edges.size());
  EXPECT_EQ(surface.size(), 18u);  // 12 sides and 6 diagonals of faces, not the one inside
  std::vector<VertexId> low = testing::vertices_on_plane(box_mesh({1, 1, 1}, {1, 1, 1}), 2, 0.0);
  EXPECT_EQ(held_edge_points(mesh, low, low).size(), 5u);
  EXPECT_EQ(held_edge_points(mesh, low, {}).size(), 5u);
}

}  // namespace
}  // namespace tremolo
