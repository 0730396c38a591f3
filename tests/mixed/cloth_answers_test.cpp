// Known answers of cloth in contact with bodies of other kinds: weights, slopes, the bits of a
// sheet that nothing is near, refusals.
#include <algorithm>
#include <cmath>

#include "runtime/bodies/cloth/cloth_world.h"
#include "tests/mixed/cloth_bodies.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;
using testing::MixedKind;
using testing::MixedWorld;
using testing::Sheet;

constexpr double kSheetGravity = 9.81;

PlacedCollider sheet_plane(double friction, double restitution = 0.5) {
  PlacedCollider floor;
  floor.shape = PlaneShape{};
  floor.friction = friction;
  floor.restitution = restitution;
  return floor;
}

MixedKind at_rest() {
  return {.step = 2e-3, .restitution = 0.0, .friction = 0.5, .gravity = {0, 0, -kSheetGravity}};
}

TEST(ClothOnATable, CarriesItsWeightOnAColliderAndOnABody) {
  const MixedKind kind = at_rest();
  for (const bool on_body : {false, true}) {
    MixedWorld world(kind.step);
    const PlacedCollider floor = sheet_plane(0.5, 0.0);
    world.set_colliders({&floor, 1});
    Sheet sheet{.middle = {0, 0, 0.004}};
    if (on_body) {
      ContactBody table = testing::reduced_body(testing::reduced_cube("1e5"), kind, {0, 0, 0.0503});
      ASSERT_TRUE(table.set_damping(30.0, 5e-3));
      ASSERT_TRUE(world.add("table", std::move(table)));
      sheet.width = 0.09;
      sheet.middle.z() = 0.104;
    }
    const Result<std::size_t> number = world.add(testing::sheet_body(sheet, kind));
    ASSERT_TRUE(number) << number.error().message;
    for (int i = 0; i < 400; ++i) {
      const Status made = world.step();
      ASSERT_TRUE(made) << i << made.error().message;
    }
    const double weight = kSheetGravity * sheet.density * sheet.width * sheet.width;
    const Vector3d force = world.account(*number).impulse_vector / kind.step;
    EXPECT_NEAR(force.z(), weight, 1e-3 * weight) << on_body;
    EXPECT_LT(force.head<2>().norm(), 1e-3 * weight);
    // No particle is below the surface: all are within the thickness above it.
    EXPECT_EQ(world.penetration_max(*number), 0.0);
  }
}

// Gravity is tilted instead of the floor. Returns the mean velocity, m/s.
Vector3d sheet_speed_on_slope(double friction, double slope, double seconds, double step = 1e-3) {
  const double angle = std::atan(0.3) * slope;
  const MixedKind kind{
      .step = step,
      .restitution = 0.0,
      .friction = friction,
      .gravity = {kSheetGravity * std::sin(angle), 0, -kSheetGravity * std::cos(angle)}};
  MixedWorld world(kind.step);
  EXPECT_TRUE(world.add(testing::sheet_body({.middle = {0, 0, 0.004}}, kind)));
  const PlacedCollider floor = sheet_plane(friction, 0.0);
  world.set_colliders({&floor, 1});
  for (int i = 0; i < static_cast<int>(std::lround(seconds / kind.step)); ++i) {
    const Status made = world.step();
    EXPECT_TRUE(made) << i << made.error().message;
    if (!made) break;
  }
  return world.cloth(0)->momenta().linear / world.cloth(0)->mass();
}

TEST(ClothOnASlope, SticksBelowTheAngleOfFrictionAndSlidesAboveIt) {
  EXPECT_LT(sheet_speed_on_slope(0.3, 0.95, 0.6).norm(), 1e-6);  // m/s; the end of the elastic ring
  const double angle = 1.5 * std::atan(0.3);
  const double slide = kSheetGravity * (std::sin(angle) - 0.3 * std::cos(angle));
  for (const double step : {2e-3, 1e-3}) {
    const double early = sheet_speed_on_slope(0.3, 1.5, 0.2, step).x();
    const double late = sheet_speed_on_slope(0.3, 1.5, 0.5, step).x();
    EXPECT_NEAR((late - early) / 0.3, slide, 5e-3 * slide) << step;
  }
}

