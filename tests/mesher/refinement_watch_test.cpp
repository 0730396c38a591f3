#include <algorithm>
#include <stdexcept>

#include <gtest/gtest.h>

#include "precompute/mesher/cgal/cgal_mesher.h"
#include "precompute/mesher/surface/surface_geometry.h"
#include "tests/support/meshes/surfaces.h"

namespace tremolo {
namespace {

// The number of queries until the watch ends it; 0 if it does not within `most`.
std::size_t queries_until_end(RefinementWatch& watch, std::size_t most, std::size_t each_vertex) {
  for (std::size_t i = 0; i < most; ++i) try {
      watch.step(1'000 + (each_vertex == 0 ? 0 : i / each_vertex));
    } catch (const std::runtime_error&) {
      return i + 1;
    }
  return 0;
}

TEST(RefinementWatch, EndsWhatStandsStillAfterTheSameCountEachTime) {
  RefinementWatch first({}), second({});
  const std::size_t end = queries_until_end(first, 1'000'000, 0);
  EXPECT_GT(end, 20'000U) << "scanning a mesh of 1 000 vertices is no standstill";
  EXPECT_LT(end, 100'000U);
  EXPECT_EQ(queries_until_end(second, 1'000'000, 0), end);
}

TEST(RefinementWatch, LetsWhatGoesOnGoOn) {
  RefinementWatch watch({});
  EXPECT_EQ(queries_until_end(watch, 1'000'000, 500), 0U);
}

TEST(RefinementWatch, EndsWhatGoesOnForEver) {
  RefinementWatch watch({.most_steps = 300'000});
  const std::size_t end = queries_until_end(watch, 1'000'000, 500);
  EXPECT_GE(end, 300'000U);
  EXPECT_LT(end, 302'000U);
  RefinementWatch crowded({.most_vertices = 1'500});
  EXPECT_GT(queries_until_end(crowded, 1'000'000, 500), 250'000U);
}

TEST(RefinementWatch, TellsHowFarItIsOnceItTakesLong) {
  ::testing::internal::CaptureStderr();
  RefinementWatch quick({.expected = 4'000});
  queries_until_end(quick, 10'000, 5);
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
  ::testing::internal::CaptureStderr();
  RefinementWatch slow({.expected = 4'000, .seconds = 1e-9});
  queries_until_end(slow, 10'000, 5);
  EXPECT_NE(::testing::internal::GetCapturedStderr().find("of about 4000 vertices"),
            std::string::npos);
  EXPECT_EQ(progress_text(1'000, 4'000, 5),
            "meshing: 1000 of about 4000 vertices, 5 s, about 15 s more");
  EXPECT_NE(progress_text(5'000, 4'000, 5).find("more of them than usual"), std::string::npos);
}

TEST(RefinementWatch, TellsLessAndLessOften) {
  ::testing::internal::CaptureStderr();
  RefinementWatch watch({.expected = 4'000, .seconds = 1e-9});
  queries_until_end(watch, 1'000'000, 500);
  const std::string printed = ::testing::internal::GetCapturedStderr();
  // 976 looks; the time between two lines doubles.
  EXPECT_LT(std::count(printed.begin(), printed.end(), '\n'), 60);
}

void expect_given_up(const Result<TetMesh>& mesh) {
  ASSERT_FALSE(mesh);
  EXPECT_EQ(mesh.error().kind, ErrorKind::kSolver);
  EXPECT_NE(mesh.error().message.find("does not come to an end"), std::string::npos)
      << mesh.error().message;
}

// A ball of some thousand vertices.
TEST(RefinementWatch, BothMeshersAskIt) {
  ImplicitRequest implicit;
  implicit.bounds = {Eigen::Vector3d::Constant(-1.1), Eigen::Vector3d::Constant(1.1)};
  implicit.inside = [](const Eigen::Vector3d& x) { return x.squaredNorm() < 1; };
  implicit.size = [](const Eigen::Vector3d&) { return 0.15; };
  implicit.surface_error = 0.01;
  implicit.first_points = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  implicit.onto_surface = [](Eigen::Vector3d& x) {
    x.normalize();
    return true;
  };
  implicit.most_queries = static_cast<std::size_t>(-1);
  const SurfaceMesh ball = testing::sphere_surface(1.0);
  const TriangleTree tree(ball);
  PolyhedralRequest polyhedral;
  polyhedral.size = implicit.size;
  polyhedral.surface_error = implicit.surface_error;
  for (const Eigen::Vector3d& x : implicit.first_points) polyhedral.seeds.push_back({x, 1});
  polyhedral.most_queries = implicit.most_queries;
  for (const WatchLimits& limits :
       {WatchLimits{.most_steps = 500}, WatchLimits{.most_vertices = 50}}) {
    implicit.watch = polyhedral.watch = limits;
    expect_given_up(mesh_implicit(implicit));
    expect_given_up(mesh_polyhedron(ball, tree, polyhedral));
  }
  implicit.watch = polyhedral.watch = {};
  EXPECT_TRUE(mesh_implicit(implicit));
  EXPECT_TRUE(mesh_polyhedron(ball, tree, polyhedral));
}

}  // namespace
}  // namespace tremolo
