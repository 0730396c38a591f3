// Rigid bodies in contact: closed forms at the default settings, at h, h/2 and h/4.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>
#include <utility>
#include <vector>

#include "runtime/contact/solve/contact_step.h"
#include "tests/rigid/rigid_scene.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;
using testing::kG;
using testing::rigid_body;

constexpr std::array kSteps = {3e-3, 1.5e-3, 0.75e-3};
constexpr double kDegree = std::numbers::pi / 180.0;

// Turns the axis of a shape, z, into y: it rolls along x.
Eigen::Quaterniond lying() {
  return Eigen::Quaterniond(Eigen::AngleAxisd(0.5 * std::numbers::pi, Vector3d::UnitX()));
}

// The acceleration of a body that rolls down a slope without slipping.
double rolling(const Scene& scene, double angle, double radius, double moment) {
  SceneWorld world = testing::make_world(scene);
  const double mass = world.body(0).model().inertia()->mass;
  const double exact = kG * std::sin(angle) / (1.0 + moment / (mass * radius * radius));
  return testing::acceleration(world, 0.5, 1.5) / exact;
}

// A round point rolls exactly; what is left is the bounce of the first half second.
TEST(RigidContact, LetsBallsRollDownASlope) {
  const double radius = 0.05, angle = 10.0 * kDegree;
  for (const double step : kSteps) {
    const SceneBody ball = rigid_body("ball", SphereShape{radius}, {0.0, 0.0, radius});
    const double mass = 1000.0 * 4.0 / 3.0 * std::numbers::pi * std::pow(radius, 3);
    const double share = rolling(testing::on_slope(ball, angle, 0.5, step), angle, radius,
                                 0.4 * mass * radius * radius);
    EXPECT_NEAR(share, 1.0, 1e-5) << step;
  }
}

TEST(RigidContact, LetsCapsulesRollDownASlope) {
  const double radius = 0.05, angle = 10.0 * kDegree;
  for (const double step : kSteps) {
    SceneBody body = rigid_body("capsule", CapsuleShape{radius, 0.1}, {0.0, 0.0, radius});
    body.pose.rotation = lying();
    const double ball = 1000.0 * 4.0 / 3.0 * std::numbers::pi * std::pow(radius, 3);
    const double middle = 1000.0 * 0.2 * std::numbers::pi * radius * radius;
    const double share = rolling(testing::on_slope(body, angle, 0.5, step), angle, radius,
                                 (0.4 * ball + 0.5 * middle) * radius * radius);
    EXPECT_NEAR(share, 1.0, 1e-5) << step;
  }
}

// A cylinder's rims are polygons of 50 edges, and each corner that it lands on takes a part of its
// energy: a fiftieth of restitution is that of the points (docs/theory.md).
TEST(RigidContact, LetsCylindersRollDownASlope) {
  const double radius = 0.05, angle = 10.0 * kDegree;
  for (const double step : kSteps) {
    SceneBody body = rigid_body("cylinder", CylinderShape{radius, 0.05}, {0.0, 0.0, radius});
    body.pose.rotation = lying();
    const double mass = 1000.0 * 0.1 * std::numbers::pi * radius * radius;
    const double share = rolling(testing::on_slope(body, angle, 0.5, step), angle, radius,
                                 0.5 * mass * radius * radius);
    EXPECT_NEAR(share, 1.0, 0.02) << step;
  }
}

// It was put down exactly on its floor: where its contact begins must not differ from point to
// point, or it stands in a dent.
TEST(RigidContact, LetsACylinderThatLiesOnItsFloorRollAway) {
  const double radius = 0.05;
  SceneBody body = rigid_body("cylinder", CylinderShape{radius, 0.1}, {0.0, 0.0, radius});
  body.pose.rotation = lying();
  for (const double step : kSteps) {
    const double angle = 2.0 * kDegree;
    SceneWorld slope = testing::make_world(testing::on_slope(body, angle, 0.5, step));
    testing::run_until(slope, 3.0);
    const double exact = 0.5 * kG * std::sin(angle) / 1.5 * 9.0;
    EXPECT_NEAR(testing::centre_of(slope, 0).x() / exact, 1.0, 0.06) << step;
    SceneBody rolls = body;
    rolls.velocity = {0.1, 0.0, 0.0};
    rolls.spin = {0.0, 0.1 / radius, 0.0};
    SceneWorld level = testing::make_world(testing::on_slope(rolls, 0.0, 0.5, step));
    testing::run_until(level, 3.0);
    EXPECT_GT(testing::centre_of(level, 0).x(), 0.2) << step;
  }
}

