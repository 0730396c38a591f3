// Bodies of tetrahedra that are pulled by a hand: its impulse, its balance with a weight, what a
// held body gives, sleep.
#include <numbers>

#include "runtime/bodies/tets/motion/tet_group.h"
#include "tests/support/tet_bodies.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;
using testing::tet_bar;

TetBody body_with(const TetModelPointer& model, const TetBodyOptions& options) {
  Result<TetBody> body = TetBody::create(model, options);
  EXPECT_TRUE(body) << body.error().message;
  return std::move(*body);
}

TetBodyOptions options_of(TetMethod method, double step, double tolerance) {
  TetBodyOptions options;
  options.method = method;
  options.step = step;
  options.tolerance = tolerance;
  return options;
}

// In the middle of the last element's first face.
TetHand hand_on(const TetBody& body, double stiffness, double damping) {
  TetHand hand;
  hand.nodes = body.model().elements().back().nodes;
  constexpr double kThird = 1.0 / 3.0;
  hand.shares = polynomials_at(2, {kThird, kThird, kThird, 0.0});
  hand.stiffness = stiffness;
  hand.damping = damping;
  hand.point = hand.of(body.positions());
  return hand;
}

TEST(TetHand, PullsByItsSpringAndItsDamperAndByNothingElse) {
  const double h = 0.01;
  for (const DegreeKind kind : {DegreeKind::kQuadratic, DegreeKind::kLinear}) {
    TetBodyOptions options = options_of(TetMethod::kImplicitEuler, h, 1e-10);
    options.degree.kind = kind;
    TetBody body = body_with(tet_bar({4, 1, 1}, {0.4, 0.1, 0.1}, false), options);
    TetHand hand = hand_on(body, 60.0, 1.5);
    hand.velocity = {0.3, -0.2, 0.6};
    Vector3d momentum = Vector3d::Zero();
    for (int n = 0; n < 30; ++n) {
      hand.point += h * hand.velocity;
      ASSERT_TRUE(body.set_hand(hand));
      const TetStepReport report = body.step();
      ASSERT_TRUE(report.converged);
      ASSERT_EQ(report.parts, 1);
      // Newton's matrix knows the hand: without it more are taken.
      EXPECT_LE(report.iterations, 6) << n;
      // Implicit Euler's force is that of the step's end.
      momentum += h * (hand.stiffness * (hand.point - hand.of(body.positions())) +
                       hand.damping * (hand.velocity - hand.of(body.velocities())));
      EXPECT_LE((body.momentum() - momentum).norm(), 1e-8) << n;
    }
    EXPECT_GT(momentum.norm(), 0.1);
    ASSERT_TRUE(body.set_hand(std::nullopt));
    ASSERT_TRUE(body.step().converged);
    EXPECT_LE((body.momentum() - momentum).norm(), 1e-8);
  }
}

// A slender body's matrix is factored, which is without the hand.
TEST(TetHand, ASlenderBodyIsSolvedWithTheHandToo) {
  TetBodyOptions options;
  options.method = TetMethod::kImplicitEuler;
  options.step = 0.05;
  options.gravity = {0.0, 0.0, -9.81};
  options.tolerance = 1e-9;
  TetBody body = body_with(tet_bar({40, 1, 1}, {4.0, 0.1, 0.1}, true), options);
  int searched = 0, factored = 0;
  for (int n = 0; n < 6; ++n) {
    const TetStepReport report = body.step();
    ASSERT_TRUE(report.converged);
    (report.linear > 0 ? searched : factored) += 1;
  }
  ASSERT_GT(factored, 0);
  TetHand hand = hand_on(body, 1e5, 10.0);
  hand.point.z() += 0.01;
  ASSERT_TRUE(body.set_hand(hand));
  for (int n = 0; n < 5; ++n) {
    const TetStepReport report = body.step();
    ASSERT_TRUE(report.converged);
    EXPECT_EQ(report.parts, 1);
    EXPECT_GT(report.linear, 0);
  }
}

// At a step's beginning newmark has the damper at the speed of that time: with F of both ends the
// momentum changes by h/2 (F_0 + F_1).
TEST(TetHand, NewmarkBeginsWithTheDampersForce) {
  TetBodyOptions options = options_of(TetMethod::kNewmark, 0.004, 1e-11);
  TetBody body = body_with(tet_bar({2, 1, 1}, {0.2, 0.1, 0.1}, false), options);
  Eigen::VectorXd v = body.velocities();
  for (Eigen::Index i = 0; i < v.size(); i += 3) v.segment<3>(i) = Vector3d(0.5, -0.2, 0.1);
  ASSERT_TRUE(body.set_state(body.positions(), v));
  const TetHand hand = hand_on(body, 30.0, 2.0);
  const auto force = [&] {
    return Vector3d(hand.stiffness * (hand.point - hand.of(body.positions())) -
                    hand.damping * hand.of(body.velocities()));
  };
  ASSERT_TRUE(body.set_hand(hand));
  for (int n = 0; n < 5; ++n) {
    const Vector3d before = body.momentum(), begun = force();
    ASSERT_TRUE(body.step().converged);
    const Vector3d given = 0.5 * options.step * (begun + force());
    EXPECT_LE((body.momentum() - before - given).norm(), 1e-9 * before.norm()) << n;
  }
}

