// Bodies of tetrahedra that begin in their equilibrium: closed forms of bars, no motion afterwards,
// bodies without a single equilibrium.
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "runtime/bodies/tets/motion/tet_body.h"
#include "tests/support/tet_bodies.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;
using testing::box_mesh;
using testing::tet_bar;
using testing::vertices_on_plane;

TetBody settled_body(const TetModelPointer& model, const TetBodyOptions& options) {
  Result<TetBody> body = TetBody::create(model, options);
  EXPECT_TRUE(body) << body.error().message;
  return std::move(*body);
}

Status settle_alone(TetBody& body) {
  return body.settle(VectorXd::Zero(body.positions().size()));
}

// The mean displacement of the vertices at the far end.
Vector3d end_displacement(const TetBody& body, double length) {
  const TetModel& model = body.model();
  Vector3d sum = Vector3d::Zero();
  int count = 0;
  for (std::size_t v = 0; v < model.vertices(); ++v) {
    if (model.mesh().vertices[v].x() < length - 1e-9) continue;
    const auto at = static_cast<Eigen::Index>(3 * v);
    sum += body.positions().segment<3>(at) - model.rest().segment<3>(at);
    ++count;
  }
  return sum / count;
}

TEST(TetSettle, ABarStretchesUnderItsWeightByTheClosedForm) {
  // nu = 0: u = rho g (L x - x^2/2)/E solves the corotated solid exactly, of any size.
  Material material = testing::kTetGel;
  material.poisson = 0.0;
  const double length = 0.4;
  const TetModelPointer model = tet_bar({5, 1, 1}, {length, 0.05, 0.05}, true, material);
  for (const double gravity : {0.1, 50.0}) {
    TetBodyOptions options;
    options.gravity = {gravity, 0.0, 0.0};
    TetBody body = settled_body(model, options);
    ASSERT_TRUE(settle_alone(body));
    const double stretch = material.density * gravity * length * length / (2.0 * material.young);
    const Vector3d found = end_displacement(body, length);
    EXPECT_NEAR(found.x(), stretch, 1e-10 * stretch);
    EXPECT_LT(found.tail<2>().norm(), 1e-10 * stretch);
    EXPECT_EQ(body.velocities().norm(), 0.0);
    EXPECT_EQ(body.kinetic_energy(), 0.0);
  }
}

TEST(TetSettle, ABarBendsUnderItsWeightAsABeam) {
  // Timoshenko: w L^4/(8 E I) + w L^2/(2 k G A), k = 5/6, nu = 0.
  Material material = testing::kTetGel;
  material.poisson = 0.0;
  const double length = 1.0, side = 0.1, gravity = 0.01;
  const double w = material.density * gravity * side * side, g = 0.5 * material.young;
  const double deflection =
      w * std::pow(length, 4) / (8.0 * material.young * std::pow(side, 4) / 12.0) +
      w * length * length / (2.0 * 5.0 / 6.0 * g * side * side);
  double before = 1.0;
  for (const int cells : {10, 20}) {
    const TetModelPointer model = tet_bar({cells, 2, 2}, {length, side, side}, true, material);
    TetBodyOptions options;
    options.gravity = {0.0, 0.0, -gravity};
    TetBody body = settled_body(model, options);
    ASSERT_TRUE(settle_alone(body));
    const double error = std::abs(-end_displacement(body, length).z() / deflection - 1.0);
    EXPECT_LT(error, 5e-3);
    EXPECT_LT(error, before);
    before = error;
  }
}

