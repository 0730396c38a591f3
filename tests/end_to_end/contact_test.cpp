// Bodies among colliders, and hands on them, against mechanics: rebounds, stopping distances,
// slopes, momenta, and an energy balance that closes with all causes at once.
#include <cmath>
#include <filesystem>

#include <gtest/gtest.h>

#include "runtime/contact/solve/contact_step.h"
#include "runtime/contact_body.h"
#include "tests/support/meshes/made_cube.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;
using testing::balance;

constexpr double kGravity = 9.81;

Model::Pointer cube(const std::string& young, const std::string& held) {
  const std::string name = "cube-" + young + (held == "none" ? "-free" : "-held");
  return testing::made_cube(name, Vector3d::Zero(), young, held);
}

struct Fall {
  double step = 1e-3;
  double restitution = 1.0;
  double friction = 0.0;
  double alpha = 0.0, beta = 0.0;
  double height = 0.05;
  double stiffness = 16.0;  // ContactOptions
};

// A free cube whose lower side is `height` above the floor z = 0.
ContactBody cube_above_floor(const Model::Pointer& model, const Fall& fall) {
  IntegratorOptions options;
  options.step = fall.step;
  options.alpha = fall.alpha;
  options.beta = fall.beta;
  Result<ContactBody> body = ContactBody::create(model, "ep4", options, FrameKind::kFree);
  EXPECT_TRUE(body) << body.error().message;
  EXPECT_TRUE(body->set_contact({.stiffness = fall.stiffness}));
  EXPECT_TRUE(body->set_gravity({0, 0, -kGravity}));
  Pose pose;
  pose.position = Vector3d(0, 0, fall.height);
  EXPECT_TRUE(body->set_pose(pose));
  return std::move(*body);
}

std::vector<PlacedCollider> floor_of(const Fall& fall) {
  return {{PlaneShape{}, {}, {}, fall.friction, fall.restitution}};
}

TEST(Contact, RestitutionOneKeepsTheEnergyOverManyBounces) {
  const Fall fall{.height = 0.002};
  ContactBody body = cube_above_floor(cube("1e6", "none"), fall);
  const std::vector<PlacedCollider> floor = floor_of(fall);
  const double fallen = 1.0 * kGravity * fall.height;
#ifdef TREMOLO_LONG_TESTS
  constexpr int kSteps = 1'000'000, kBounces = 10'000;
#else
  // 54 to 355, as the last digits of the height and of the model have it.
  constexpr int kSteps = 20'000, kBounces = 30;
#endif
  int bounces = 0;
  bool touched = false;
  double highest = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    ASSERT_TRUE(body.step(floor).converged) << i;
    const bool touches = body.contact_account().active > 0;
    bounces += touches && !touched ? 1 : 0;
    touched = touches;
    highest = std::max(highest, std::abs(balance(body)));
  }
  EXPECT_GT(bounces, kBounces);
  EXPECT_LT(highest, 1e-6 * fallen);
  EXPECT_LT(std::abs(body.contact_sums().error), 1e-6 * fallen);
  EXPECT_EQ(body.contact_sums().lost, 0.0);
  EXPECT_EQ(body.contact_sums().friction_loss, 0.0);
  // Kinetic, elastic, contact and potential energy together equal the energy of the fall.
  const double total = body.energy().total() + body.contact_account().energy - body.sums().gravity;
  EXPECT_NEAR(total, 0.0, 1e-6 * fallen);
}

TEST(Contact, ARigidBodyLeavesWithTheShareOfItsSpeedThatRestitutionSays) {
  for (const double restitution : {0.3, 0.5, 0.9}) {
    // A contact of a millisecond and ten steps, in which gravity takes 0.01 m/s.
    const Fall fall{.step = 1e-4, .restitution = restitution, .height = 0.05, .stiffness = 300.0};
    ContactBody body = cube_above_floor(cube("1e10", "none"), fall);
    const std::vector<PlacedCollider> floor = floor_of(fall);
    double arrival = 0.0, leaving = 0.0;
    bool touched = false;
    for (int i = 0; i < 2'000 && leaving == 0.0; ++i) {
      const double before = body.rigid_state().velocity.z();
      ASSERT_TRUE(body.step(floor).converged);
      const bool touches = body.contact_account().active > 0;
      if (touches && !touched) arrival = -before;
      if (!touches && touched) leaving = body.rigid_state().velocity.z();
      touched = touches;
    }
    EXPECT_NEAR(arrival, std::sqrt(2.0 * kGravity * fall.height), 0.02);
    EXPECT_NEAR(leaving / arrival, restitution, 0.02);
  }
}