TEST(TetHand, ABodyHangsBelowItByItsWeightOverTheStiffness) {
  TetBodyOptions options;
  options.method = TetMethod::kImplicitEuler;
  options.step = 0.02;
  options.gravity = {0.0, 0.0, -9.81};
  options.beta = 0.02;
  TetBody body = body_with(tet_bar({2, 1, 1}, {0.2, 0.1, 0.1}, false), options);
  const double weight = 9.81 * body.model().mass();
  const double stiffness = weight / 0.05;
  const TetHand hand = hand_on(body, stiffness, std::sqrt(stiffness * body.model().mass()));
  ASSERT_TRUE(body.set_hand(hand));
  for (int n = 0; n < 500; ++n) ASSERT_TRUE(body.step().converged);
  const Vector3d below = hand.point - hand.of(body.positions());
  EXPECT_NEAR(below.z(), 0.05, 1e-5);
  EXPECT_LE(below.head<2>().norm(), 1e-4);
}

// A slow pull with four times the stiffness that the body has there takes it four fifths of the
// way.
TEST(TetHand, AHeldBodyGivesAsMuchAsASlowPullMovesIt) {
  TetBodyOptions options = options_of(TetMethod::kImplicitEuler, 0.1, 1e-9);
  TetBody body = body_with(tet_bar({4, 1, 1}, {0.4, 0.1, 0.1}, true), options);
  TetHand hand = hand_on(body, 0.0, 0.0);
  const Eigen::Matrix3d give = body.give_at(hand);
  EXPECT_LE((give - give.transpose()).norm(), 1e-4 * give.norm());
  hand.stiffness = 4.0 / give(2, 2);
  const Vector3d begun = hand.point;
  hand.point.z() += 1e-4;
  ASSERT_TRUE(body.set_hand(hand));
  for (int n = 0; n < 200; ++n) ASSERT_TRUE(body.step().converged);
  const Vector3d way = hand.of(body.positions()) - begun;
  // u = G f, f = k (p - u): the other two directions are coupled.
  const Eigen::Matrix3d both = Eigen::Matrix3d::Identity() + hand.stiffness * give;
  const Vector3d expected = both.inverse() * (hand.stiffness * give * Vector3d(0.0, 0.0, 1e-4));
  EXPECT_LE((way - expected).norm(), 1e-7);
  EXPECT_NEAR(way.z(), 0.8e-4, 0.1e-4);
}

// Newmark knows the force where a step begins; a hand that moves on has not pulled otherwise then.
TEST(TetHand, NewmarkGoesOnWithAHandThatMoves) {
  TetBodyOptions options = options_of(TetMethod::kNewmark, 0.004, 1e-11);
  TetBody body = body_with(tet_bar({2, 1, 1}, {0.2, 0.1, 0.1}, false), options);
  TetHand hand = hand_on(body, 30.0, 2.0);
  const auto force = [&] {
    return Vector3d(hand.stiffness * (hand.point - hand.of(body.positions())) +
                    hand.damping * (hand.velocity - hand.of(body.velocities())));
  };
  for (int n = 0; n < 5; ++n) {
    const Vector3d before = body.momentum(), begun = force();
    hand.velocity = {0.5, -0.2, 0.1};
    hand.point += options.step * hand.velocity;
    ASSERT_TRUE(body.set_hand(hand));
    // In the first step it is new, with its force of the step's end.
    const Vector3d first = n == 0 ? force() : begun;
    ASSERT_TRUE(body.step().converged);
    const Vector3d given = 0.5 * options.step * (first + force());
    EXPECT_LE((body.momentum() - before - given).norm(), 1e-9 * given.norm()) << n;
  }
}

TEST(TetHand, WakesWhatSleepsAndKeepsItAwake) {
  TetBodyOptions options;
  options.step = 0.02;
  options.gravity = {0.0, 0.0, -9.81};
  options.beta = 0.02;
  const TetModelPointer model = tet_bar({1, 1, 1}, {0.1, 0.1, 0.1}, false);
  std::vector<TetBody> bodies;
  bodies.push_back(body_with(model, options));
  std::vector<TetContact> contacts;
  contacts.emplace_back(boundary_hull(model), std::vector<TetObstacle>{{PlaneShape{}, {}, 0.3}});
  TetGroup group(std::move(bodies), std::move(contacts), {0.3}, {});
  std::vector<TetStepReport> reports(1);
  for (int n = 0; n < 300 && !group.asleep(0); ++n) ASSERT_TRUE(group.step(reports)) << n;
  ASSERT_TRUE(group.asleep(0));
  ASSERT_TRUE(group.set_hand(0, hand_on(group.body(0), 1.0, 1.0)));
  EXPECT_FALSE(group.asleep(0));
  for (int n = 0; n < 60; ++n) ASSERT_TRUE(group.step(reports)) << n;
  EXPECT_FALSE(group.asleep(0));
  ASSERT_TRUE(group.set_hand(0, std::nullopt));
  for (int n = 0; n < 60; ++n) ASSERT_TRUE(group.step(reports)) << n;
  EXPECT_TRUE(group.asleep(0));
}

TEST(TetHand, WhatIsNoHandIsRefused) {
  TetBody body = body_with(tet_bar({1, 1, 1}, {0.1, 0.1, 0.1}, false), {});
  TetHand hand = hand_on(body, 1.0, 0.0);
  hand.nodes[3] = 100000;
  EXPECT_FALSE(body.set_hand(hand));
  hand = hand_on(body, -1.0, 0.0);
  EXPECT_FALSE(body.set_hand(hand));
  hand = hand_on(body, 1.0, std::numeric_limits<double>::quiet_NaN());
  EXPECT_FALSE(body.set_hand(hand));
  EXPECT_FALSE(body.hand());
  std::vector<TetBody> bodies;
  bodies.push_back(std::move(body));
  TetGroup group(std::move(bodies), std::vector<TetContact>(), {0.3}, {});
  EXPECT_FALSE(group.set_hand(1, std::nullopt));
}

}  // namespace
}  // namespace tremolo