TEST(RigidContact, HoldsBlocksBelowTheAngleOfFriction) {
  const double friction = 0.4, angle = std::atan(friction);
  for (const double step : kSteps) {
    const SceneBody block = rigid_body("block", BoxShape{{0.1, 0.1, 0.05}}, {0.0, 0.0, 0.05});
    SceneWorld held =
        testing::make_world(testing::on_slope(block, std::atan(0.95 * friction), friction, step));
    testing::run_until(held, 1.0);
    const double before = testing::centre_of(held, 0).x();
    testing::run_until(held, 10.0);
    EXPECT_LT(std::abs(testing::centre_of(held, 0).x() - before), 1e-6) << step;
    const double above = std::atan(1.05 * friction);
    SceneWorld sliding = testing::make_world(testing::on_slope(block, above, friction, step));
    const double exact = kG * (std::sin(above) - friction * std::cos(above));
    EXPECT_NEAR(testing::acceleration(sliding, 1.0, 3.0), exact, 5e-3 * exact) << step;
  }
  EXPECT_GT(angle, 0.0);
}

TEST(RigidContact, StopsASlidingBlock) {
  for (const double step : kSteps) {
    SceneBody block = rigid_body("block", BoxShape{{0.1, 0.1, 0.05}}, {0.0, 0.0, 0.05});
    block.velocity.x() = 2.0;
    SceneWorld world = testing::make_world(testing::on_slope(block, 0.0, 0.3, step));
    testing::run_until(world, 2.0);
    const double exact = 4.0 / (2.0 * 0.3 * kG);
    EXPECT_NEAR(testing::centre_of(world, 0).x(), exact, 5e-3 * exact) << step;
    EXPECT_NEAR(world.account(0).friction, -0.5 * world.body(0).model().inertia()->mass * 4.0,
                0.02 * 0.5 * world.body(0).model().inertia()->mass * 4.0);
  }
}

// Two balls on a line: a blow of the given restitution.
Scene billiards(double restitution, double step, double offset = 0.0, double friction = 0.0) {
  Scene scene;
  scene.step = step;
  scene.bodies = {rigid_body("a", SphereShape{0.03}, {-0.2, 0.0, 0.0}),
                  rigid_body("b", SphereShape{0.03}, {0.0, offset, 0.0})};
  scene.bodies[0].velocity.x() = 2.0;
  for (SceneBody& body : scene.bodies) {
    body.contact.restitution = restitution;
    body.contact.friction = friction;
  }
  return scene;
}

// The speeds after the blow, relative to each other, over those before it.
double rebound(const Scene& scene) {
  SceneWorld world = testing::make_world(scene);
  const Vector3d before = world.momenta(0).linear;
  testing::run_until(world, 0.3);
  const Vector3d after = world.momenta(0).linear + world.momenta(1).linear;
  EXPECT_LT((after - before).norm(), 1e-10 * before.norm());
  return (world.body(1).rigid_state().velocity.x() - world.body(0).rigid_state().velocity.x()) /
         2.0;
}

double rebound(double restitution, double step) {
  return rebound(billiards(restitution, step));
}

// Equal balls exchange their velocities at every step.
TEST(RigidContact, LetsBilliardBallsExchangeTheirVelocities) {
  for (const double step : kSteps) EXPECT_NEAR(rebound(1.0, step), 1.0, 1e-9) << step;
}

