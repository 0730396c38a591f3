// The side from which a point came into an obstacle.
#include "runtime/contact/entry_side.h"

#include <gtest/gtest.h>

namespace tremolo {
namespace {

using Eigen::Vector3d;

const Collider kPlate = BoxShape{{0.3, 0.3, 0.002}};
const PassagePoint kAbove{{0.01, 0.02, 0.004}, 0.002, Vector3d::UnitZ()};

EntrySide side_of(const Vector3d& to, const EntrySide& before = {}) {
  return side_at(kPlate, before, kAbove, to, signed_distance(kPlate, to), Vector3d::UnitZ());
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
    return side_at(ball, {}, top, to, signed_distance(ball, to), Vector3d::UnitZ()).counts();
  };
  EXPECT_TRUE(after({0.0, 0.0, -0.2}));
  EXPECT_FALSE(after({0.15, 0.0, -0.05}));
}

// A corner of a cube on the upper edge of another of the same size, whose sides are flush.
TEST(EntrySide, OnAnEdgeIsThatOfTheFaceOnWhichTheBodyIs) {
  const Collider cube = BoxShape{{0.05, 0.05, 0.05}};
  const Vector3d edge(0.05, 0.02, 0.05);
  const CollisionDistance found = signed_distance(cube, edge);
  const Vector3d above = Vector3d(-1.0, -0.4, 1.0).normalized();   // the body is on top
  const Vector3d beside = Vector3d(1.0, -0.4, -1.0).normalized();  // it is at the side
  const auto normal_from = [&](const Vector3d& inward) {
    const EntrySide side = side_on_edge(cube, edge, found, inward);
    return side.counts() ? side.normal : found.normal;
  };
  EXPECT_EQ(normal_from(above), Vector3d::UnitZ());
  EXPECT_EQ(normal_from(beside), Vector3d::UnitX());
  EXPECT_FALSE(side_on_edge(cube, edge, found, Vector3d::Zero()).counts());

  const PassagePoint from{{0.05, 0.02, 0.051}, 0.001, Vector3d::UnitZ()};
  const Vector3d to(0.05, 0.02, 0.0499);  // 0.1 mm deep, and not at all below the side
  const auto counts = [&](const Vector3d& point, const Vector3d& inward) {
    return side_at(cube, {}, from, point, signed_distance(cube, point), inward).counts();
  };
  EXPECT_TRUE(counts(to, above));
  EXPECT_TRUE(counts(to + Vector3d(2e-6, 0.0, 0.0), above));  // beside it by rounding
  EXPECT_FALSE(counts(to + Vector3d(1e-4, 0.0, 0.0), above));
  EXPECT_FALSE(counts(to, beside));
  EXPECT_FALSE(counts(to, Vector3d::Zero()));
}

}  // namespace
}  // namespace tremolo
