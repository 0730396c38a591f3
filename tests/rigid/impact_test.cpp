// The length of the parts in which hard impacts are resolved.
#include "runtime/contact/impact.h"

#include <algorithm>
#include <array>
#include <vector>

#include <gtest/gtest.h>

namespace tremolo {
namespace {

using Eigen::Vector3d;

constexpr double kStep = 1e-2, kMargin = 1e-3;

ContactLaw law() {
  ContactLaw law;
  law.stiffness = 1e9;
  law.margin = law.begins = kMargin;
  law.rebound_speed = 0.01;
  return law;
}

// A point of body a on b, or on a collider, that deep in the margin.
ImpactPoint touch(std::size_t a, std::size_t b, const Vector3d& normal, double depth) {
  ImpactPoint point;
  point.a = a;
  point.b = b;
  point.law = law();
  point.distance = kMargin - depth;
  point.energy = point.law.energy(point.distance);
  point.normal = normal;
  return point;
}

// Of `count` bodies the first hits the second at 1 m/s along x; `others` touch meanwhile.
double longest(std::size_t count, const std::vector<ImpactPoint>& others) {
  std::vector<ImpactBody> bodies(count);
  for (ImpactBody& body : bodies) body.mass = 0.1;
  bodies[0].velocity.x() = 1.0;
  std::vector<ImpactPoint> points = {touch(0, 1, -Vector3d::UnitX(), 1e-5)};
  points.insert(points.end(), others.begin(), others.end());
  return longest_for_impacts(bodies, points, kStep, false);
}

// The finest part depends on the pull alone, which a collider below does not change along x.
TEST(Impacts, AreFineWhereBodiesReboundAlone) {
  const double alone = longest(6, {});
  const ImpactPoint floor = touch(0, ImpactPoint::kCollider, Vector3d::UnitZ(), 1e-5);
  EXPECT_LT(alone, kStep);
  EXPECT_DOUBLE_EQ(longest(6, {floor}), alone);
  EXPECT_DOUBLE_EQ(longest(5, {}), alone);
}

// A body that is pushed from behind has no rebound of its own: parts are four to eight times as
// long, in islands of more than five bodies, whatever the order of the pairs and of their bodies.
TEST(Impacts, AreCoarseWhereBodiesArePushed) {
  const std::array<ImpactPoint, 2> pushes = {touch(0, 2, Vector3d::UnitX(), 1e-5),
                                             touch(2, 0, -Vector3d::UnitX(), 1e-5)};
  for (const ImpactPoint& push : pushes) {
    const double fine = longest(5, {push}), coarse = longest(6, {push});
    EXPECT_GT(coarse, 3.9 * fine);
    EXPECT_LT(coarse, 8.1 * fine);
    EXPECT_LT(coarse, kStep);
  }
  const ImpactPoint ahead = touch(1, 3, -Vector3d::UnitX(), 1e-5);
  EXPECT_GT(longest(6, {ahead}), 3.9 * longest(5, {ahead}));
}

}  // namespace
}  // namespace tremolo