// The blow takes 1.4 ms, and begins anywhere in a step. A fiftieth of the factor is that of slow
// points (docs/theory.md).
TEST(RigidContact, GivesBilliardBallsTheirRestitution) {
  for (const double restitution : {0.8, 0.5, 0.2})
    for (const double step : {1.0 / 60.0, 3e-3, 1.5e-3, 0.75e-3, 0.3e-3, 3e-5})
      EXPECT_NEAR(rebound(restitution, step), restitution, 0.01) << step;
  for (const double step : kSteps) EXPECT_LT(std::abs(rebound(0.0, step)), 0.06) << step;
}

// Springs from both balls to the world, too soft to matter: their ends in the world are no bodies
// that make an island large.
TEST(RigidContact, GivesBallsOnSpringsTheirRestitution) {
  for (const double restitution : {0.8, 0.5, 0.2})
    for (const double step : {3e-3, 1e-3}) {
      Scene scene = billiards(restitution, step);
      for (const SceneBody& body : scene.bodies) {
        SceneJoint joint;
        joint.body = body.name;
        joint.at = "near:0,0,0.03";
        joint.options.stiffness = 1e-12;
        scene.joints.push_back(joint);
      }
      EXPECT_NEAR(rebound(scene), restitution, 0.01) << step;
    }
}

// The edges of cubes whose sides are flush, or off by rounding, meet on each other's edges;
// friction must not act there. Cubes that are shifted otherwise turn.
TEST(RigidContact, LetsCubesThatMeetFaceToFaceExchangeTheirVelocities) {
  for (const double step : {1.0 / 60.0, 3e-3, 1e-3})
    for (const double shift : {0.0, 1e-9, 1e-7}) {
      Scene scene = billiards(1.0, step, shift, 0.3);
      for (SceneBody& body : scene.bodies) body.rigid->shape = BoxShape{{0.03, 0.03, 0.03}};
      SceneWorld world = testing::make_world(scene);
      testing::run_until(world, 0.3);
      EXPECT_NEAR(world.body(1).rigid_state().velocity.x(), 2.0, 2e-4) << step << ", " << shift;
      EXPECT_NEAR(world.body(0).rigid_state().velocity.norm(), 0.0, 1e-3) << step << ", " << shift;
    }
}

// Each ball of the row passes on (1 + e)/2 of its speed. The fastest moves by 1.3 diameters in a
// step of 1/60 s.
TEST(RigidContact, PassesABlowAlongARowOfBalls) {
  constexpr double kE = 0.6, kV = 5.0;
  for (const double step : {1.0 / 60.0, 3e-3, 1e-3}) {
    Scene scene;
    scene.step = step;
    for (int k = 0; k < 4; ++k) {
      scene.bodies.push_back(
          rigid_body("ball-" + std::to_string(k), SphereShape{0.03}, {0.11 * k, 0.0, 0.0}));
      scene.bodies.back().contact.restitution = kE;
    }
    scene.bodies[0].velocity.x() = kV;
    SceneWorld world = testing::make_world(scene);
    testing::run_until(world, 0.1);
    double v = kV;
    for (std::size_t k = 0; k < 3; ++k, v *= 0.5 * (1.0 + kE))
      EXPECT_NEAR(world.body(k).rigid_state().velocity.x(), 0.5 * (1.0 - kE) * v, 0.02 * v)
          << k << ", " << step;
    EXPECT_NEAR(world.body(3).rigid_state().velocity.x(), v, 0.02 * v) << step;
  }
}

// A glancing blow with friction turns both balls; what one gets the other loses.
TEST(RigidContact, KeepsBothMomentaOfAGlancingBlow) {
  for (const double step : kSteps) {
    SceneWorld world = testing::make_world(billiards(0.7, step, 0.03, 0.5));
    const Vector3d linear = world.momenta(0).linear;
    const Vector3d angular = world.momenta(0).angular + world.momenta(1).angular;
    testing::Growth growth;
    testing::run_until(world, 0.3, [&] { growth.look(world); });
    EXPECT_GT(world.body(1).rigid_state().spin.norm(), 1.0);
    EXPECT_LT((world.momenta(0).linear + world.momenta(1).linear - linear).norm(),
              1e-10 * linear.norm());
    // About the origin each ball alone has a momentum of 2 m/s times its offset.
    EXPECT_LT((world.momenta(0).angular + world.momenta(1).angular - angular).norm(),
              1e-10 * 0.03 * linear.norm());
    EXPECT_LT(growth.worst, 1e-6 * growth.most);
  }
}

