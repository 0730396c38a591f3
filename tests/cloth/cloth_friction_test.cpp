// Friction of cloth in scenes of cloth alone, and balls that rebound: closed forms at h and h/2.
#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "runtime/bodies/cloth/cloth_world.h"
#include "tests/cloth/cloth_samples.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

constexpr double kG = 9.81;
constexpr std::array kSteps = {1.0 / 60.0, 1.0 / 120.0};

// A sheet of 6 x 6 particles that lies on a floor; gravity is tilted by the angle towards x.
ClothScene sheet_on_slope(const char* method, double step, double angle, double friction) {
  ClothScene scene;
  scene.integrator = method;
  scene.options.step = step;
  scene.gravity.values = {{kG * std::sin(angle), 0.0, -kG * std::cos(angle)}};
  SceneCloth sheet = testing::sample_sheet(6, 6);
  sheet.friction = friction;
  sheet.restitution = 0.0;
  sheet.grid.corner = {0.0, 0.0, sheet.thickness};
  scene.cloths = {sheet};
  SceneCollider floor;
  floor.name = "floor";
  floor.shape = PlaneShape{};
  floor.friction = friction;
  floor.restitution = 0.0;
  scene.colliders = {floor};
  return scene;
}

// Where its first particle is along the slope after that time.
double way_in(const ClothScene& scene, double seconds) {
  auto world = ClothWorld::create(scene);
  EXPECT_TRUE(world) << (world ? "" : world.error().message);
  if (!world) return 0.0;
  for (int k = 0; k < std::lround(seconds / scene.options.step); ++k)
    if (const Status s = world->step(); !s) {
      ADD_FAILURE() << s.error().message;
      break;
    }
  return world->positions(0)[0];
}

// Below the angle of friction it stays once friction is known, after the first step. It crept by
// g h sin of the angle, at any friction.
TEST(ClothFriction, ASheetSticksToASlope) {
  const double angle = 0.95 * std::atan(0.4);
  for (const char* method : {"implicit-euler", "implicit-euler-linear", "midpoint", "energy",
                             "newmark", "bdf2", "symplectic-euler"})
    for (const double step : kSteps) {
      const double used = method == std::string_view("symplectic-euler") ? 0.1 * step : step;
      const ClothScene scene = sheet_on_slope(method, used, angle, 0.4);
      const double early = way_in(scene, 0.1), late = way_in(scene, 1.0);
      EXPECT_LT(std::abs(late - early), 1e-9) << method << ", " << used;
      EXPECT_LT(std::abs(early), 1.01 * kG * std::sin(angle) * used * used) << method;
    }
}

// Above it, it slides with g (sin - mu cos).
TEST(ClothFriction, ASheetSlidesDownASteeperSlope) {
  const double angle = 1.1 * std::atan(0.4);
  const double exact = 0.5 * kG * (std::sin(angle) - 0.4 * std::cos(angle));
  for (const char* method : {"implicit-euler", "midpoint", "energy"}) {
    std::array<double, 2> off{};
    for (std::size_t k = 0; k < 2; ++k)
      off[k] = way_in(sheet_on_slope(method, kSteps[k], angle, 0.4), 1.0) / exact - 1.0;
    // implicit-euler moves by a(1 + h)/2: its own first order.
    EXPECT_LT(std::abs(off[0]), 0.04) << method;
    EXPECT_LT(std::abs(off[1]), 0.6 * std::abs(off[0]) + 1e-9) << method;
  }
}

// A sheet laid on a fixed ball with much friction hangs there: it slid off by itself.
TEST(ClothFriction, ASheetStaysOnABall) {
  for (const double step : kSteps) {
    ClothScene scene = testing::sheet_and_ball({0.0, 0.0, -0.305});
    scene.options.step = step;
    scene.gravity.values = {{0.0, 0.0, -kG}};
    scene.balls[0].radius = 0.3;
    scene.balls[0].fixed = true;
    scene.balls[0].friction = scene.cloths[0].friction = 1.0;
    auto world = ClothWorld::create(scene);
    ASSERT_TRUE(world) << world.error().message;
    for (int k = 0; k < std::lround(6.0 / step); ++k) ASSERT_TRUE(world->step()) << k;
    EXPECT_GT(world->positions(0).reshaped(3, 14 * 14).row(2).mean(), -0.5) << step;
  }
}

// A ball with restitution e rises to e^2 of the height from which it fell, again and again.
TEST(ClothFriction, ABallReboundsToTheHeightOfItsRestitution) {
  for (const double restitution : {1.0, 0.9})
    for (const double step : kSteps) {
      ClothScene scene = testing::sheet_and_ball({0.0, 0.0, 1.2});
      scene.cloths[0].grid.corner = {50.0, 0.0, 50.0};
      scene.integrator = "implicit-euler";
      scene.options.step = step;
      scene.gravity.values = {{0.0, 0.0, -kG}};
      scene.balls[0].restitution = restitution;
      SceneCollider floor;
      floor.name = "floor";
      floor.shape = PlaneShape{};
      floor.restitution = restitution;
      scene.colliders = {floor};
      auto world = ClothWorld::create(scene);
      ASSERT_TRUE(world) << world.error().message;
      double energy = 0.0, bounces = 0.0, down = 0.0;
      for (int k = 0; k < std::lround(4.0 / step); ++k) {
        ASSERT_TRUE(world->step()) << k;
        const ClothWorld::Ball ball = world->balls()[0];
        if (down < 0.0 && ball.velocity.z() > 0.0) ++bounces;
        down = ball.velocity.z();
        energy = kG * (ball.position.z() - 0.2) + 0.5 * down * down;
      }
      EXPECT_GE(bounces, 3.0);
      const double exact = kG * std::pow(restitution, 2.0 * bounces);
      EXPECT_NEAR(energy, exact, 1e-9 * kG) << restitution << ", " << step;
    }
}

}  // namespace
}  // namespace tremolo
