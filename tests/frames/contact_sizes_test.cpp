// Shapes that do not fit their bodies, and bodies with very few contact points.
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "runtime/contact/islands/body_group.h"
#include "runtime/contact/solve/contact_step.h"
#include "runtime/contact/solve/shape_reach.h"
#include "runtime/contact_body.h"
#include "tests/support/distance_fields.h"
#include "tests/support/frames/corner_cube.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

using testing::corner_cube;

constexpr double kHalf = testing::kCubeHalf;

// Closed forms of the support functions, with the cube's h(n) = a (|x| + |y| + |z|).
TEST(ShapeReach, IsTheDifferenceOfTheHulls) {
  const Model::Pointer cube = corner_cube();
  const double a = kHalf;
  const auto reach = [&](const Collider& shape) { return shape_beyond(*cube, shape).distance; };
  EXPECT_NEAR(reach(SphereShape{a + 0.02}), 0.02, 1e-15);
  EXPECT_NEAR(reach(SphereShape{a - 0.02}), -0.02, 1e-15);
  EXPECT_NEAR(reach(BoxShape{Vector3d::Constant(a + 0.01)}), 0.01 * std::sqrt(3.0), 1e-15);
  EXPECT_NEAR(reach(BoxShape{{a, a, a + 0.03}}), 0.03, 1e-15);
  EXPECT_NEAR(reach(CapsuleShape{0.1, a}), 0.1, 1e-15);
  EXPECT_NEAR(reach(CapsuleShape{a + 0.04, 0.0}), 0.04, 1e-15);
  EXPECT_NEAR(reach(CylinderShape{a, a + 0.05}), 0.05, 1e-15);
  EXPECT_NEAR(reach(CylinderShape{a + 0.06, a}), 0.06, 1e-15);
  EXPECT_EQ(reach(PlaneShape{}), std::numeric_limits<double>::infinity());
  EXPECT_NEAR(shape_beyond(*cube, BoxShape{{a, a, a + 0.03}}).direction.cwiseAbs().z(), 1.0, 1e-15);
  EXPECT_DOUBLE_EQ(shape_beyond(*cube, SphereShape{1.0}).size, 2.0 * a);
  // A ball of radius 1 m on a grid with a spacing of an eighth, of which the distances to its
  // smooth surface have an error of third order.
  const GridNodes nodes = testing::cube_of_nodes(1.5, 24);
  Result<DistanceGrid> grid =
      DistanceGrid::create(nodes, testing::values_at_nodes(nodes, testing::sphere_formula(1.0)));
  ASSERT_TRUE(grid);
  const GridShape ball{std::make_shared<const DistanceGrid>(std::move(*grid))};
  EXPECT_NEAR(reach(ball), 1.0 - a, 1e-3);
}

// A shape of other units, or a plane, is refused with its sizes; one that is 20 % larger is not.
TEST(ShapeReach, AShapeFarBeyondItsBodyIsRefused) {
  const Model::Pointer cube = corner_cube();
  ContactBody body = testing::make_framed(cube, FrameKind::kFree, {});
  const auto with = [](const Collider& shape) {
    ContactOptions options;
    options.shape = shape;
    return options;
  };
  EXPECT_TRUE(body.set_contact(with(SphereShape{1.2 * kHalf})));
  for (const Collider& shape :
       {Collider(SphereShape{50.0}), Collider(PlaneShape{}), Collider(BoxShape{{0.1, 0.1, 1.6}})}) {
    const Status refused = body.set_contact(with(shape));
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().kind, ErrorKind::kContent);
    EXPECT_NE(refused.error().message.find("beyond the body"), std::string::npos);
  }
  EXPECT_NE(body.set_contact(with(SphereShape{50.0})).error().message.find("49.5 m"),
            std::string::npos);
}

// Bodies whose shapes are larger than themselves fly into each other: they are found before they
// touch, so that energy and momentum close as those of shapes that fit.
TEST(ShapeReach, BodiesWithLargerShapesKeepTheirEnergy) {
  const Model::Pointer cube = corner_cube();
  for (const double radius : {1.5 * kHalf, 2.2 * kHalf, 2.98 * kHalf}) {
    std::vector<ContactBody> bodies;
    for (const double x : {-1.5, 1.5}) {
      bodies.push_back(testing::make_framed(cube, FrameKind::kFree, {.step = 1e-3}));
      ContactOptions options;
      options.shape = SphereShape{radius};
      options.restitution = 1.0;
      options.friction = 0.0;
      ASSERT_TRUE(bodies.back().set_contact(options));
      Pose pose;
      pose.position.x() = x;
      ASSERT_TRUE(bodies.back().set_pose(pose));
      ASSERT_TRUE(bodies.back().set_motion({-x, 0.0, 0.0}, {0.0, 0.3, 0.2}));
    }
    const std::array<ContactBody*, 2> both = {&bodies[0], &bodies[1]};
    std::array<StepReport, 2> reports;
    BodyGroup group;
    const auto energy = [&] {
      double sum = 0.0;
      for (const ContactBody* body : both)
        sum += body->energy().total() + body->contact_account().energy;
      return sum;
    };
    const double start = energy();
    double worst = 0.0;
    for (int k = 0; k < 1'500; ++k) {
      group.step(both, {}, reports);
      ASSERT_TRUE(reports[0].converged && reports[1].converged) << radius << " " << k;
      worst = std::max(worst, std::abs(energy() - start));
    }
    EXPECT_GT(bodies[1].momentum().linear.x(), 0.0) << "they met";
    EXPECT_LT(worst, 1e-7 * start) << radius;  // the solve's 1e-10 of the momenta a step
  }
}

// However few its points, a body has its margin by the size of the whole boundary.
TEST(FewContactPoints, ABodyOfOnePointBouncesAndTheAccountCloses) {
  const Model::Pointer cube = corner_cube();
  for (const int points : {1, 2, 3, 8}) {
    ContactBody body = testing::make_framed(cube, FrameKind::kFree, {.step = 1e-3});
    ContactOptions options;
    options.points = points;
    ASSERT_TRUE(body.set_contact(options));
    EXPECT_EQ(body.contact()->surface().points->size(), static_cast<std::size_t>(points));
    EXPECT_DOUBLE_EQ(body.contact()->surface().points->extent, 2.0 * kHalf);
    ASSERT_TRUE(body.set_gravity({0.0, 0.0, -9.81}));
    Pose pose;
    pose.position.z() = kHalf + 0.1;
    ASSERT_TRUE(body.set_pose(pose));
    ASSERT_TRUE(body.set_motion({0.0, 0.0, 0.0}, {0.1, 0.2, 0.0}));
    const std::vector<PlacedCollider> floor(1);
    const VertexId first = body.contact()->surface().points->ids.front();
    const double start = body.energy().total();
    double deepest = 0.0, worst = 0.0, most = 0.0;
    for (int k = 0; k < 500; ++k) {
      ASSERT_TRUE(body.step(floor).converged) << points << " " << k;
      deepest = std::min(deepest, body.position(first)->z());
      const double energy = body.energy().total();
      most = std::max({most, energy, std::abs(body.sums().gravity)});
      worst = std::max(worst, std::abs(energy - start - body.sums().work + body.sums().dissipated));
    }
    EXPECT_LT(body.contact_sums().lost, most);
    EXPECT_GT(body.contact_sums().lost, 0.0) << points << ": it touched the floor";
    EXPECT_GT(deepest, -0.005 * 2.0 * kHalf) << points << ": within the margin";
    EXPECT_LT(worst, 1e-8 * most) << points;
  }
}

}  // namespace
}  // namespace tremolo