TEST(Contact, ASlidingBodyStopsWhereCoulombSays) {
  const double mu = 0.2, speed = 1.0;
  const Fall fall{.step = 1e-3, .restitution = 0.0, .friction = mu, .height = 0.0};
  ContactBody body = cube_above_floor(cube("1e8", "none"), fall);
  const std::vector<PlacedCollider> floor = floor_of(fall);
  for (int i = 0; i < 500; ++i) ASSERT_TRUE(body.step(floor).converged);  // it settles
  ASSERT_TRUE(body.set_motion({speed, 0, 0}, Vector3d::Zero()));
  const Vector3d start = body.rigid_state().centre;
  for (int i = 0; i < 1'000; ++i) ASSERT_TRUE(body.step(floor).converged);
  const double way = (body.rigid_state().centre - start).x();
  EXPECT_NEAR(way, speed * speed / (2.0 * mu * kGravity), 0.02 * way);
  EXPECT_LT(body.rigid_state().velocity.norm(), 5e-3);
  // Friction has taken the energy of the motion.
  EXPECT_NEAR(body.contact_sums().friction_loss, 0.5 * speed * speed, 0.02);
}

TEST(Contact, ASlopeHoldsBelowTheAngleOfFrictionAndNotAbove) {
  const double mu = 0.5;
  for (const double slope : {0.4, 0.7}) {  // tangent of the angle
    const Fall fall{.step = 1e-3, .restitution = 0.0, .friction = mu, .height = 0.0};
    ContactBody body = cube_above_floor(cube("1e8", "none"), fall);
    const double angle = std::atan(slope);
    ASSERT_TRUE(body.set_gravity({kGravity * std::sin(angle), 0, -kGravity * std::cos(angle)}));
    const std::vector<PlacedCollider> floor = floor_of(fall);
    for (int i = 0; i < 300; ++i) ASSERT_TRUE(body.step(floor).converged);
    const double before = body.rigid_state().velocity.x();
    for (int i = 0; i < 500; ++i) ASSERT_TRUE(body.step(floor).converged);
    const double gained = body.rigid_state().velocity.x() - before;
    if (slope < mu) {
      EXPECT_LT(std::abs(body.rigid_state().velocity.x()),
                0.01 * body.contact()->surface().law.margin / kContactTime);
    } else {
      const double expected = 0.5 * kGravity * (std::sin(angle) - mu * std::cos(angle));
      EXPECT_NEAR(gained, expected, 0.03 * expected);
    }
  }
}

TEST(Contact, WithoutFrictionAPlaneTakesNoMomentumAlongItself) {
  const Fall fall{.restitution = 0.7, .friction = 0.0, .height = 0.03};
  ContactBody body = cube_above_floor(cube("1e5", "none"), fall);
  ASSERT_TRUE(body.set_motion({0.4, -0.3, 0}, {3, 5, -2}));
  const Vector3d linear = body.momentum().linear;
  const double angular = body.momentum().angular.z();
  const std::vector<PlacedCollider> floor = floor_of(fall);
  int active = 0;
  for (int i = 0; i < 2'000; ++i) {
    ASSERT_TRUE(body.step(floor).converged);
    active += body.contact_account().active;
  }
  EXPECT_GT(active, 100);
  EXPECT_NEAR(body.momentum().linear.x(), linear.x(), 1e-12);
  EXPECT_NEAR(body.momentum().linear.y(), linear.y(), 1e-12);
  EXPECT_NEAR(body.momentum().angular.z(), angular, 1e-12);
}

// Gravity, damping, friction, restitution, a turning fall, a moving sphere and a hand at once.
TEST(Contact, TheAccountClosesWithEverythingAtOnce) {
  const Fall fall{
      .step = 2e-3, .restitution = 0.4, .friction = 0.4, .alpha = 0.5, .beta = 1e-3, .height = 0.2};
  ContactBody body = cube_above_floor(cube("1e5", "none"), fall);
  ASSERT_TRUE(body.set_motion({0.2, 0.1, 0}, {8, -3, 5}));
  std::vector<PlacedCollider> colliders = floor_of(fall);
  colliders.push_back({SphereShape{0.05}, {}, {}, 0.3, 0.4});
  const Vector3d from(0.5, 0.05, 0.05);
  colliders[1].end.position = from;
  const Result<std::size_t> hand = body.grab(0, 40.0, 0.3);
  ASSERT_TRUE(hand);
  const double start = body.energy().total();
  double most = 0.0, worst = 0.0;
  for (int i = 0; i < 1'000; ++i) {
    const double t = fall.step * (i + 1);
    colliders[1].start = colliders[1].end;
    colliders[1].end.position = from - Vector3d(0.4 * t, 0, 0);
    ASSERT_TRUE(body.move_hand(*hand, {0.1 * std::sin(5 * t), 0.05, 0.15 + 0.05 * t}));
    ASSERT_TRUE(body.step(colliders).converged) << i;
    most = std::max(most, body.energy().total());
    worst = std::max(worst, std::abs(balance(body) - start));
  }
  EXPECT_LT(worst, 1e-9 * most);
  EXPECT_GT(body.contact_sums().lost, 0.0);
  EXPECT_GT(body.contact_sums().friction_loss, 0.0);
  EXPECT_NE(body.contact_sums().given, 0.0);
  EXPECT_NE(body.contact_sums().hand, 0.0);
  const double contact = body.contact_sums().given - body.contact_sums().lost -
                         body.contact_sums().friction_loss - body.contact_account().energy +
                         body.contact_sums().error;
  EXPECT_NEAR(body.contact_sums().work, contact, 1e-9 * most);
}

// St. Venant's impact of a bar on a rigid wall: it stays for 2 L / c, c = sqrt(E / rho), squeezed
// by v / c at most, and leaves with its speed and at rest in itself.
TEST(Contact, ABarLeavesAWallAfterTwoRunsOfItsWave) {
  const double length = 0.4, young = 1e6, speed = 0.1, c = std::sqrt(young / 1000.0);
  const std::string folder = fresh_folder();
  testing::write_veg(folder + "/bar.veg", box_mesh({2, 2, 24}, {0.04, 0.04, length}));
  const ProgramResult made = run_program(
      folder, kPrecompute +
                  "bar.veg --threads 1 --order 2 --young 1e6 --poisson 0 --density 1000 "
                  "--fix none --linear-modes 70 --linear -o bar.tremolo");
  ASSERT_EQ(made.code, 0) << made.err;
  const Result<Model::Pointer> model = Model::load(folder + "/bar.tremolo");
  ASSERT_TRUE(model) << model.error().message;
  Result<ContactBody> body = ContactBody::create(*model, "ep4", {.step = 5e-5}, FrameKind::kFree);
  // A contact that is far stiffer than the bar: its time is 50 us instead of 3 ms.
  ASSERT_TRUE(body && body->set_contact({.stiffness = 16.0 * 60.0 * 60.0}));
  ASSERT_TRUE(body->set_pose({{0, 0, 0.01}, Eigen::Quaterniond::Identity()}));
  ASSERT_TRUE(body->set_motion({0, 0, -speed}, Vector3d::Zero()));
  const std::vector<PlacedCollider> wall = {{PlaneShape{}, {}, {}, 0.0, 1.0}};
  double begin = 0.0, end = 0.0, energy = 0.0;
  for (int i = 0; i < 4'000; ++i) {
    ASSERT_TRUE(body->step(wall).converged) << i;
    if (body->contact_account().active == 0) continue;
    if (begin == 0.0) begin = body->time();
    end = body->time();
    energy = std::max(energy, body->energy().potential);
  }
  EXPECT_NEAR(end - begin, 2.0 * length / c, 0.05 * 2.0 * length / c);
  EXPECT_NEAR(body->rigid_state().velocity.z(), speed, 0.03 * speed);
  // All of the motion is in the squeezed bar when the wave returns from its free end.
  const double mass = 1000.0 * 0.04 * 0.04 * length;
  EXPECT_NEAR(energy, 0.5 * mass * speed * speed, 0.05 * 0.5 * mass * speed * speed);
}

// A hand stiffer than a pin is treated as a pin. It is off by at most 4/900 of the displacement by
// which it bends the body, times three in a direction of more than average compliance.
TEST(Hand, TakesAnyStiffness) {
  const Model::Pointer model = cube("1e5", "z<0.001");
  for (const double stiffness : {1e2, 1e5, 1e9, 1e13}) {
    Result<ContactBody> body =
        ContactBody::create(model, "ep4", {.step = 3e-3, .beta = 2e-3}, FrameKind::kFixed);
    ASSERT_TRUE(body && body->set_contact());
    const Result<std::size_t> hand = body->grab(63, stiffness, 1e-3 * stiffness);
    ASSERT_TRUE(hand);
    const Vector3d rest = *body->position(63), target = rest + Vector3d(0.004, 0.002, 0.003);
    for (int i = 0; i < 1'000; ++i) {
      ASSERT_TRUE(body->move_hand(*hand, rest + std::min(1.0, i / 200.0) * (target - rest)));
      ASSERT_TRUE(body->step().converged) << stiffness << " " << i;
    }
    // At rest the body pulls as the spring does; the stiffer, the nearer to the target.
    const Vector3d lag = *body->position(63) - target;
    const double used = body->hand_spring(*hand).stiffness;
    EXPECT_LE(used, stiffness);
    EXPECT_LT((body->hand_force(*hand) + used * lag).norm(), 1e-3 * body->hand_force(*hand).norm());
    if (stiffness > 1e8) {
      EXPECT_LT(used, stiffness);
      EXPECT_LT(lag.norm(), 3.0 * 4.0 / 900.0 * (target - rest).norm());
    }
    ASSERT_TRUE(body->release(*hand));
    ASSERT_TRUE(body->step().converged);
  }
}

TEST(Hand, BadValuesAreNamed) {
  Result<ContactBody> body = ContactBody::create(cube("1e5", "z<0.001"));
  ASSERT_TRUE(body);
  EXPECT_FALSE(body->grab(0, 1.0));  // without set_contact()
  ASSERT_TRUE(body->set_contact());
  EXPECT_FALSE(body->grab(100'000, 1.0));
  EXPECT_FALSE(body->grab(0, -1.0));
  EXPECT_FALSE(body->move_hand(7, Vector3d::Zero()));
  EXPECT_FALSE(body->release(7));
  EXPECT_FALSE(body->set_contact({.points = 0}));
  EXPECT_FALSE(body->set_contact({.margin = -1.0}));
}

}  // namespace
}  // namespace tremolo
