// Shapes that bodies bump into: closed forms against the nearest of many points of the surface.
#include "runtime/contact/collider.h"

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/distance_fields.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

// A shape, points of its surface no further than `spacing` from any other point of it, and what is
// inside.
struct SampledShape {
  Collider collider;
  std::vector<Vector3d> points;
  double spacing;
  std::function<bool(const Vector3d&)> is_inside;
};

constexpr int kAround = 240, kAlong = 60;

// Points of a disc with its centre on the axis, as an even lattice.
void add_disc(std::vector<Vector3d>& points, double radius, double z) {
  for (int i = -kAlong; i <= kAlong; ++i)
    for (int j = -kAlong; j <= kAlong; ++j)
      if (i * i + j * j <= kAlong * kAlong)
        points.emplace_back(radius * i / kAlong, radius * j / kAlong, z);
}

void add_ring(std::vector<Vector3d>& points, double radius, double z) {
  for (int i = 0; i < kAround; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / kAround;
    points.emplace_back(radius * std::cos(angle), radius * std::sin(angle), z);
  }
}

SampledShape sampled_cylinder(double radius, double half_length) {
  SampledShape shape{CylinderShape{radius, half_length}, {}, 0.0, {}};
  for (int k = 0; k <= kAlong; ++k)
    add_ring(shape.points, radius, half_length * (2.0 * k / kAlong - 1.0));
  add_disc(shape.points, radius, half_length);
  add_disc(shape.points, radius, -half_length);
  shape.spacing = std::hypot(0.02 * radius, 2.0 * half_length / kAlong);
  shape.is_inside = [=](const Vector3d& x) {
    return std::hypot(x.x(), x.y()) < radius && std::abs(x.z()) < half_length;
  };
  return shape;
}

SampledShape sampled_capsule(double radius, double half_length) {
  SampledShape shape{CapsuleShape{radius, half_length}, {}, 0.0, {}};
  for (int k = 0; k <= kAlong; ++k) {
    add_ring(shape.points, radius, half_length * (2.0 * k / kAlong - 1.0));
    const double angle = 0.5 * std::numbers::pi * k / kAlong;
    for (const double side : {-1.0, 1.0})
      add_ring(shape.points, radius * std::cos(angle),
               side * (half_length + radius * std::sin(angle)));
  }
  shape.spacing = std::hypot(0.02 * radius, 2.0 * half_length / kAlong);
  shape.is_inside = [=](const Vector3d& x) {
    const double beyond = std::max(0.0, std::abs(x.z()) - half_length);
    return x.head<2>().squaredNorm() + beyond * beyond < radius * radius;
  };
  return shape;
}

SampledShape sampled_sphere(double radius) {
  SampledShape shape = sampled_capsule(radius, 0.0);
  shape.collider = SphereShape{radius};
  return shape;
}

SampledShape sampled_box(const Vector3d& half) {
  SampledShape shape{BoxShape{half}, {}, 0.0, {}};
  for (int axis = 0; axis < 3; ++axis)
    for (int i = -kAlong; i <= kAlong; ++i)
      for (int j = -kAlong; j <= kAlong; ++j)
        for (const double side : {-1.0, 1.0}) {
          Vector3d x;
          x[axis] = side * half[axis];
          x[(axis + 1) % 3] = half[(axis + 1) % 3] * i / kAlong;
          x[(axis + 2) % 3] = half[(axis + 2) % 3] * j / kAlong;
          shape.points.push_back(x);
        }
  shape.spacing = half.maxCoeff() / kAlong * std::sqrt(2.0);
  shape.is_inside = [=](const Vector3d& x) { return (x.cwiseAbs().array() < half.array()).all(); };
  return shape;
}

std::vector<SampledShape> sampled_shapes() {
  return {sampled_sphere(0.7),           sampled_capsule(0.4, 0.9),  sampled_box({0.5, 0.3, 1.1}),
          sampled_box({1.0, 1.0, 0.02}), sampled_cylinder(0.6, 0.8), sampled_cylinder(0.2, 1.3),
          sampled_cylinder(1.1, 0.1)};
}

// The closed shapes and the plane.
std::vector<Collider> exact_colliders() {
  std::vector<Collider> all = {PlaneShape{}};
  for (const SampledShape& shape : sampled_shapes()) all.push_back(shape.collider);
  return all;
}

Vector3d random_point(std::mt19937& random, double size) {
  std::uniform_real_distribution<double> number(-size, size);
  const double x = number(random), y = number(random), z = number(random);
  return {x, y, z};
}

