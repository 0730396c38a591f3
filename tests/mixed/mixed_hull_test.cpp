// Points of other bodies on the surface of a body of tetrahedra: momenta, energy, a weight at rest.
#include <algorithm>
#include <cmath>

#include "runtime/mixed/hull_contact.h"
#include "tests/mixed/mixed_bodies.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;
using testing::MixedKind;
using testing::MixedSum;
using testing::MixedWorld;

// Losses of a pair in a blow: its momenta must be as before, and its energy too, except for the
// part that restitution, friction and the bodies' own method took.
struct Losses {
  double linear = 0.0, angular = 0.0, energy = 0.0, start = 0.0;
  int touched = 0;
};

Losses losses_of(MixedWorld& world, int steps) {
  const MixedSum start = testing::sum_of(world);
  Losses losses;
  losses.start = start.energy;
  double taken = 0.0, own = 0.0;
  for (int i = 0; i < steps; ++i) {
    double before = 0.0;
    for (std::size_t k = 0; k < world.size(); ++k)
      if (TetBody* body = world.tets(k)) before += body->kinetic_energy() + body->elastic_energy();
    const Status made = world.step();
    EXPECT_TRUE(made) << i << made.error().message;
    if (!made) break;
    own -= before;
    for (std::size_t k = 0; k < world.size(); ++k) {
      const ContactAccount account = world.account(k);
      taken += account.lost + account.friction_loss;
      losses.touched += account.active;
      if (TetBody* body = world.tets(k))
        own += body->kinetic_energy() + body->elastic_energy() - account.work;
    }
    const MixedSum now = testing::sum_of(world);
    losses.linear = std::max(losses.linear, (now.linear - start.linear).norm());
    losses.angular = std::max(losses.angular, (now.angular - start.angular).norm());
    losses.energy = std::max(losses.energy, std::abs(now.energy + taken - own - start.energy));
  }
  return losses;
}

void expect_kept(const Losses& losses) {
  EXPECT_GT(losses.touched, 5);
  // Sums of 1 kg m/s and 0.1 N m s: solved to 1e-10 of the forces in each step.
  EXPECT_LT(losses.linear, 1e-10);
  EXPECT_LT(losses.angular, 1e-11);
  EXPECT_LT(losses.energy, 1e-9 * losses.start);
}

TEST(TetsAsObstacle, KeepBothMomentaAndTheEnergyOfTwoBodiesOfTetrahedra) {
  for (const double friction : {0.0, 0.5}) {
    const MixedKind kind{.restitution = 0.7, .friction = friction};
    MixedWorld world(kind.step);
    const TetModelPointer model = testing::tets_cube(1e5, 2);
    const TetHullPointer hull = testing::cube_hull(model);
    const ContactOptions contact = testing::contact_of(kind, Vector3d::Ones());
    ASSERT_TRUE(world.add(
        "left", testing::tets_body(model, kind, {-0.09, 0.01, -0.02}, {1.0, 0.2, 0}, {2, 5, -1}),
        contact, hull));
    ASSERT_TRUE(world.add(
        "right", testing::tets_body(model, kind, {0.09, -0.01, 0.03}, {-0.8, 0, 0.1}, {-3, 1, 4}),
        contact, hull));
    expect_kept(losses_of(world, 150));
    EXPECT_LT(world.tets(0)->momentum().x(), 0.5);
  }
}

TEST(TetsAsObstacle, KeepBothMomentaAndTheEnergyWithAReducedBody) {
  const MixedKind kind{.restitution = 0.7, .friction = 0.5};
  MixedWorld world(kind.step);
  ContactBody reduced =
      testing::reduced_body(testing::reduced_cube("1e5"), kind, {-0.09, 0.01, -0.02});
  ASSERT_TRUE(reduced.set_motion({1.0, 0.2, 0}, {2, 5, -1}));
  ASSERT_TRUE(world.add("reduced", std::move(reduced)));
  const TetModelPointer model = testing::tets_cube(1e5, 2);
  ASSERT_TRUE(world.add(
      "tets", testing::tets_body(model, kind, {0.09, -0.01, 0.03}, {-0.8, 0, 0.1}, {-3, 1, 4}),
      testing::contact_of(kind, Vector3d::Ones()), testing::cube_hull(model)));
  expect_kept(losses_of(world, 150));
}

