// A sheet of cloth and a body of another kind in contact: momenta, energy, shorter steps.
#include <cmath>

#include "tests/mixed/cloth_bodies.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;
using testing::MixedKind;
using testing::MixedWorld;
using testing::Sheet;

// The sheet arrives from above, at an angle.
Sheet thrown(const char* integrator) {
  return {.integrator = integrator, .middle = {0.02, -0.01, 0.062}, .velocity = {0.3, 0.1, -1.5}};
}

TEST(ClothAndAReducedBody, KeepBothMomentaAndTheEnergyOfThePair) {
  for (const char* integrator : {"energy", "midpoint", "implicit-euler"})
    for (const double friction : {0.0, 0.5}) {
      const MixedKind kind{.friction = friction};
      MixedWorld world(kind.step);
      ContactBody reduced = testing::reduced_body(testing::reduced_cube("1e5"), kind, {0, 0, 0});
      ASSERT_TRUE(reduced.set_motion({0, 0, 0.2}, {0.3, 0.5, -1}));
      ASSERT_TRUE(world.add("cube", std::move(reduced)));
      ASSERT_TRUE(world.add(testing::sheet_body(thrown(integrator), kind)));
      const testing::WorstErrors worst = testing::follow(world, 120);
      EXPECT_GT(worst.touched, 50);
      // Sums of 0.3 kg m/s and 0.01 N m s: solved to 1e-10 of the forces in each step.
      EXPECT_LT(worst.linear, 1e-10) << integrator;
      if (std::string(integrator) != "implicit-euler") {  // which damps it in any case
        EXPECT_LT(worst.angular, 1e-11) << integrator;
      }
      EXPECT_LT(worst.energy, 1e-6 * worst.start) << integrator;
    }
}

TEST(ClothAndTetrahedra, KeepBothMomentaAndTheEnergyOfThePair) {
  const TetModelPointer model = testing::tets_cube(1e5, 2);
  const TetHullPointer hull = testing::cube_hull(model);
  for (const double friction : {0.0, 0.5}) {
    const MixedKind kind{.friction = friction};
    MixedWorld world(kind.step);
    TetBody tets = testing::tets_body(model, kind, {0, 0, 0}, {0, 0, 0.2}, {0.3, 0.5, -1});
    ASSERT_TRUE(world.add("cube", std::move(tets),
                          testing::contact_of(kind, Eigen::Vector3d::Ones()), hull));
    ASSERT_TRUE(world.add(testing::sheet_body(thrown("energy"), kind)));
    const testing::WorstErrors worst = testing::follow(world, 120);
    EXPECT_GT(worst.touched, 50);
    EXPECT_LT(worst.linear, 1e-10);
    EXPECT_LT(worst.angular, 1e-11);
    EXPECT_LT(worst.energy, 1e-6 * worst.start);
  }
}

// Velocity of a cube after a sheet has fallen on it, m/s.
double sheet_speed_after_blow(double step) {
  const MixedKind kind{.step = step};
  MixedWorld world(step);
  EXPECT_TRUE(
      world.add("cube", testing::reduced_body(testing::reduced_cube("1e5"), kind, {0, 0, 0})));
  const Sheet sheet{.integrator = "energy",
                    .particles = 5,
                    .width = 0.08,
                    .density = 20.0,
                    .middle = {0, 0, 0.058},
                    .velocity = {0, 0, -1.0}};
  EXPECT_TRUE(world.add(testing::sheet_body(sheet, kind)));
  const int steps = static_cast<int>(std::lround(0.03 / step));
  for (int i = 0; i < steps; ++i) {
    const Status made = world.step();
    EXPECT_TRUE(made) << made.error().message;
    if (!made) break;
  }
  EXPECT_EQ(world.account(1).active, 0);
  return world.reduced(0)->rigid_state().velocity.z();
}

TEST(ClothAndAReducedBody, SettleAsTheStepIsHalved) {
  const double whole = sheet_speed_after_blow(4e-4), half = sheet_speed_after_blow(2e-4),
               quarter = sheet_speed_after_blow(1e-4), eighth = sheet_speed_after_blow(5e-5);
  RecordProperty("speeds", ::testing::PrintToString(std::vector{whole, half, quarter, eighth}));
  const double first = std::abs(whole - quarter), second = std::abs(half - eighth);
  EXPECT_GT(first, 2.0 * second);
  EXPECT_NEAR(quarter, eighth, 2e-4);
}

}  // namespace
}  // namespace tremolo
