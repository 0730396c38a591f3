// The surface in float against the same sums in double, and its normals against their definition.
#include "runtime/bodies/reduced/surface/surface.h"

#include <cmath>
#include <random>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "formats/basis/basis_reader.h"
#include "formats/basis/basis_writer.h"
#include "runtime/body.h"
#include "tests/support/sample_basis.h"

namespace tremolo {
namespace {

using Eigen::Index;
using Eigen::Vector3d;
using Eigen::VectorXd;

// A sphere's worth of vertices with random rows; triangles between random ones.
struct Cloud {
  VertexBlock block;
  std::vector<Triangle> triangles;
  VectorXd q;
};

Cloud random_cloud(int vertices, Index r, unsigned seed) {
  std::mt19937 engine(seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  std::uniform_int_distribution<VertexId> any(0, vertices - 1);
  Cloud cloud;
  for (VertexId v = 0; v < vertices; ++v) {
    cloud.block.vertex_ids.push_back(v);
    cloud.block.rest.emplace_back(uniform(engine), uniform(engine), uniform(engine));
  }
  cloud.block.rows = BasisRows::NullaryExpr(3 * vertices, r, [&] { return uniform(engine); });
  cloud.q = VectorXd::NullaryExpr(r, [&] { return 0.1 * uniform(engine); });
  while (vertices > 2 && static_cast<int>(cloud.triangles.size()) < 2 * vertices) {
    const Triangle t{any(engine), any(engine), any(engine)};
    if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) cloud.triangles.push_back(t);
  }
  return cloud;
}

// The same cloud as a compact file would hold it.
void quantise(VertexBlock& block) {
  block.column_scales = block.rows.cwiseAbs().colwise().maxCoeff().transpose() / 32767.0;
  for (Index i = 0; i < block.rows.cols(); ++i)
    block.rows.col(i) =
        (block.rows.col(i) / block.column_scales[i]).array().round() * block.column_scales[i];
}

// X + U q in double, 3s.
VectorXd exact_positions(const Cloud& cloud) {
  VectorXd x = cloud.block.rows * cloud.q;
  for (std::size_t v = 0; v < cloud.block.rest.size(); ++v)
    x.segment<3>(3 * v) += cloud.block.rest[v];
  return x;
}

// The header's bound for a component: (r + 2) 2^-24 (|X| + sum |q_i U_i|).
VectorXd allowed_error(const Cloud& cloud) {
  VectorXd sum = cloud.block.rows.cwiseAbs() * cloud.q.cwiseAbs();
  for (std::size_t v = 0; v < cloud.block.rest.size(); ++v)
    sum.segment<3>(3 * v) += cloud.block.rest[v].cwiseAbs();
  return (static_cast<double>(cloud.q.size()) + 2.0) * std::ldexp(1.0, -24) * sum;
}

std::vector<float> positions_of(const Cloud& cloud) {
  SurfaceWorkspace workspace;
  std::vector<float> positions(3 * cloud.block.rest.size());
  surface_positions(make_surface_basis(cloud.block, cloud.triangles), cloud.q, workspace,
                    positions);
  return positions;
}

VectorXd as_doubles(const std::vector<float>& values) {
  return Eigen::Map<const Eigen::VectorXf>(values.data(), static_cast<Index>(values.size()))
      .cast<double>();
}

// Block sizes just below, at and above the 64 rows of a block, and many blocks.
constexpr int kVertexCounts[] = {1, 5, 21, 22, 64, 65, 127, 128, 1000};

TEST(Surface, FloatPositionsErrLessThanTheirBound) {
  for (const bool compact : {false, true})
    for (const int vertices : kVertexCounts)
      for (const Index r : {1, 2, 15, 30, 61}) {
        Cloud cloud = random_cloud(vertices, r, static_cast<unsigned>(vertices + r));
        if (compact) quantise(cloud.block);
        const VectorXd error =
            (as_doubles(positions_of(cloud)) - exact_positions(cloud)).cwiseAbs();
        EXPECT_LE((error.array() / allowed_error(cloud).array()).maxCoeff(), 1.0)
            << vertices << " vertices, r = " << r << (compact ? ", compact" : "");
      }
}

TEST(Surface, FloatPositionsErrByAMillionthOfTheSize) {
  // Displacements are a fraction of the size, as in a model: 30 terms of up to 0.1 each.
  const Cloud cloud = random_cloud(1000, 30, 9);
  const double size = bounding_box(cloud.block.rest).diagonal();
  EXPECT_LE((as_doubles(positions_of(cloud)) - exact_positions(cloud)).cwiseAbs().maxCoeff(),
            1e-6 * size);
}

TEST(Surface, RowsThatAreSixteenBitMultiplesAreKeptAsSuchWithoutLoss) {
  Cloud cloud = random_cloud(100, 7, 4);
  EXPECT_TRUE(make_surface_basis(cloud.block, cloud.triangles).pairs.empty());
  quantise(cloud.block);
  const SurfaceBasis rows = make_surface_basis(cloud.block, cloud.triangles);
  EXPECT_FALSE(rows.pairs.empty());
  EXPECT_TRUE(rows.rows.empty());
  // One coordinate at a time, from rest positions of zero: only the product is rounded.
  for (Vector3d& x : cloud.block.rest) x.setZero();
  for (Index i = 0; i < 7; ++i) {
    cloud.q = VectorXd::Unit(7, i);
    const VectorXd exact = exact_positions(cloud);
    EXPECT_LE((as_doubles(positions_of(cloud)) - exact).cwiseAbs().maxCoeff(),
              std::ldexp(1.0, -23) * exact.cwiseAbs().maxCoeff());
  }
}

TEST(Surface, ScalesThatDoNotFitTheRowsAreNotBelieved) {
  Cloud cloud = random_cloud(100, 7, 4);
  quantise(cloud.block);
  cloud.block.rows(50, 3) += 0.3 * cloud.block.column_scales[3];
  EXPECT_TRUE(make_surface_basis(cloud.block, cloud.triangles).pairs.empty());
  cloud.block.rows(50, 3) = 40000.0 * cloud.block.column_scales[3];
  EXPECT_TRUE(make_surface_basis(cloud.block, cloud.triangles).pairs.empty());
  cloud.block.column_scales.conservativeResize(6);
  EXPECT_TRUE(make_surface_basis(cloud.block, cloud.triangles).pairs.empty());
}

TEST(Surface, NormalsAreTheAreaWeightedOnesOfThosePositions) {
  for (const int vertices : {3, 22, 64, 65, 1000}) {
    const Cloud cloud = random_cloud(vertices, 6, 12);
    SurfaceWorkspace workspace;
    std::vector<float> positions(3 * cloud.block.rest.size()), normals(positions.size());
    surface_with_normals(make_surface_basis(cloud.block, cloud.triangles), cloud.triangles, cloud.q,
                         workspace, positions, normals);
    EXPECT_EQ(positions, positions_of(cloud));
    const VectorXd x = as_doubles(positions), n = as_doubles(normals);
    VectorXd sums = VectorXd::Zero(x.size()), sizes = VectorXd::Zero(vertices);
    for (const auto& [a, b, c] : cloud.triangles) {
      const Vector3d origin = x.segment<3>(3 * a);
      const Vector3d e = x.segment<3>(3 * b) - origin, f = x.segment<3>(3 * c) - origin;
      for (const VertexId v : {a, b, c}) {
        sums.segment<3>(3 * v) += e.cross(f);
        sizes[v] += e.norm() * f.norm();
      }
    }
    for (Index v = 0; v < vertices; ++v) {
      const Vector3d sum = sums.segment<3>(3 * v), normal = n.segment<3>(3 * v);
      if (sum.norm() == 0.0) {
        EXPECT_TRUE(normal.isZero(0.0)) << "no triangle names it";
        continue;
      }
      // About ten roundings of numbers as large as the products, then the division.
      const double allowed = 20 * std::ldexp(1.0, -24) * (sizes[v] / sum.norm() + 1.0);
      EXPECT_LE((normal - sum.normalized()).norm(), allowed) << vertices << ", vertex " << v;
    }
  }
}

TEST(Surface, NormalsOfATetrahedronPointOutwards) {
  Cloud cloud;
  cloud.block.vertex_ids = {0, 1, 2, 3};
  cloud.block.rest = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  cloud.block.rows = BasisRows::Zero(12, 1);
  cloud.triangles = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
  cloud.q = VectorXd::Ones(1);
  SurfaceWorkspace workspace;
  std::vector<float> positions(12), normals(12);
  surface_with_normals(make_surface_basis(cloud.block, cloud.triangles), cloud.triangles, cloud.q,
                       workspace, positions, normals);
  const VectorXd n = as_doubles(normals);
  const Vector3d centre(0.25, 0.25, 0.25);
  for (Index v = 0; v < 4; ++v) {
    EXPECT_NEAR(n.segment<3>(3 * v).norm(), 1.0, 1e-6);
    EXPECT_GT(n.segment<3>(3 * v).dot(cloud.block.rest[v] - centre), 0.0);
  }
}

TEST(Surface, FlatTrianglesGiveNoNormalAndNoNotANumber) {
  Cloud cloud;
  cloud.block.vertex_ids = {0, 1, 2};
  cloud.block.rest = {{0, 0, 0}, {1, 1, 1}, {2, 2, 2}};
  cloud.block.rows = BasisRows::Zero(9, 1);
  cloud.triangles = {{0, 1, 2}};
  cloud.q = VectorXd::Ones(1);
  SurfaceWorkspace workspace;
  std::vector<float> positions(9), normals(9, 7.0f);
  surface_with_normals(make_surface_basis(cloud.block, cloud.triangles), cloud.triangles, cloud.q,
                       workspace, positions, normals);
  EXPECT_EQ(normals, std::vector<float>(9, 0.0f));
}

TEST(Surface, ABodyOfACompactFileIsWhereTheFullOneIs) {
  BasisData data = testing::sample_basis(
      testing::random_strain_model(testing::spread_omega(5, 5.0, 200.0), 0.3, 51));
  const auto bytes = encode_basis(data, BasisEncoding::kCompact);
  ASSERT_TRUE(bytes);
  const auto compact = Model::load_from_memory(*bytes);
  ASSERT_TRUE(compact) << compact.error().message;
  const auto full = Model::from_data(data);
  Result<Body> a = Body::create(*full, "verlet", {}), b = Body::create(*compact, "verlet", {});
  const VectorXd q = VectorXd::LinSpaced(5, 0.1, -0.2), p = VectorXd::Zero(5);
  ASSERT_TRUE(a->set_state(q, p));
  ASSERT_TRUE(b->set_state(q, p));
  std::vector<float> x(3 * data.surface.rest.size()), y(x.size()), n(x.size());
  ASSERT_TRUE(a->surface(std::span<float>(x)));
  ASSERT_TRUE(b->surface(y, n));
  EXPECT_FALSE((*compact)->surface_basis().pairs.empty());
  EXPECT_TRUE((*full)->surface_basis().pairs.empty());
  // Half a 16-bit step of each column, and the rounding of floats.
  const double allowed =
      0.5 / 32767.0 * data.surface.rows.cwiseAbs().maxCoeff() * q.cwiseAbs().sum() + 1e-6;
  EXPECT_LE((as_doubles(x) - as_doubles(y)).cwiseAbs().maxCoeff(), allowed);
}

TEST(Surface, BuffersOfTheWrongLengthAreRefused) {
  const auto model = Model::from_data(testing::sample_basis(
      testing::random_strain_model(testing::spread_omega(3, 5.0, 200.0), 0.3, 51)));
  const Result<Body> body = Body::create(*model, "verlet", {});
  const std::size_t size = 3 * (*model)->surface().vertex_ids.size();
  std::vector<float> right(size), wrong(size - 1);
  EXPECT_EQ(body->surface(wrong, right).error().kind, ErrorKind::kUsage);
  EXPECT_EQ(body->surface(right, wrong).error().kind, ErrorKind::kUsage);
  std::vector<float> normals(size);
  EXPECT_TRUE(body->surface(right, normals));
}

}  // namespace
}  // namespace tremolo