// Shapes of each kind against each other, thrown together with spin.
TEST(RigidContact, KeepsBothMomentaOfAllShapes) {
  const std::vector<Collider> shapes = {SphereShape{0.04}, CapsuleShape{0.03, 0.05},
                                        BoxShape{{0.04, 0.05, 0.03}}, CylinderShape{0.04, 0.03}};
  for (const Collider& one : shapes)
    for (const Collider& other : shapes) {
      Scene scene;
      scene.step = 1e-3;
      scene.bodies = {rigid_body("a", one, {-0.15, 0.01, 0.02}),
                      rigid_body("b", other, {0.0, 0.0, 0.0}, 3000.0)};
      scene.bodies[0].velocity = {3.0, 0.0, 0.0};
      scene.bodies[0].spin = {1.0, 5.0, -3.0};
      scene.bodies[1].spin = {2.0, -1.0, 4.0};
      SceneWorld world = testing::make_world(scene);
      const Vector3d linear = world.momenta(0).linear + world.momenta(1).linear;
      const Vector3d angular = world.momenta(0).angular + world.momenta(1).angular;
      testing::Growth growth;
      testing::run_until(world, 0.2, [&] { growth.look(world); });
      const std::string what = std::string(shape_name(one)) + " " + shape_name(other);
      EXPECT_GT(world.contacts(0), 0) << what;
      EXPECT_LT((world.momenta(0).linear + world.momenta(1).linear - linear).norm(),
                1e-10 * linear.norm())
          << what;
      EXPECT_LT((world.momenta(0).angular + world.momenta(1).angular - angular).norm(),
                1e-10 * angular.norm())
          << what;
      EXPECT_LT(growth.worst, 1e-6 * growth.most) << what;
    }
}

// A platform under a ball rises and falls: the ball follows and the balance closes, with energy
// given by the platform.
TEST(RigidContact, SqueezesABallBetweenAMovingColliderAndTheFloor) {
  for (const double step : kSteps) {
    Scene scene;
    scene.step = step;
    scene.duration = 10.0;
    scene.gravity.values = {{0.0, 0.0, -kG}};
    scene.bodies = {rigid_body("ball", SphereShape{0.1}, {0.0, 0.0, 0.1})};
    scene.colliders = {testing::floor_with(0.4, 0.3)};
    SceneCollider plate;
    plate.name = "plate";
    plate.shape = BoxShape{{0.3, 0.3, 0.05}};
    plate.pose.position = {0.0, 0.0, 0.2505};
    plate.friction = 0.4;
    // It moves sideways and takes the ball along: a ball between two plates rolls at half the
    // speed.
    plate.motion.parts.push_back(GlideMotion{{0.2, 0.0, 0.0}, {0.2, 1.2, 0.2}});
    plate.motion.parts.push_back(ShakeMotion{{0.0, 0.0, 0.0003}, 1.0, {0.0, 5.0, 0.3}});
    scene.colliders.push_back(plate);
    SceneWorld world = testing::make_world(scene);
    testing::Growth growth;
    testing::run_until(world, 1.0, [&] { growth.look(world); });
    EXPECT_NEAR(world.body(0).rigid_state().velocity.x(), 0.1, 0.01) << step;
    EXPECT_NEAR(world.body(0).rigid_state().spin.y(), 1.0, 0.1) << step;
    EXPECT_LT(growth.worst, 1e-6 * growth.most) << step;
  }
}

