// Results must not depend on the description of a mesh: the numbers of its vertices, its position,
// the unit of length. The whole precompute runs on random meshes.
#include <cmath>

#include <gtest/gtest.h>

#include "common/packed_index.h"
#include "tests/support/computed_basis.h"
#include "tests/support/meshes/random_mesh.h"

namespace tremolo {
namespace {

using testing::Random;

// A random bar: no symmetry, no two frequencies near each other.
TetMesh random_bar(Random& random) {
  TetMesh mesh = testing::box_mesh({5, 2, 3}, {0.5, 0.11, 0.17});
  std::uniform_real_distribution<double> shift(-0.006, 0.006);
  for (Eigen::Vector3d& x : mesh.vertices)
    x += Eigen::Vector3d(shift(random), shift(random), shift(random));
  return mesh;
}

// Vertices of one end: by id, so that they are the same ones for any orientation of the mesh.
std::vector<VertexId> one_end(const TetMesh& mesh) {
  std::vector<VertexId> ids;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    if (mesh.vertices[v].x() < 0.01) ids.push_back(static_cast<VertexId>(v));
  return ids;
}

struct Model {
  TetMesh mesh = {};
  std::vector<VertexId> fixed = {};
  Material material = {1e6, 0.3, 1000.0};
};

Model random_model(Random& random) {
  Model model{random_bar(random)};
  model.fixed = one_end(model.mesh);
  return model;
}

BasisData precompute(const Model& model, bool linear = false) {
  std::string selector = "vertex:";
  for (VertexId id : model.fixed)
    selector += (selector.back() == ':' ? "" : ",") + std::to_string(id);
  PrecomputeRequest request = testing::basis_request(model.material, selector);
  request.basis.linear_modes = 6;
  request.basis.modes = linear ? 6 : 10;
  request.basis.linear = linear;
  return testing::compute_basis(model.mesh, request).result.data;
}

// The eigensolver works to a residual of 1e-10 and better; eigenvalues err by its square over the
// gap. What is left is rounding in K and M: 1e-12 is not reached.
void expect_same_spectrum(const BasisData& a, const BasisData& b, double scale = 1) {
  ASSERT_EQ(a.lambda.size(), b.lambda.size());
  for (Eigen::Index i = 0; i < a.lambda.size(); ++i)
    EXPECT_NEAR(b.lambda[i] / (scale * a.lambda[i]), 1.0, 1e-9) << i;
}

// Columns of U have no sign of their own: of C and Q those entries are compared in which every
// coordinate occurs an even number of times.
void expect_same_quartic(const BasisData& a, const BasisData& b, double scale = 1) {
  ASSERT_EQ(a.quartic.size(), b.quartic.size());
  const std::size_t r = a.lambda.size();
  for (std::size_t j = 0; j < r; ++j)
    for (std::size_t i = 0; i <= j; ++i) {
      const double expected = scale * a.quartic[quad_index(i, i, j, j)];
      // Columns rotate by the residual over the gap between neighbours: 1e-9 is not reached.
      EXPECT_NEAR(b.quartic[quad_index(i, i, j, j)], expected, 1e-6 * std::abs(expected))
          << i << " " << j;
    }
}

TEST(Invariance, NumbersOfVerticesAndOrderOfCornersDoNotMatter) {
  Random random(1);
  for (int n = 0; n < 2; ++n) {
    const Model model = random_model(random);
    Model other = model;
    const auto order = testing::random_permutation(model.mesh.vertices.size(), random);
    other.mesh = testing::renumbered(model.mesh, order);
    for (VertexId& id : other.fixed) id = order[id];
    std::shuffle(other.mesh.tetrahedra.begin(), other.mesh.tetrahedra.end(), random);
    testing::shuffle_corners(other.mesh, false, random);
    const BasisData a = precompute(model), b = precompute(other);
    expect_same_spectrum(a, b);
    expect_same_quartic(a, b);
    EXPECT_NEAR(b.total_mass, a.total_mass, 1e-13 * a.total_mass);
    EXPECT_EQ(b.triangles.size(), a.triangles.size());
  }
}

TEST(Invariance, VerticesOfNoTetrahedronDoNotMatter) {
  Random random(2);
  const Model model = random_model(random);
  Model other = model;
  other.mesh.vertices.push_back({100, 200, 300});
  other.mesh.vertices.push_back(model.mesh.vertices.front());
  const BasisData a = precompute(model), b = precompute(other);
  expect_same_spectrum(a, b);
  expect_same_quartic(a, b);
}

TEST(Invariance, FrequenciesDoNotDependOnWhereTheBodyStands) {
  Random random(3);
  for (int n = 0; n < 3; ++n) {
    const Model model = random_model(random);
    Model other = model;
    const Eigen::Matrix3d turn = testing::random_rotation(random);
    for (Eigen::Vector3d& x : other.mesh.vertices) x = turn * x + Eigen::Vector3d(1, -2, 0.5);
    expect_same_spectrum(precompute(model, true), precompute(other, true));
  }
}

// The basis uses the size of the axes' bounding box, which quarter turns do not change.
TEST(Invariance, QuarterTurnsAndShiftsDoNotMatterAtAll) {
  Random random(4);
  const Model model = random_model(random);
  Model other = model;
  for (Eigen::Vector3d& x : other.mesh.vertices)
    x = Eigen::Vector3d(x.y(), -x.x(), x.z()) + Eigen::Vector3d(3, 1, -2);
  const BasisData a = precompute(model), b = precompute(other);
  expect_same_spectrum(a, b);
  expect_same_quartic(a, b);
}

// With lengths times s, stiffness times e and density times d: omega^2 goes as e / (d s^2), mass as
// d s^3, a column of U as mass^-1/2, its gradient as that over s, and an entry of Q as e s^3 times
// the fourth power of a gradient.
TEST(Invariance, UnitsScaleEverythingAndChangeNothing) {
  Random random(5);
  const Model model = random_model(random);
  const BasisData a = precompute(model);
  for (const auto& [s, e, d] :
       {std::array{1e-3, 1.0, 1.0}, std::array{1.0, 1e5, 8.0}, std::array{250.0, 1e-3, 0.1}}) {
    Model other = model;
    for (Eigen::Vector3d& x : other.mesh.vertices) x *= s;
    other.material.young *= e;
    other.material.density *= d;
    const BasisData b = precompute(other);
    expect_same_spectrum(a, b, e / (d * s * s));
    expect_same_quartic(a, b, e / (d * d * std::pow(s, 7)));
  }
}

}  // namespace
}  // namespace tremolo