// A reduced cube of 1 kg on one of tetrahedra on the floor.
TEST(TetsAsObstacle, CarryAWeight) {
  const MixedKind kind{.step = 2e-3,
                       .restitution = 0.0,
                       .friction = 0.5,
                       .gravity = {0, 0, -9.81},
                       .method = TetMethod::kImplicitEuler,
                       .beta = 5e-3};
  MixedWorld world(kind.step);
  ContactBody upper = testing::reduced_body(testing::reduced_cube("1e5"), kind, {0, 0, 0.1506});
  ASSERT_TRUE(upper.set_damping(30.0, 5e-3));
  ASSERT_TRUE(world.add("upper", std::move(upper)));
  const TetModelPointer model = testing::tets_cube(5e4, 1);
  ASSERT_TRUE(world.add(
      "lower", testing::tets_body(model, kind, {0, 0, 0.0503}, Vector3d::Zero(), Vector3d::Zero()),
      testing::contact_of(kind, Vector3d::Ones()), testing::cube_hull(model)));
  PlacedCollider floor;
  floor.shape = PlaneShape{};
  world.set_colliders({&floor, 1});
  for (int i = 0; i < 250; ++i) {
    const Status made = world.step();
    ASSERT_TRUE(made) << i << made.error().message;
  }
  const double weight = 9.81;
  EXPECT_NEAR(world.account(0).impulse_vector.z() / kind.step, weight, 1e-3 * weight);
  EXPECT_NEAR(world.account(1).impulse_vector.z() / kind.step, weight, 1e-3 * weight);
}

// Two cubes of one size exactly on each other, so that the points of each are on edges of the
// other's elements, and those of the rim on the edge of its surface.
TEST(TetsAsObstacle, CarryABodyOfTheSameWidth) {
  for (const auto& [method, step] :
       {std::pair(TetMethod::kBdf2, 3e-3), std::pair(TetMethod::kMidpoint, 1.5e-3)}) {
    const MixedKind kind{.step = step,
                         .restitution = 0.0,
                         .friction = 0.5,
                         .gravity = {0, 0, -9.81},
                         .method = method,
                         .beta = 5e-3};
    MixedWorld world(kind.step);
    const TetModelPointer model = testing::tets_cube(1e5, 2);
    const TetHullPointer hull = testing::cube_hull(model);
    for (const double z : {0.05, 0.15})
      ASSERT_TRUE(
          world.add(z < 0.1 ? "lower" : "upper",
                    testing::tets_body(model, kind, {0, 0, z}, Vector3d::Zero(), Vector3d::Zero()),
                    testing::contact_of(kind, Vector3d::Ones()), hull));
    PlacedCollider floor;
    floor.shape = PlaneShape{};
    world.set_colliders({&floor, 1});
    const int steps = static_cast<int>(std::lround(0.9 / step));
    Vector3d settled = Vector3d::Zero();
    double pressed = 0.0, moved = 0.0;
    for (int i = 0; i < steps; ++i) {
      const Status made = world.step();
      ASSERT_TRUE(made) << tet_method_name(method) << " " << step << " " << i
                        << made.error().message;
      if (i >= steps / 2)
        pressed += world.account(1).impulse_vector.z() / (step * (steps - steps / 2));
      const Vector3d corner = world.tets(1)->positions().head<3>();
      if (i == 2 * steps / 3) settled = corner;
      if (i > 2 * steps / 3) moved = std::max(moved, (corner - settled).norm());
    }
    const double weight = 9.81 * model->mass();
    EXPECT_NEAR(pressed, weight, 0.005 * weight);
    EXPECT_LT(moved, 1e-5);
  }
}

// A cube with one rim pushed in, so that the elements on both sides of y = 0 continue in different
// ways outside. A point that passes there stays in the element in which it was before, however far
// from the others; without one it is given to the nearest, and none is near enough far outside.
TEST(TetsAsObstacle, APointOutsideOfAllElementsStaysInItsOwn) {
  const MixedKind kind;
  MixedWorld world(kind.step);
  const TetModelPointer model = testing::tets_cube(1e5, 2);
  TetBody body =
      testing::tets_body(model, kind, Vector3d::Zero(), Vector3d::Zero(), Vector3d::Zero());
  const Vector3d out(1, 0, 1);
  Eigen::VectorXd x = model->rest();
  for (Eigen::Index i = 0; i < x.size(); i += 3) {
    const Vector3d at = model->rest().segment<3>(i);
    if (at.x() > 0.049 && at.z() > 0.049) x.segment<3>(i) -= (0.02 - 8.0 * at.y() * at.y()) * out;
  }
  ASSERT_TRUE(body.set_state(x, Eigen::VectorXd::Zero(x.size())));
  ASSERT_TRUE(world.add("cube", std::move(body), testing::contact_of(kind, Vector3d::Ones()),
                        testing::cube_hull(model)));
  ASSERT_TRUE(world.step());  // finds the body's boxes
  const TetStep& step = *world.guests().tets(0);
  x = step.body().positions();
  Vector3d rim = Vector3d::Zero();
  for (Eigen::Index i = 0; i < x.size(); i += 3)
    if ((model->rest().segment<3>(i) - Vector3d(0.05, 0.0, 0.05)).norm() < 1e-9)
      rim = x.segment<3>(i);
  ASSERT_FALSE(rim.isZero());
  for (const double far : {2e-4, 4e-3}) {
    const auto place = [&](int k, double off) {
      return Vector3d(rim + off * out + Vector3d(0, 1e-4 * k, 0));
    };
    const std::optional<TetDepth> first = step.depth_at_start(place(-8, 1e-4), std::nullopt);
    ASSERT_TRUE(first);
    std::optional<TetDepth> before;
    bool others = false;
    for (int k = -8; k <= 4; ++k) {
      const auto nearest = step.depth_at_start(place(k, far), std::nullopt);
      others = others || !nearest || nearest->element != first->element;
      const auto now = step.depth_at_start(place(k, far), first->element);
      ASSERT_TRUE(now) << far << ", " << k;
      EXPECT_EQ(now->element, first->element) << far << ", " << k;
      if (before) {
        EXPECT_LT(std::abs(now->distance - before->distance), 1e-4) << far << ", " << k;
      }
      before = now;
    }
    EXPECT_TRUE(others) << far;
  }
}