TEST(TetSettle, AForceAtTheEndStretchesABarByTheClosedForm) {
  // nu = 0 and an even traction F/A: the strain is F/(E A) everywhere. A control point's fraction
  // of a triangle is a sixth.
  Material material = testing::kTetGel;
  material.poisson = 0.0;
  const double length = 0.4, side = 0.05, force = 20.0;
  const TetModelPointer model = tet_bar({4, 2, 2}, {length, side, side}, true, material);
  const auto at_end = [&](std::uint32_t node) {
    return model->rest()[3 * static_cast<Eigen::Index>(node)] > length - 1e-9;
  };
  VectorXd forces = VectorXd::Zero(model->rest().size());
  double area = 0.0;
  for (const TetModelElement& element : model->elements()) {
    std::vector<std::uint32_t> face;
    for (const std::uint32_t node : element.nodes)
      if (at_end(node)) face.push_back(node);
    if (face.size() != 6) continue;
    const auto x = [&](int k) -> Vector3d {
      return model->rest().segment<3>(3 * static_cast<Eigen::Index>(face[k]));
    };
    const double one = 0.5 * (x(1) - x(0)).cross(x(2) - x(0)).norm();
    area += one;
    for (const std::uint32_t node : face)
      forces[3 * static_cast<Eigen::Index>(node)] += force * one / 6.0 / (side * side);
  }
  ASSERT_NEAR(area, side * side, 1e-12);
  TetBody body = settled_body(model, {});
  ASSERT_TRUE(body.settle(forces));
  const double stretch = force * length / (material.young * side * side);
  EXPECT_NEAR(end_displacement(body, length).x(), stretch, 1e-10 * stretch);
}

// The soft bar of docs/tets.md, which sags by a quarter of its length.
TEST(TetSettle, ABodyStaysWhereItBegins) {
  const double length = 0.4;
  const Material soft{1e5, 0.4, 1000.0};
  const TetModelPointer model = tet_bar({8, 2, 2}, {length, 0.1, 0.1}, true, soft);
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.7, Vector3d(1.0, 2.0, -1.0).normalized()));
  double quadratic_sag = 0.0;
  for (const DegreeKind degree :
       {DegreeKind::kQuadratic, DegreeKind::kLinear, DegreeKind::kAdaptive})
    for (const TetMethod method :
         {TetMethod::kBdf2, TetMethod::kImplicitEuler, TetMethod::kMidpoint, TetMethod::kNewmark}) {
      SCOPED_TRACE(std::string(tet_method_name(method)) + ", degree " +
                   std::to_string(static_cast<int>(degree)));
      TetBodyOptions options;
      options.method = method;
      options.degree.kind = degree;
      options.gravity = turn * Vector3d(0.0, 0.0, -9.81);
      TetBody body = settled_body(model, options);
      VectorXd x = model->rest();
      for (Eigen::Index i = 0; i < x.size(); i += 3)
        x.segment<3>(i) = turn * Vector3d(x.segment<3>(i)) + Vector3d(1.0, -2.0, 3.0);
      ASSERT_TRUE(body.set_state(x, VectorXd::Zero(x.size())));
      const Status settled = settle_alone(body);
      ASSERT_TRUE(settled) << settled.error().message;
      const double sag = (body.positions() - x).lpNorm<Eigen::Infinity>();
      EXPECT_GT(sag, 0.1 * length);
      if (degree == DegreeKind::kQuadratic) quadratic_sag = sag;
      if (degree == DegreeKind::kAdaptive) {
        EXPECT_NEAR(sag, quadratic_sag, 0.03 * quadratic_sag);
        EXPECT_LT(body.system().quadratic_share(), 1.0);
      }
      const VectorXd start = body.positions();
      for (int k = 0; k < 60; ++k) ASSERT_TRUE(body.step().converged);
      EXPECT_LT((body.positions() - start).lpNorm<Eigen::Infinity>(), 1e-6 * length);
      EXPECT_LT(body.velocities().lpNorm<Eigen::Infinity>(), 1e-6 * length);
    }
}