// Tower of blocks, a cylinder and a capsule on its side.
TEST(RigidContact, LetsAStackRest) {
  Scene scene;
  scene.gravity.values = {{0.0, 0.0, -kG}};
  scene.colliders = {testing::floor_with(0.5)};
  double height = 0.0;
  for (int k = 0; k < 6; ++k) {
    height += 0.05;
    scene.bodies.push_back(k % 2 == 0 ? rigid_body("box-" + std::to_string(k),
                                                   BoxShape{{0.1, 0.1, 0.05}}, {0.0, 0.0, height})
                                      : rigid_body("drum-" + std::to_string(k),
                                                   CylinderShape{0.09, 0.05}, {0.0, 0.0, height}));
    scene.bodies.back().contact.restitution = 0.0;
    height += 0.05;
  }
  SceneWorld world = testing::make_world(scene);
  testing::Growth growth;
  testing::run_until(world, 3.0, [&] { growth.look(world); });
  const double weight = 6 * kG * world.body(0).model().inertia()->mass;
  const Vector3d top = testing::centre_of(world, 5);
  EXPECT_LT(std::hypot(top.x(), top.y()), 1e-3);
  EXPECT_NEAR(top.z(), 0.55, 6 * 0.001);
  for (std::size_t i = 0; i < world.size(); ++i) EXPECT_TRUE(world.asleep(i)) << i;
  EXPECT_LT(growth.worst, 1e-6 * weight * 0.6);
}

// A point mass leaves with e times its speed, whatever part of a step the impact falls into.
TEST(RigidContact, ReboundsFromTheFloorWithItsRestitutionAtAnyStep) {
  for (const double restitution : {0.0, 0.2, 0.5, 0.8, 1.0})
    for (const double step : {1.0 / 60.0, 3e-3, 1.5e-3, 0.75e-3, 0.3e-3})
      for (const double height : {0.05, 0.12, 0.2, 0.31, 0.5, 0.8}) {
        const SceneBody ball = rigid_body("ball", SphereShape{0.05}, {0.0, 0.0, 0.05 + height});
        Scene scene = testing::on_slope(ball, 0.0, 0.3, step);
        scene.colliders[0].restitution = restitution;
        SceneWorld world = testing::make_world(scene);
        const double arrival = std::sqrt(2.0 * kG * height);
        double leaving = 0.0;
        testing::run_until(world, arrival / kG + std::max(0.015, 2.0 * step), [&] {
          leaving = std::max(leaving, world.body(0).rigid_state().velocity.z());
        });
        // Gravity acts for some 4 ms while the ball is pushed out slowly, and until the end of the
        // step.
        const double left = 0.003 * (1.0 - restitution * restitution);
        const double most = std::sqrt(restitution * restitution + left);
        EXPECT_GT(leaving, (restitution - 0.01) * arrival - (4e-3 + step) * kG)
            << restitution << ", " << step << ", " << height;
        EXPECT_LT(leaving, (most + 0.01) * arrival)
            << restitution << ", " << step << ", " << height;
      }
}

// Its energy falls to that of rounding, 1e-30 J, whose relative growth is no explosion.
TEST(RigidContact, DroppedBodiesComeToRestAndStayThere) {
  const std::pair<const char*, Collider> shapes[] = {{"ball", SphereShape{0.05}},
                                                     {"capsule", CapsuleShape{0.05, 0.1}},
                                                     {"box", BoxShape{{0.05, 0.05, 0.05}}}};
  for (const auto& [name, shape] : shapes)
    for (const double step : {3e-3, 1e-3, 3e-4})
      for (const double height : {0.0, 0.01, 0.05, 0.12, 0.31})
        for (const double restitution : {0.0, 0.2, 0.5}) {
          SceneBody body = rigid_body(name, shape, {0.0, 0.0, 0.05 + height});
          if (std::string_view(name) == "capsule") body.pose.rotation = lying();
          Scene scene = testing::on_slope(body, 0.0, 0.3, step);
          scene.colliders[0].restitution = restitution;
          SceneWorld world = testing::make_world(scene);
          testing::run_until(world, 4.0);
          const double h = testing::centre_of(world, 0).z() - 0.05;
          EXPECT_LT(std::abs(h), 2e-3) << name << ", " << step << ", " << height;
          EXPECT_LT(world.body(0).rigid_state().velocity.norm(), 1e-2)
              << name << ", " << step << ", " << height << ", " << restitution;
        }
}