// Two cubes in a step in which points of the first slide by 3 cm along the second, more than half
// an element: the point of the force is then far from where they end.
struct Blow {
  Blow(double gap, double friction)
      : kind{.step = 1e-2, .friction = friction},
        model(testing::tets_cube(1e5, 2)),
        first(
            testing::tets_body(model, kind, {-0.05 - gap, 0.012, -0.021}, {0.05, 2, 0}, {0, 0, 0})),
        second(testing::tets_body(model, kind, {0.05, 0, 0}, {0, -1, 0}, {0, 0, 0})),
        points(make_tet_points(*model)),
        a(first, points, testing::contact_of(kind, Vector3d::Ones()), testing::cube_hull(model)),
        b(second, points, testing::contact_of(kind, Vector3d::Ones()), testing::cube_hull(model)) {
    contact.first = 0;
    contact.second = 1;
    contact.shared = &rate;
    a.start();
    b.start();
    EXPECT_TRUE(contact.gather(a, b, 1, kind.step));
    a.begin();
    b.begin();
    contact.begin();
  }

  // Both residuals, of a and then of b.
  Eigen::VectorXd residuals(const ContactRenewal& renewal) {
    a.evaluate(renewal);
    b.evaluate(renewal);
    rate.rate = {};
    contact.approach(renewal);
    contact.press(renewal);
    a.close();
    b.close();
    Eigen::VectorXd both(2 * a.unknowns());
    a.residual(both.head(a.unknowns()));
    b.residual(both.tail(a.unknowns()));
    return both;
  }
  Eigen::VectorXd residuals_at(double length, const Eigen::VectorXd& direction) {
    a.go(length, direction.head(a.unknowns()));
    b.go(length, direction.tail(a.unknowns()));
    return residuals({.normals = false, .limits = 1.0});
  }

  MixedKind kind;
  TetModelPointer model;
  TetBody first, second;
  std::shared_ptr<const TetPoints> points;
  TetStep a, b;
  HullContact contact;
  SharedRate rate;
};

TEST(TetsAsObstacle, TheDerivativeHoldsOnLongPathsToo) {
  struct Way {
    double gap, friction, error;
  };
  // From inside, and from outside, where the turn of the normal at the end is left out.
  for (const auto [gap, friction, error] :
       {Way{-2e-4, 0.0, 1e-6}, Way{-2e-4, 0.4, 1e-6}, Way{2e-4, 0.0, 0.04}, Way{2e-4, 0.4, 0.04}}) {
    Blow blow(gap, friction);
    blow.residuals({.normals = true, .limits = 1.0});
    ASSERT_GT(blow.contact.acting(), 3U);
    const Eigen::Index n = blow.a.unknowns();
    Eigen::VectorXd direction(2 * n), product(2 * n);
    for (Eigen::Index i = 0; i < 2 * n; ++i)
      direction[i] = 1e-3 * std::sin(1.7 * static_cast<double>(i));
    blow.a.keep();
    blow.b.keep();
    constexpr double kLength = 1e-4;
    const Eigen::VectorXd numeric =
        (blow.residuals_at(-kLength, direction) - blow.residuals_at(kLength, direction)) /
        (2.0 * kLength);
    blow.residuals_at(0.0, direction);
    blow.a.make_tangent(0.0, true);
    blow.b.make_tangent(0.0, true);
    blow.contact.make_slopes(true);
    ASSERT_TRUE(blow.a.factor(true));
    ASSERT_TRUE(blow.b.factor(true));
    blow.a.multiply(direction.head(n), product.head(n));
    blow.b.multiply(direction.tail(n), product.tail(n));
    blow.rate.growth = 0.0;
    blow.contact.add_growth(direction.head(n), direction.tail(n));
    blow.contact.multiply(direction.head(n), direction.tail(n), product.head(n), product.tail(n));
    EXPECT_LT((product - numeric).norm(), error * numeric.norm()) << gap << ", " << friction;
  }
}

}  // namespace
}  // namespace tremolo