// The nearest of the points is no nearer than the surface, and no further than it and the spacing.
TEST(Collider, DistanceIsThatToTheNearestPointOfTheSurface) {
  std::mt19937 random(1);
  for (const SampledShape& shape : sampled_shapes())
    for (int trial = 0; trial < 60; ++trial) {
      const Vector3d x = random_point(random, 1.6);
      double nearest = std::numeric_limits<double>::infinity();
      for (const Vector3d& y : shape.points) nearest = std::min(nearest, (x - y).norm());
      const double distance = signed_distance(shape.collider, x).distance;
      EXPECT_EQ(distance < 0.0, shape.is_inside(x)) << shape_name(shape.collider);
      EXPECT_LE(std::abs(distance), nearest + 1e-12) << shape_name(shape.collider);
      EXPECT_GE(std::abs(distance), nearest - shape.spacing) << shape_name(shape.collider);
    }
}

TEST(Collider, SampledPointsAreOnTheSurface) {
  for (const SampledShape& shape : sampled_shapes())
    for (const Vector3d& y : shape.points)
      ASSERT_NEAR(signed_distance(shape.collider, y).distance, 0.0, 1e-15)
          << shape_name(shape.collider) << " at " << y.transpose();
}

// From a point one goes by the distance along the normal and is on the surface.
TEST(Collider, NormalLeadsToTheSurface) {
  std::mt19937 random(2);
  for (const Collider& collider : exact_colliders())
    for (int trial = 0; trial < 2000; ++trial) {
      const Vector3d x = random_point(random, 2.0);
      const CollisionDistance found = signed_distance(collider, x);
      EXPECT_NEAR(found.normal.norm(), 1.0, 1e-15);
      const Vector3d foot = x - found.distance * found.normal;
      EXPECT_NEAR(signed_distance(collider, foot).distance, 0.0, 1e-14) << shape_name(collider);
    }
}

// Both one-sided differences are checked: if they disagree the point is near a kink.
TEST(Collider, NormalIsTheGradient) {
  std::mt19937 random(3);
  constexpr double kStep = 1e-6;
  int compared = 0;
  for (const Collider& collider : exact_colliders())
    for (int trial = 0; trial < 500; ++trial) {
      const Vector3d x = random_point(random, 1.5);
      const CollisionDistance here = signed_distance(collider, x);
      for (int axis = 0; axis < 3; ++axis) {
        const Vector3d step = kStep * Vector3d::Unit(axis);
        const double ahead = signed_distance(collider, x + step).distance;
        const double behind = signed_distance(collider, x - step).distance;
        if (std::abs(ahead + behind - 2.0 * here.distance) > 1e-4 * kStep) continue;
        ++compared;
        EXPECT_NEAR((ahead - behind) / (2.0 * kStep), here.normal[axis], 2e-8)
            << shape_name(collider) << " at " << x.transpose();
      }
    }
  EXPECT_GT(compared, 11000);
}

// Centres, axes, edges, corners, both zeros, the smallest and the largest numbers.
TEST(Collider, NormalIsDefinedEverywhere) {
  const double tiny = std::numeric_limits<double>::denorm_min(), huge = 1e300;
  const double places[] = {0.0,
                           -0.0,
                           tiny,
                           -tiny,
                           1e-200,
                           1e-100,
                           0.3,
                           0.4,
                           0.5,
                           0.6,
                           0.7,
                           0.8,
                           0.9,
                           1.1,
                           -0.3,
                           -0.5,
                           1.0,
                           1.3,
                           2.0,
                           1e80,
                           1e160,
                           huge,
                           -huge,
                           std::nextafter(0.5, 1.0),
                           std::nextafter(0.3, 1.0)};
  for (const Collider& collider : exact_colliders())
    for (const double a : places)
      for (const double b : places)
        for (const double c : places) {
          const CollisionDistance found = signed_distance(collider, {a, b, c});
          ASSERT_FALSE(std::isnan(found.distance));
          ASSERT_NEAR(found.normal.norm(), 1.0, 1e-12)
              << shape_name(collider) << " at " << a << " " << b << " " << c;
        }
}

TEST(Collider, DistanceChangesNoFasterThanThePointMoves) {
  std::mt19937 random(4);
  for (const Collider& collider : exact_colliders())
    for (int trial = 0; trial < 2000; ++trial) {
      const Vector3d x = random_point(random, 1.5), y = x + random_point(random, 0.1);
      EXPECT_LE(
          std::abs(signed_distance(collider, x).distance - signed_distance(collider, y).distance),
          (x - y).norm() + 1e-15)
          << shape_name(collider);
    }
}