// The floor takes m g t, of a body that falls asleep too; and what the last step says, every step.
TEST(RigidContact, ASleepingBodyPressesOnTheFloor) {
  SceneWorld world = testing::make_world(testing::on_slope(
      rigid_body("box", BoxShape{{0.05, 0.05, 0.05}}, {0.0, 0.0, 0.05}), 0.0, 0.3, 4e-3));
  testing::run_until(world, 2.0);
  ASSERT_TRUE(world.asleep(0));
  const Vector3d before = world.collider_impulse(0, 0);
  Vector3d steps = Vector3d::Zero();
  testing::run_until(world, 8.0, [&] { steps -= world.body(0).contact_account().impulse_vector; });
  const double mass = world.body(0).model().inertia()->mass;
  EXPECT_NEAR(world.collider_impulse(0, 0).z(), -mass * kG * 8.0, 1e-3 * mass * kG * 8.0);
  EXPECT_LT((world.collider_impulse(0, 0) - before - steps).norm(), 1e-9 * steps.norm());
}

// A sleeper that its owner throws flies, and one that it lifts falls.
TEST(RigidContact, ASleeperThatIsMovedWakes) {
  const auto asleep = [] {
    SceneWorld world = testing::make_world(testing::on_slope(
        rigid_body("box", BoxShape{{0.05, 0.05, 0.05}}, {0.0, 0.0, 0.05}), 0.0, 0.3, 2e-3));
    testing::run_until(world, 2.0);
    EXPECT_TRUE(world.asleep(0));
    return world;
  };
  SceneWorld thrown = asleep();
  const double height = testing::centre_of(thrown, 0).z();
  ASSERT_TRUE(thrown.body(0).set_motion({1.0, 0.0, 3.0}, Vector3d::Zero()));
  testing::run_until(thrown, 2.2);
  EXPECT_NEAR(testing::centre_of(thrown, 0).x(), 0.2, 1e-6);
  EXPECT_NEAR(testing::centre_of(thrown, 0).z(), height + 0.6 - 0.5 * kG * 0.04, 1e-9);
  SceneWorld lifted = asleep();
  Pose pose = lifted.body(0).pose();
  pose.position.z() += 1.0;
  ASSERT_TRUE(lifted.body(0).set_pose(pose));
  testing::run_until(lifted, 2.4);
  EXPECT_NEAR(testing::centre_of(lifted, 0).z(), height + 1.0 - 0.5 * kG * 0.16, 1e-9);
}

// On a floor without friction it glides, however slowly for its size; and a ball rolls.
TEST(RigidContact, WhatGlidesOrRollsSlowlyDoesNotFallAsleep) {
  const auto way = [](SceneBody body, double speed, double friction) {
    body.velocity = Vector3d(speed, 0.0, 0.0);
    SceneWorld world = testing::make_world(testing::on_slope(body, 0.0, friction, 3e-3));
    testing::run_until(world, 6.0);
    return testing::centre_of(world, 0).x() / (6.0 * speed);
  };
  EXPECT_NEAR(way(rigid_body("box", BoxShape{{1.0, 1.0, 1.0}}, {0.0, 0.0, 1.0}), 0.03, 0.0), 1.0,
              1e-3);
  EXPECT_NEAR(way(rigid_body("box", BoxShape{{0.05, 0.05, 0.05}}, {0.0, 0.0, 0.05}), 1e-3, 0.0),
              1.0, 1e-3);
  SceneBody ball = rigid_body("ball", SphereShape{0.05}, {0.0, 0.0, 0.05});
  ball.spin = Vector3d(0.0, 2e-3 / 0.05, 0.0);
  EXPECT_NEAR(way(ball, 2e-3, 0.5), 1.0, 1e-3);
}

