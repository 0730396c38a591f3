// Lame's mode of a block between sliding walls, known in closed form: frequency and shape converge
// with the order of the elements.
#include <cmath>
#include <numbers>

#include <Eigen/SparseCholesky>
#include <gtest/gtest.h>

#include "common/mesh/edge_points.h"
#include "precompute/fem/assembly.h"
#include "precompute/fem/element_group.h"
#include "tests/support/meshes/box_mesh.h"

namespace tremolo {
namespace {

const Material kLameMaterial{2e5, 0.4, 1000.0};

// Lame's mode of a block between sliding walls: pure shear waves, u = (sin ax cos ay,
// -cos ax sin ay, 0), a = pi / side; omega = sqrt 2 c_s a.
Eigen::Vector3d lame_mode(double a, const Eigen::Vector3d& x) {
  return {std::sin(a * x.x()) * std::cos(a * x.y()), -std::cos(a * x.x()) * std::sin(a * x.y()),
          0.0};
}

// K and M of a block whose normal displacement is zero on all six walls. unknown: of each
// displacement its row, or -1.
struct SlidingBlock {
  TetMesh mesh;
  Solid solid;
  Eigen::VectorXi unknown;
  Eigen::SparseMatrix<double> k, m;
};

SlidingBlock sliding_block(const TetMesh& mesh, const Eigen::Vector3d& size) {
  SlidingBlock block{mesh, make_solid(mesh, kLameMaterial), {}, {}, {}};
  Eigen::VectorXi& unknown = block.unknown;
  unknown = Eigen::VectorXi::Constant(3 * std::ssize(mesh.vertices), -1);
  int count = 0;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    for (int axis = 0; axis < 3; ++axis)
      if (mesh.vertices[v][axis] > 1e-9 && mesh.vertices[v][axis] < size[axis] - 1e-9)
        unknown[3 * static_cast<Eigen::Index>(v) + axis] = count++;
  std::vector<Eigen::Triplet<double>> stiffness, mass;
  for (std::size_t e = 0; e < block.solid.elements.size(); ++e) {
    const ElementNodes nodes = element_nodes(mesh, e);
    const ElementStiffness k = rest_stiffness(block.solid, e);
    for (int i = 0; i < 3 * nodes.count; ++i)
      for (int j = 0; j < 3 * nodes.count; ++j) {
        const int row = unknown[3 * nodes[i / 3] + i % 3];
        const int column = unknown[3 * nodes[j / 3] + j % 3];
        if (row < 0 || column < 0) continue;
        stiffness.emplace_back(row, column, k(i, j));
        if (i % 3 == j % 3)
          mass.emplace_back(row, column,
                            element_mass(block.solid, e, i / 3, j / 3, MassKind::kConsistent));
      }
  }
  block.k.resize(count, count);
  block.m.resize(count, count);
  block.k.setFromTriplets(stiffness.begin(), stiffness.end());
  block.m.setFromTriplets(mass.begin(), mass.end());
  return block;
}

// L2 norm of what the displacement u is off Lame's mode, over that of the mode: by sums over points
// that are exact for degree 4.
double off_lame_mode(const SlidingBlock& block, const Eigen::VectorXd& u, double a, int order) {
  double both = 0, square = 0, mine = 0;
  for (std::size_t e = 0; e < block.solid.elements.size(); ++e) {
    const ElementNodes nodes = element_nodes(block.mesh, e);
    for (const SamplePoint& point : sample_points(2, 4)) {
      const std::array<double, kMostNodes> value = polynomials_at(order, point.lambda);
      Eigen::Vector3d x = Eigen::Vector3d::Zero(), found = Eigen::Vector3d::Zero();
      for (int c = 0; c < 4; ++c) x += point.lambda[c] * block.mesh.vertices[nodes[c]];
      for (int i = 0; i < nodes.count; ++i)
        for (int axis = 0; axis < 3; ++axis)
          if (const int at = block.unknown[3 * nodes[i] + axis]; at >= 0)
            found[axis] += value[i] * u[at];
      const Eigen::Vector3d mode = lame_mode(a, x);
      const double weight = point.share * block.solid.elements[e].volume;
      both += weight * mode.dot(found);
      square += weight * mode.squaredNorm();
      mine += weight * found.squaredNorm();
    }
  }
  return std::sqrt(std::max(0.0, 1.0 - both * both / (square * mine)));
}

// frequency: the mesh's lowest over the exact one, less 1. shape: as off_lame_mode, of its mode.
struct LameError {
  double frequency = 0;
  double shape = 0;
};
LameError lame_error(int cells, int order) {
  const Eigen::Vector3d size(0.1, 0.1, 0.1 / cells);
  TetMesh mesh = testing::box_mesh({cells, cells, 1}, size);
  if (order == 2) {
    EXPECT_TRUE(add_edge_points(mesh));
  }
  const SlidingBlock block = sliding_block(mesh, size);
  const double a = std::numbers::pi / size.x();
  Eigen::VectorXd u = Eigen::VectorXd::Zero(block.k.rows());
  for (std::size_t v = 0; v < block.mesh.vertices.size(); ++v) {
    const Eigen::Vector3d value = lame_mode(a, block.mesh.vertices[v]);
    for (int axis = 0; axis < 2; ++axis)
      if (const int i = block.unknown[3 * static_cast<Eigen::Index>(v) + axis]; i >= 0)
        u[i] = value[axis];
  }
  // Inverse iteration: the mode is the lowest.
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(block.k);
  for (int round = 0; round < 60; ++round) u = factor.solve(block.m * u).normalized();
  const double exact = std::sqrt(2.0 * lame_mu(kLameMaterial) / kLameMaterial.density) * a;
  return {std::sqrt(u.dot(block.k * u) / u.dot(block.m * u)) / exact - 1.0,
          off_lame_mode(block, u, a, order)};
}

TEST(QuadraticElement, LamesModeConvergesWithTheFourthOrderAndItsShapeWithTheThird) {
  const LameError coarse = lame_error(6, 2), fine = lame_error(12, 2);
  EXPECT_GT(fine.frequency, 0);
  EXPECT_LT(fine.frequency, 1e-4);
  EXPECT_GE(std::log2(coarse.frequency / fine.frequency), 3.7);
  EXPECT_GE(std::log2(coarse.shape / fine.shape), 2.8);
  const LameError linear = lame_error(6, 1), finer = lame_error(12, 1);
  EXPECT_NEAR(std::log2(linear.frequency / finer.frequency), 2.0, 0.2);
}

}  // namespace
}  // namespace tremolo
