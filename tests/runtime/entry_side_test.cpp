// The side from which a point came into an obstacle.
#include "runtime/contact/entry_side.h"

#include <tuple>

#include <gtest/gtest.h>

namespace tremolo {
namespace {

using Eigen::Vector3d;

const Collider kPlate = BoxShape{{0.3, 0.3, 0.002}};
const PassagePoint kAbove{{0.01, 0.02, 0.004}, 0.002, Vector3d::UnitZ()};

EntrySide side_of(const Vector3d& to, const EntrySide& before = {}) {
  return side_at(kPlate, before, kAbove, to, signed_distance(kPlate, to), Vector3d::UnitZ(), 0.001);
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
    return side_at(ball, {}, top, to, signed_distance(ball, to), Vector3d::UnitZ(), 0.001).counts();
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
    return side_at(cube, {}, from, point, signed_distance(cube, point), inward, 0.001).counts();
  };
  EXPECT_TRUE(counts(to, above));
  EXPECT_TRUE(counts(to + Vector3d(2e-6, 0.0, 0.0), above));  // beside it by rounding
  EXPECT_FALSE(counts(to + Vector3d(1e-4, 0.0, 0.0), above));
  EXPECT_FALSE(counts(to, beside));
  EXPECT_FALSE(counts(to, Vector3d::Zero()));
}

// A point that slides over the edge as it comes out stays under the plane of its face, for four
// times its largest depth, until it is where contact begins.
TEST(EntrySide, GoesOnBeyondAnEdge) {
  const Collider cube = BoxShape{{0.05, 0.05, 0.05}};
  const Vector3d inward = Vector3d(-1.0, -0.4, 1.0).normalized();
  const auto side_from = [&](const EntrySide& before, const PassagePoint& from,
                             const Vector3d& to) {
    return side_at(cube, before, from, to, signed_distance(cube, to), inward, 0.001);
  };
  const PassagePoint above{{0.0495, 0.02, 0.051}, 0.001, Vector3d::UnitZ()};
  const Vector3d deepest(0.0499, 0.02, 0.049);
  const EntrySide side = side_from({}, above, deepest);
  ASSERT_TRUE(side.counts());
  EXPECT_NEAR(side.beyond, 0.004, 1e-12);
  const PassagePoint from{deepest, side.at(deepest), side.normal};
  for (const auto& [x, z, held] :
       {std::tuple{0.0539, 0.0492, true}, {0.0545, 0.0492, false}, {0.0539, 0.0509, true}}) {
    const Vector3d to(x, 0.02, z);
    const EntrySide after = side_from(side, from, to);
    ASSERT_TRUE(after.counts());
    EXPECT_EQ(is_behind(cube, after, to), held) << x << ", " << z;
    EXPECT_FALSE(is_through(cube, after, to));
  }
  EXPECT_FALSE(side_from(side, from, {0.0539, 0.02, 0.0511}).counts());
}

}  // namespace
}  // namespace tremolo