// Bodies that begin at the edge of contact are pushed by rounding alone, 1e-30 N s and less. The
// solve need not follow that, and such energies are compared with nothing.
TEST(RigidContact, BodiesThatBeginAtTheEdgeOfContactStayAtRestWithoutGravity) {
  const std::array pairs = {
      std::pair{rigid_body("below", BoxShape{{0.1, 0.1, 0.014666792832918791}},
                           {0.0, 0.0, 0.37179335556230719}),
                rigid_body("above", BoxShape{{0.05, 0.04, 0.024116619007203997}},
                           {0.01, 0.0, 0.41057676740242999})},
      std::pair{rigid_body("below", CylinderShape{0.05, 0.020612196033310184},
                           {0.0, 0.0, 0.29110066930859035}),
                rigid_body("above", BoxShape{{0.05, 0.04, 0.070170892247454209}},
                           {0.01, 0.0, 0.38188375758935472})},
  };
  for (const auto& [below, above] : pairs)
    for (const double step : {3e-3, 1e-3, 0.5e-3}) {
      SCOPED_TRACE(step);
      Scene scene;
      scene.step = step;
      scene.bodies = {below, above};
      SceneWorld world = testing::make_world(scene);
      testing::run_until(world, 0.3);
      for (std::size_t i = 0; i < world.size(); ++i) {
        EXPECT_LT(world.account(i).total(), 1e-20);
        EXPECT_LT((world.body(i).pose().position - scene.bodies[i].pose.position).norm(), 1e-12);
      }
    }
}

TEST(RigidContact, RefusesBodiesInsideEachOtherByDepthAndName) {
  Scene scene = billiards(0.5, 1e-3);
  scene.bodies[0].pose.position = {-0.04, 0.0, 0.0};
  const Result<SceneWorld> world = SceneWorld::create(scene);
  ASSERT_FALSE(world);
  EXPECT_EQ(world.error().kind, ErrorKind::kContent);
  EXPECT_NE(world.error().message.find("body 'a': it begins 0.02"), std::string::npos)
      << world.error().message;
  EXPECT_NE(world.error().message.find("inside body 'b'"), std::string::npos);
}

TEST(RigidContact, ContinuesWithTheSameBitsAfterRestoring) {
  Scene scene = billiards(0.7, 1e-3, 0.03, 0.5);
  scene.gravity.values = {{0.0, 0.0, -kG}};
  scene.bodies.push_back(rigid_body("box", BoxShape{{0.05, 0.05, 0.05}}, {0.1, 0.0, 0.05}));
  for (SceneBody& body : scene.bodies) body.pose.position.z() += 0.04;
  scene.colliders = {testing::floor_with(0.3, 0.5)};
  for (const double when : {0.075, 0.2}) {
    SceneWorld world = testing::make_world(scene), again = testing::make_world(scene);
    testing::run_until(world, when);
    ASSERT_TRUE(again.restore(world.save()));
    testing::run_until(world, 0.6);
    testing::run_until(again, 0.6);
    EXPECT_EQ(world.save(), again.save());
  }
  SceneWorld world = testing::make_world(scene);
  scene.bodies[0].rigid->density = 900.0;
  SceneWorld other = testing::make_world(scene);
  const Status refused = other.restore(world.save());
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("body 'a'"), std::string::npos) << refused.error().message;
}

// A pendulum of a pin and a box: the pin carries its weight.
TEST(RigidContact, HangsByAPin) {
  Scene scene;
  scene.gravity.values = {{0.0, 0.0, -kG}};
  scene.bodies = {rigid_body("box", BoxShape{{0.05, 0.05, 0.05}}, {0.0, 0.0, 0.0})};
  SceneHand pin;
  pin.body = "box";
  pin.at = "0";
  pin.pin = true;
  scene.hands = {pin};
  SceneWorld world = testing::make_world(scene);
  testing::Growth growth;
  testing::run_until(world, 2.0, [&] { growth.look(world); });
  const double mass = world.body(0).model().inertia()->mass;
  // It swings about the corner from the height of the centre on.
  EXPECT_LT(growth.worst, 1e-6 * mass * kG * 0.1);
  const Vector3d corner = world.body(0).pose() * world.body(0).model().surface().rest[0];
  EXPECT_LT((corner - world.body(0).model().surface().rest[0]).norm(), 1e-5);
}

}  // namespace
}  // namespace tremolo