// The state to which a damped body comes.
TEST(TetSettle, ADampedBodyComesToTheSameShape) {
  const double length = 0.4;
  const TetModelPointer model = tet_bar({6, 2, 2}, {length, 0.1, 0.1}, true, testing::kTetGel);
  TetBodyOptions options;
  options.method = TetMethod::kImplicitEuler;
  options.gravity = {0.0, 0.0, -9.81};
  options.alpha = 10.0;
  options.tolerance = 1e-10;
  options.linear_tolerance = 1e-6;
  TetBody falling = settled_body(model, options), body = settled_body(model, options);
  for (int k = 0; k < 600; ++k) ASSERT_TRUE(falling.step().converged);
  ASSERT_TRUE(settle_alone(body));
  EXPECT_LT((body.positions() - falling.positions()).lpNorm<Eigen::Infinity>(), 1e-7 * length);
}

// A clamped column buckles under its weight at rho g A L^3 = 7.837 E I (Greenhill 1881).
TEST(TetSettle, AColumnThatBucklesUnderItsWeightIsRefused) {
  Material material = testing::kTetGel;
  material.poisson = 0.0;
  const double length = 1.0, side = 0.1;
  const TetModelPointer model = tet_bar({16, 2, 2}, {length, side, side}, true, material);
  const double critical =
      7.837 * material.young * side * side / 12.0 / (material.density * std::pow(length, 3));
  for (const double load : {0.9, 1.2}) {
    TetBodyOptions options;
    options.gravity = {-load * critical, 0.0, 0.0};
    TetBody body = settled_body(model, options);
    const VectorXd before = body.positions();
    const Status settled = settle_alone(body);
    if (load < 1.0) {
      EXPECT_TRUE(settled) << settled.error().message;
      continue;
    }
    ASSERT_FALSE(settled);
    EXPECT_EQ(settled.error().kind, ErrorKind::kSolver);
    const std::string& message = settled.error().message;
    EXPECT_NE(message.find("start = \"static\": beyond 0.8"), std::string::npos) << message;
    EXPECT_NE(message.find("buckles"), std::string::npos) << message;
    EXPECT_EQ(body.positions(), before);
  }
}

TEST(TetSettle, ABodyThatNothingHoldsIsRefused) {
  TetMesh mesh = box_mesh({3, 1, 1}, {0.3, 0.1, 0.1});
  const MaterialTable materials{{{"gel", testing::kTetGel}}, {}};
  TetMesh two = mesh;
  const auto more = static_cast<VertexId>(mesh.vertices.size());
  for (const Vector3d& x : mesh.vertices) two.vertices.push_back(x + Vector3d(0.0, 0.0, 0.5));
  const std::size_t elements = mesh.tetrahedra.size();
  for (std::size_t i = 0; i < elements; ++i) {
    auto tet = mesh.tetrahedra[i];
    for (VertexId& corner : tet) corner += more;
    two.tetrahedra.push_back(tet);
  }
  struct Case {
    TetMesh mesh;
    std::vector<VertexId> held;
    const char* words;
  };
  std::vector<VertexId> line;
  for (const VertexId v : vertices_on_plane(mesh, 0, 0.0))
    if (mesh.vertices[static_cast<std::size_t>(v)].z() < 1e-9) line.push_back(v);
  ASSERT_EQ(line.size(), 2U);
  for (const Case& one :
       {Case{mesh, {}, "no fixed vertices"}, Case{mesh, {VertexId{0}}, "can still move"},
        Case{mesh, line, "on one line"},
        Case{two, vertices_on_plane(mesh, 0, 0.0), "none of its vertices"}}) {
    auto model = TetModel::create(one.mesh, materials, one.held);
    ASSERT_TRUE(model) << model.error().message;
    TetBodyOptions options;
    options.gravity = {0.0, 0.0, -9.81};
    TetBody body = settled_body(*model, options);
    const Status settled = settle_alone(body);
    ASSERT_FALSE(settled) << one.words;
    EXPECT_EQ(settled.error().kind, ErrorKind::kContent);
    EXPECT_NE(settled.error().message.find(one.words), std::string::npos)
        << settled.error().message;
  }
}

}  // namespace
}  // namespace tremolo