// A stiff sheet falls 2 cm onto a ball that nothing moves: no more moves than it fell through.
TEST(ClothOnABall, GainsNoEnergyUnderAnyMethod) {
  for (const char* method : {"implicit-euler", "midpoint", "energy"})
    for (const double step : {1.0 / 60.0, 4e-3}) {
      const MixedKind kind{.step = step, .friction = 0.3, .gravity = {0, 0, -kSheetGravity}};
      MixedWorld world(kind.step);
      PlacedCollider ball;
      ball.shape = SphereShape{0.05};
      ball.friction = 0.3;
      world.set_colliders({&ball, 1});
      ASSERT_TRUE(world.add(testing::sheet_body({.integrator = method,
                                                 .width = 0.2,
                                                 .middle = {0, 0, 0.07},
                                                 .structural = {1000.0, 0.02},
                                                 .shear = {1000.0, 0.02},
                                                 .bend = {1000.0, 0.02}},
                                                kind)));
      const ClothBody& sheet = *world.cloth(0);
      const double most = 2.0 * sheet.mass() * kSheetGravity * 0.07;
      for (int i = 0; i < static_cast<int>(std::lround(0.4 / step)); ++i) {
        const Status made = world.step();
        ASSERT_TRUE(made) << method << i << made.error().message;
        double moving = 0.0;
        for (Eigen::Index k = 0; k < sheet.model().mass().size(); ++k)
          moving += 0.5 * sheet.model().mass()[k] * sheet.state().v.segment<3>(3 * k).squaredNorm();
        ASSERT_LE(moving, most) << method << " " << step << " " << i;
      }
    }
}

TEST(ClothAmongBodies, ThatTouchesNothingStepsToTheSameBitsAsInItsOwnScene) {
  const MixedKind kind{.step = 4e-3, .friction = 0.3, .gravity = {0, 0, -kSheetGravity}};
  for (const char* method : {"implicit-euler", "midpoint", "energy"}) {
    ClothScene scene = testing::sheet_scene({.integrator = method}, kind);
    scene.wind = {2, 1, 0};
    scene.gust = 0.5;
    scene.cloths[0].drag = 1.2;
    scene.cloths[0].crumple = 0.1;
    ClothPin pin{.particles = {0, 8}, .motion = {}, .until = 0.1};
    scene.cloths[0].pins = {pin};
    Result<ClothWorld> alone = ClothWorld::create(scene);
    ASSERT_TRUE(alone) << alone.error().message;
    Result<ClothBody> body = ClothBody::create(scene);
    ASSERT_TRUE(body) << body.error().message;
    MixedWorld world(kind.step);
    ASSERT_TRUE(world.add(
        "far", testing::reduced_body(testing::reduced_cube("1e5"), kind, {0, 0, -2000.0})));
    ASSERT_TRUE(world.add(std::move(*body)));
    for (int i = 0; i < 50; ++i) {
      ASSERT_TRUE(world.step());
      ASSERT_TRUE(alone->step());
      EXPECT_EQ(world.in_islands(), 0U);
    }
    EXPECT_EQ(world.cloth(1)->state().x, alone->positions(0)) << method;
    EXPECT_EQ(world.cloth(1)->state().v, alone->velocities(0)) << method;
    EXPECT_NEAR(world.cloth(1)->work().wind, alone->energy().wind, 1e-12);
    EXPECT_NEAR(world.cloth(1)->work().pins, alone->energy().pins, 1e-12);
  }
}

TEST(ClothAmongBodies, IsRefusedByName) {
  const MixedKind kind;
  const auto refusal = [](const Sheet& sheet, const MixedKind& of, double step,
                          const ContactOptions& contact) {
    MixedWorld world(step);
    const Result<std::size_t> added = world.add(testing::sheet_body(sheet, of), contact);
    EXPECT_FALSE(added);
    return added ? std::string() : added.error().message;
  };
  const auto names = [](const std::string& text, const std::string& words) {
    return text.find("'sheet'") != std::string::npos && text.find(words) != std::string::npos;
  };
  EXPECT_PRED2(names, refusal({}, kind, 2e-3, {}), "its step is");
  EXPECT_PRED2(names, refusal({.thickness = 0.0}, kind, kind.step, {}), "thickness");
  EXPECT_PRED2(names, refusal({.integrator = "bdf2"}, kind, kind.step, {}), "bdf2");
  EXPECT_PRED2(names, refusal({}, kind, kind.step, {.stiffness = -1.0}), "stiffness");
}

}  // namespace
}  // namespace tremolo
