// Cloths that begin in their equilibrium: a closed form, the end of a damped motion, no motion
// afterwards, cloths without a single equilibrium.
#include <gtest/gtest.h>

#include "runtime/bodies/cloth/cloth_body.h"
#include "runtime/bodies/cloth/cloth_world.h"
#include "runtime/step/nodal_integrator.h"
#include "tests/cloth/cloth_samples.h"

namespace tremolo {
namespace {

using Eigen::Index;
using Eigen::Vector3d;
using Eigen::VectorXd;
using testing::sample_sheet;

constexpr double kRestGravity = 9.81;

void pin(SceneCloth& cloth, std::vector<std::size_t> particles) {
  ClothPin pin;
  pin.particles = std::move(particles);
  cloth.pins.push_back(std::move(pin));
}

std::vector<std::size_t> row_of_grid(const ClothGrid& grid, std::size_t row) {
  std::vector<std::size_t> particles;
  for (std::size_t column = 0; column < grid.columns; ++column)
    particles.push_back(grid_particle(grid, row, column));
  return particles;
}

ClothScene scene_of(const SceneCloth& cloth, const char* integrator = "implicit-euler") {
  ClothScene scene;
  scene.integrator = integrator;
  scene.gravity.values = {{0.0, 0.0, -kRestGravity}};
  scene.cloths = {cloth};
  return scene;
}

// A strip that hangs by its upper edge in the plane y = 0.
SceneCloth hanging_strip() {
  SceneCloth cloth = sample_sheet(2, 9);
  cloth.grid.width = 0.25;
  cloth.grid.across = -Vector3d::UnitZ();
  cloth.shear = cloth.bend = {0.0, 0.0};
  cloth.settled = true;
  pin(cloth, row_of_grid(cloth.grid, 0));
  return cloth;
}

// A level sheet on two opposite edges, loosely: it hangs down between them.
SceneCloth hammock(std::size_t n) {
  SceneCloth cloth = sample_sheet(n, n);
  cloth.settled = true;
  std::vector<std::size_t> edges = row_of_grid(cloth.grid, 0);
  for (const std::size_t particle : row_of_grid(cloth.grid, n - 1)) edges.push_back(particle);
  pin(cloth, edges);
  return cloth;
}

SceneCloth by_corners(std::size_t n) {
  SceneCloth cloth = sample_sheet(n, n);
  cloth.settled = true;
  pin(cloth, {0, n - 1, n * (n - 1), n * n - 1});
  return cloth;
}

double size_of(const VectorXd& x) {
  const Eigen::Map<const Eigen::Matrix3Xd> points(x.data(), 3, x.size() / 3);
  return (points.rowwise().maxCoeff() - points.rowwise().minCoeff()).norm();
}

TEST(ClothRest, AHangingStripStretchesByTheWeightBelow) {
  const SceneCloth cloth = hanging_strip();
  Result<ClothWorld> world = ClothWorld::create(scene_of(cloth));
  ASSERT_TRUE(world) << world.error().message;
  const VectorXd& x = world->positions(0);
  const VectorXd& mass = world->model(0).mass();
  const ClothGrid& grid = cloth.grid;
  for (std::size_t column = 0; column < grid.columns; ++column) {
    double z = 0.0;
    for (std::size_t row = 1; row < grid.rows; ++row) {
      double below = 0.0;
      for (std::size_t k = row; k < grid.rows; ++k)
        below += mass[static_cast<Index>(grid_particle(grid, k, column))];
      z -= grid.height / static_cast<double>(grid.rows - 1) +
           below * kRestGravity / cloth.structural.stiffness;
      const auto at = 3 * static_cast<Index>(grid_particle(grid, row, column));
      EXPECT_NEAR(x[at + 2], z, 1e-10);
      EXPECT_NEAR(x[at + 1], 0.0, 1e-10);
    }
  }
}

TEST(ClothRest, ItIsWhereADampedSheetComesToRest) {
  for (const bool corners : {false, true}) {
    SCOPED_TRACE(corners);
    SceneCloth cloth = corners ? by_corners(9) : hammock(9);
    Result<ClothWorld> world = ClothWorld::create(scene_of(cloth));
    ASSERT_TRUE(world) << world.error().message;
    cloth.settled = false;
    cloth.structural.damping = cloth.shear.damping = 0.3;
    ClothScene falling = scene_of(cloth);
    falling.options.tolerance = 1e-9;
    Result<ClothWorld> other = ClothWorld::create(falling);
    ASSERT_TRUE(other) << other.error().message;
    for (int k = 0; k < 6000; ++k) ASSERT_TRUE(other->step());
    EXPECT_LT((world->positions(0) - other->positions(0)).lpNorm<Eigen::Infinity>(), 1e-6);
    EXPECT_GT(size_of(world->positions(0)), 1.0);
  }
}

TEST(ClothRest, ASheetStaysWhereItBegins) {
  for (const char* method :
       {"implicit-euler", "implicit-euler-linear", "midpoint", "newmark", "bdf2", "energy", "imex"})
    for (int kind = 0; kind < 3; ++kind) {
      SCOPED_TRACE(std::string(method) + " " + std::to_string(kind));
      const SceneCloth cloth = kind == 0 ? hanging_strip() : kind == 1 ? hammock(8) : by_corners(8);
      ClothScene scene = scene_of(cloth, method);
      scene.options.step = 1.0 / 240.0;
      Result<ClothWorld> world = ClothWorld::create(scene);
      ASSERT_TRUE(world) << world.error().message;
      const VectorXd start = world->positions(0);
      EXPECT_EQ(world->velocities(0).norm(), 0.0);
      for (int k = 0; k < 240; ++k) ASSERT_TRUE(world->step());
      EXPECT_LT((world->positions(0) - start).lpNorm<Eigen::Infinity>(), 1e-6 * size_of(start));
    }
}

TEST(ClothRest, ForcesOnParticlesBalanceTheSprings) {
  SceneCloth cloth = by_corners(7);
  Result<ClothBody> body = ClothBody::create(scene_of(cloth));
  ASSERT_TRUE(body) << body.error().message;
  VectorXd forces = VectorXd::Zero(body->state().x.size());
  forces.segment<3>(3 * 24) = Vector3d(0.3, 0.1, -2.0);
  ASSERT_TRUE(body->settle(forces));
  VectorXd f(forces.size());
  body->model().force(body->state().x, VectorXd::Zero(forces.size()), ForcePart::kAll, f);
  f += forces;
  for (const std::size_t corner : {0, 6, 42, 48}) f.segment<3>(3 * corner).setZero();
  EXPECT_LT(f.norm(), 1e-9 * forces.norm());
}

TEST(ClothRest, WithoutLoadsASheetKeepsItsShape) {
  ClothScene scene = scene_of(by_corners(5));
  scene.gravity.values.clear();
  Result<ClothWorld> world = ClothWorld::create(scene);
  ASSERT_TRUE(world) << world.error().message;
  EXPECT_EQ(world->positions(0), world->model(0).parts().x);
}

TEST(ClothRest, ClothWithoutASingleEquilibriumIsRefused) {
  struct Case {
    SceneCloth cloth;
    ErrorKind kind;
    const char* words;
  };
  SceneCloth loose = sample_sheet(5, 5), one = loose, line = loose, upright = loose;
  loose.settled = one.settled = line.settled = upright.settled = true;
  pin(one, {0});
  // Both pins on one vertical line: it can turn about that.
  line.grid.across = -Vector3d::UnitZ();
  pin(line, {0, 20});
  // On its lower edge: it buckles.
  upright.grid.across = Vector3d::UnitZ();
  pin(upright, row_of_grid(upright.grid, 0));
  for (const Case& c : {Case{loose, ErrorKind::kContent, "no `pins`"},
                        Case{one, ErrorKind::kSolver, "not the only"},
                        Case{line, ErrorKind::kSolver, "not the only"},
                        Case{upright, ErrorKind::kSolver, "not the only"}}) {
    const Result<ClothWorld> world = ClothWorld::create(scene_of(c.cloth));
    ASSERT_FALSE(world) << c.words;
    EXPECT_EQ(world.error().kind, c.kind) << world.error().message;
    EXPECT_NE(world.error().message.find("cloth 'cloth': start = \"static\": "), std::string::npos)
        << world.error().message;
    EXPECT_NE(world.error().message.find(c.words), std::string::npos) << world.error().message;
  }
}

}  // namespace
}  // namespace tremolo
