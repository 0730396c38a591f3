// The side from which a point came into an obstacle.
#include "runtime/contact/entry_side.h"

#include <gtest/gtest.h>

namespace tremolo {
namespace {

using Eigen::Vector3d;

const Collider kPlate = BoxShape{{0.3, 0.3, 0.002}};
const PassagePoint kAbove{{0.01, 0.02, 0.004}, 0.002, Vector3d::UnitZ()};

EntrySide side_of(const Vector3d& to, const EntrySide& before = {}) {
  return side_at(kPlate, before, kAbove, to, signed_distance(kPlate, to));
}

TEST(EntrySide, CountsFromTheMiddleOfAPlateOnAndJoinsTheNearestSurfaceThere) {
  EXPECT_FALSE(side_of({0.01, 0.02, 1e-6}).counts());
  for (const double z : {-1e-6, -0.0015, -0.004, -0.5}) {
    const Vector3d to(0.05, 0.02, z);
    const EntrySide side = side_of(to);
    ASSERT_TRUE(side.counts()) << z;
    EXPECT_NEAR(side.at(to), z - 0.002, 1e-15);
    EXPECT_TRUE(is_behind(kPlate, side, to));
    EXPECT_EQ(distance_by(kPlate, side, to).normal, Vector3d::UnitZ());
  }
}

TEST(EntrySide, IsKeptBelowTheMiddleAndLeftAboveIt) {
  const EntrySide side = side_of({0.01, 0.02, -0.001});
  EXPECT_TRUE(side_of({0.02, 0.02, -0.0001}, side).counts());
  EXPECT_FALSE(side_of({0.02, 0.02, 0.0001}, side).counts());
  EXPECT_FALSE(side_of({0.02, 0.02, 0.1}, side).counts());
}

TEST(EntrySide, DoesNotCountBesideThePlate) {
  const EntrySide side = side_of({0.01, 0.02, -0.001});
  EXPECT_FALSE(is_behind(kPlate, side, {0.35, 0.02, -0.001}));
  // Around the edge: the plane of the start is not where the plate is.
  EXPECT_FALSE(side_of({0.32, 0.02, -0.01}).counts());
}

TEST(EntrySide, CountsForWhatCrossesASphereAndNotForWhatPassesIt) {
  const Collider ball = SphereShape{0.1};
  const PassagePoint top{{0.0, 0.0, 0.11}, 0.01, Vector3d::UnitZ()};
  const auto after = [&](const Vector3d& to) {
    return side_at(ball, {}, top, to, signed_distance(ball, to)).counts();
  };
  EXPECT_TRUE(after({0.0, 0.0, -0.2}));
  EXPECT_FALSE(after({0.15, 0.0, -0.05}));
}

}  // namespace
}  // namespace tremolo