TEST(Collider, BoundsTouchTheSurface) {
  for (const SampledShape& shape : sampled_shapes()) {
    const BoundingBox expected = bounding_box(shape.points);
    const BoundingBox found = bounds(shape.collider);
    EXPECT_LE((found.low - expected.low).cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_LE((found.high - expected.high).cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_NEAR(largest_extent(shape.collider), (found.high - found.low).maxCoeff(), 1e-15);
  }
  const BoundingBox plane = bounds(PlaneShape{});
  EXPECT_EQ(plane.high.z(), 0.0);
  EXPECT_TRUE(std::isinf(largest_extent(PlaneShape{})));
}

TEST(Collider, BadSizesAreNamed) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto message = [](const Collider& collider) {
    const Status status = check(collider);
    EXPECT_FALSE(status);
    return status ? std::string() : status.error().message;
  };
  EXPECT_NE(message(SphereShape{0.0}).find("sphere collider: radius"), std::string::npos);
  EXPECT_NE(message(SphereShape{nan}).find("radius is nan"), std::string::npos);
  EXPECT_NE(message(CapsuleShape{-1.0, 1.0}).find("capsule"), std::string::npos);
  EXPECT_NE(message(CapsuleShape{1.0, -1.0}).find("half_length"), std::string::npos);
  EXPECT_NE(message(BoxShape{{1.0, 0.0, 1.0}}).find("half extent"), std::string::npos);
  EXPECT_NE(message(BoxShape{{1.0, nan, 1.0}}).find("nan"), std::string::npos);
  EXPECT_NE(message(CylinderShape{1.0, 0.0}).find("cylinder"), std::string::npos);
  EXPECT_NE(message(CylinderShape{1e300, 1.0}).find("radius"), std::string::npos);
  EXPECT_NE(message(GridShape{}).find("no grid"), std::string::npos);
  for (const Collider& collider : exact_colliders()) EXPECT_TRUE(check(collider));
  EXPECT_TRUE(check(CapsuleShape{1.0, 0.0}));
}

// The first of 20 000 points along the path that is inside.
std::optional<double> first_place_inside(const Collider& collider, const Vector3d& from,
                                         const Vector3d& to) {
  constexpr int kPlaces = 20000;
  for (int i = 0; i <= kPlaces; ++i) {
    const double at = static_cast<double>(i) / kPlaces;
    if (signed_distance(collider, from + at * (to - from)).distance <= 0.0) return at;
  }
  return std::nullopt;
}

TEST(ColliderSweep, FindsTheFirstPlaceInside) {
  std::mt19937 random(5);
  int hits = 0;
  for (const Collider& collider : exact_colliders())
    for (int trial = 0; trial < 40; ++trial) {
      const Vector3d from = random_point(random, 2.0), to = random_point(random, 2.0);
      const std::optional<double> found = first_hit(collider, from, to);
      const std::optional<double> walked = first_place_inside(collider, from, to);
      if (walked) {
        ++hits;
        ASSERT_TRUE(found) << shape_name(collider);
        EXPECT_LE(*found, *walked + 1e-12);
        EXPECT_GE(*found, *walked - 1.0 / 20000 - 1e-12);
      } else if (found) {
        EXPECT_NEAR(signed_distance(collider, from + *found * (to - from)).distance, 0.0, 1e-14);
      }
    }
  EXPECT_GT(hits, 80);
}

// Both ends are outside, and the plate is a thousandth of the path, or a millionth.
TEST(ColliderSweep, DoesNotPassThroughThinPlates) {
  std::mt19937 random(6);
  for (const double thickness : {1e-3, 1e-6, 1e-12})
    for (const Collider& plate : {Collider(BoxShape{{5.0, 5.0, 0.5 * thickness}}),
                                  Collider(CylinderShape{5.0, 0.5 * thickness})})
      for (int trial = 0; trial < 1000; ++trial) {
        Vector3d from = random_point(random, 1.0), to = random_point(random, 1.0);
        from.z() = 0.5 + std::abs(from.z());
        to.z() = -0.5 - std::abs(to.z());
        const std::optional<double> at = first_hit(plate, from, to);
        ASSERT_TRUE(at);
        const double z = from.z() + *at * (to.z() - from.z());
        EXPECT_NEAR(z, 0.5 * thickness, 4e-15);
      }
}

TEST(ColliderSweep, FindsALevelOfTheDistance) {
  const Collider ball = SphereShape{0.5};
  EXPECT_NEAR(*first_hit(ball, {2, 0, 0}, {0, 0, 0}, 0.25), 0.625, 1e-15);
  EXPECT_NEAR(*first_hit(ball, {2, 0, 0}, {-2, 0, 0}, -0.25), 0.4375, 1e-15);
  EXPECT_FALSE(first_hit(ball, {2, 0, 0}, {1, 0, 0}));
  EXPECT_FALSE(first_hit(ball, {2, 0.6, 0}, {-2, 0.6, 0}));
  EXPECT_TRUE(first_hit(ball, {2, 0.6, 0}, {-2, 0.6, 0}, 0.11));
}

TEST(ColliderSweep, BeginsAtZeroInsideAndStandsStillOutside) {
  for (const Collider& collider : exact_colliders()) {
    EXPECT_EQ(first_hit(collider, {0, 0, -0.001}, {3, 3, 3}), 0.0) << shape_name(collider);
    EXPECT_EQ(first_hit(collider, {0, 0, -0.001}, {0, 0, -0.001}), 0.0);
    EXPECT_EQ(first_hit(collider, {0, 0, 3}, {0, 0, 3}), std::nullopt);
    EXPECT_EQ(first_hit(collider, {0, 0, 3}, {0, 0, 1e9}), std::nullopt);
  }
}

// Along the surface and away from it there is nothing to hit, towards it there is.
TEST(ColliderSweep, KnowsTouchingFromCrossing) {
  const Collider box = BoxShape{{1.0, 1.0, 1.0}};
  EXPECT_FALSE(first_hit(box, {-3, 0, 1.0 + 1e-9}, {3, 0, 1.0 + 1e-9}));
  EXPECT_NEAR(*first_hit(box, {-3, 0, 1.0 - 1e-9}, {3, 0, 1.0 - 1e-9}), 1.0 / 3.0, 1e-14);
  const Collider ball = SphereShape{1.0};
  EXPECT_FALSE(first_hit(ball, {-3, 0, 1.0 + 1e-12}, {3, 0, 1.0 + 1e-12}));
  EXPECT_NEAR(*first_hit(ball, {-3, 0, 1.0 - 1e-12}, {3, 0, 1.0 - 1e-12}), 0.5, 1e-6);
}

Collider grid_collider(std::uint32_t cells, const testing::DistanceFormula& formula) {
  return GridShape{std::make_shared<const DistanceGrid>(
      testing::grid_of(testing::cube_of_nodes(1.5, cells), formula))};
}

TEST(GridCollider, AnswersAsItsGrid) {
  const Collider collider = grid_collider(24, testing::torus_formula(0.9, 0.4));
  const DistanceGrid& grid = *std::get<GridShape>(collider).grid;
  EXPECT_TRUE(check(collider));
  std::mt19937 random(12);
  for (int trial = 0; trial < 1000; ++trial) {
    const Vector3d x = random_point(random, 2.0);
    const CollisionDistance found = signed_distance(collider, x);
    EXPECT_EQ(found.distance, grid.at(x).distance);
    EXPECT_EQ(found.normal, grid.at(x).gradient);
    const Vector3d y = x + random_point(random, 0.05);
    // The steps of the sweep rely on this.
    EXPECT_LE(std::abs(signed_distance(collider, y).distance - found.distance),
              1.5 * (x - y).norm());
  }
  EXPECT_EQ(bounds(collider).high, grid.solid_box().high);
  EXPECT_GT(largest_extent(collider), 2.6);
}

// A plate of two cells, crossed in one step of many times its thickness, and a torus.
TEST(GridCollider, SweepFindsTheFirstPlaceInside) {
  std::mt19937 random(13);
  int hits = 0;
  for (const Collider& collider : {grid_collider(48, testing::box_formula({1.0, 1.1, 0.06})),
                                   grid_collider(48, testing::torus_formula(0.9, 0.4))})
    for (int trial = 0; trial < 100; ++trial) {
      const Vector3d from = random_point(random, 2.0), to = random_point(random, 2.0);
      const std::optional<double> found = first_hit(collider, from, to);
      const std::optional<double> walked = first_place_inside(collider, from, to);
      if (walked) {
        ++hits;
        ASSERT_TRUE(found);
        EXPECT_LE(*found, *walked + 1e-12);
        EXPECT_GE(*found, *walked - 1.0 / 20000 - 1e-12);
      } else if (found) {
        EXPECT_NEAR(signed_distance(collider, from + *found * (to - from)).distance, 0.0, 1e-6);
      }
      if (found && *found > 0.0) {
        EXPECT_LE(signed_distance(collider, from + *found * (to - from)).distance, 0.0);
      }
    }
  EXPECT_GT(hits, 60);
}

}  // namespace
}  // namespace tremolo
