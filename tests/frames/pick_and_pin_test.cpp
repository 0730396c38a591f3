// Rays on surfaces that bend, hands anywhere on them, and pins.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "runtime/contact/islands/body_group.h"
#include "runtime/tremolo.h"
#include "runtime/world/scene_world.h"
#include "tests/support/frames/frame_models.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

// ---- rays ----

// A sphere of triangles whose vertices move by smooth random fields.
struct Ball {
  std::vector<Vector3d> rest;
  std::vector<Triangle> triangles;
  BasisRows rows;
};

Ball make_ball(int rings, int modes, unsigned seed) {
  Ball ball;
  const int around = 2 * rings;
  for (int i = 0; i <= rings; ++i)
    for (int j = 0; j < around; ++j) {
      const double theta = std::numbers::pi * i / rings, phi = std::numbers::pi * j / rings;
      ball.rest.emplace_back(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi),
                             1.7 * std::cos(theta));
    }
  for (int i = 0; i < rings; ++i)
    for (int j = 0; j < around; ++j) {
      const VertexId a = i * around + j, b = i * around + (j + 1) % around;
      ball.triangles.push_back({a, a + around, b});
      ball.triangles.push_back({b, a + around, b + around});
    }
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal;
  ball.rows.resize(3 * ball.rest.size(), modes);
  for (int m = 0; m < modes; ++m) {
    const Vector3d wave = 1.5 * Vector3d(normal(generator), normal(generator), normal(generator));
    const Vector3d way(normal(generator), normal(generator), normal(generator));
    const double phase = normal(generator);
    for (std::size_t v = 0; v < ball.rest.size(); ++v)
      ball.rows.block<3, 1>(3 * v, m) = way * std::sin(wave.dot(ball.rest[v]) + phase);
  }
  return ball;
}

TEST(SurfaceTree, FindsWhatAllTrianglesTogetherFind) {
  std::mt19937 generator(11);
  std::normal_distribution<double> normal;
  const auto random = [&] {
    return Vector3d(normal(generator), normal(generator), normal(generator));
  };
  for (const auto& [rings, modes] : {std::pair{2, 1}, {5, 3}, {20, 20}, {9, 70}}) {
    const Ball ball = make_ball(rings, modes, 3);
    const SurfaceTree tree(ball.rest, ball.rows, ball.triangles);
    int hits = 0;
    for (int trial = 0; trial < 3'000; ++trial) {
      VectorXd q(modes);
      // At rest, a little and much bent, and beyond all sense.
      const double size = std::array{0.0, 0.01, 0.3, 30.0}[trial % 4];
      for (double& x : q) x = size * normal(generator) / std::sqrt(modes);
      const Vector3d origin = 2.0 * random();
      Vector3d direction =
          (trial % 3 == 0 ? Vector3d(random()) : Vector3d(0.7 * random() - origin));
      if (trial % 10 == 9) direction = Vector3d::Unit(trial / 10 % 3);
      direction.normalize();
      std::optional<SurfaceTree::Hit> brute;
      for (std::size_t t = 0; t < ball.triangles.size(); ++t)
        if (const auto hit =
                tree.meet(t, origin, direction, q,
                          brute ? brute->distance : std::numeric_limits<double>::infinity()))
          brute = hit;
      const auto found = tree.nearest(origin, direction, q);
      ASSERT_EQ(found.has_value(), brute.has_value()) << trial;
      if (!found) continue;
      ++hits;
      ASSERT_EQ(found->distance, brute->distance) << trial;
      EXPECT_NEAR(found->weights.sum(), 1.0, 1e-14);
      EXPECT_GE(found->weights.minCoeff(), 0.0);
      // The weights give the point.
      Vector3d point = Vector3d::Zero();
      for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t corner = ball.triangles[found->triangle][k];
        point += found->weights[k] * (ball.rest[corner] + ball.rows.middleRows<3>(3 * corner) * q);
      }
      EXPECT_LT((point - origin - found->distance * direction).norm(), 1e-9 * (1.0 + size))
          << trial;
    }
    EXPECT_GT(hits, 500);
  }
}

// From inside a closed surface every ray meets it, also those through vertices and along edges.
TEST(SurfaceTree, NoRaySlipsThroughAClosedSurface) {
  const Ball ball = make_ball(12, 4, 5);
  const SurfaceTree tree(ball.rest, ball.rows, ball.triangles);
  const VectorXd q = VectorXd::Constant(4, 0.01);
  const auto place = [&](std::size_t v) {
    return Vector3d(ball.rest[v] + ball.rows.middleRows<3>(3 * v) * q);
  };
  std::mt19937 generator(2);
  std::uniform_real_distribution<double> uniform;
  for (int trial = 0; trial < 20'000; ++trial) {
    const Triangle& triangle = ball.triangles[generator() % ball.triangles.size()];
    const Vector3d a = place(static_cast<std::size_t>(triangle[0]));
    const Vector3d b = place(static_cast<std::size_t>(triangle[1]));
    const Vector3d at = trial % 2 == 0 ? a : Vector3d(a + uniform(generator) * (b - a));
    ASSERT_TRUE(
        tree.nearest(Vector3d(0.1, 0.05, -0.1), (at - Vector3d(0.1, 0.05, -0.1)).normalized(), q))
        << trial;
  }
}

TEST(SurfaceTree, MeetsNothingWhereThereIsNothing) {
  const std::vector<Vector3d> none;
  const BasisRows rows(0, 3);
  const std::vector<Triangle> triangles;
  const SurfaceTree empty(none, rows, triangles);
  EXPECT_FALSE(empty.nearest({0, 0, 0}, {0, 0, 1}, VectorXd::Zero(3)));
  const Ball ball = make_ball(4, 2, 1);
  const SurfaceTree tree(ball.rest, ball.rows, ball.triangles);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(tree.nearest({nan, 0, 0}, {0, 0, 1}, VectorXd::Zero(2)));
  EXPECT_FALSE(tree.nearest({0, 0, 0}, {0, 0, 1}, VectorXd::Constant(2, nan)));
  EXPECT_FALSE(tree.nearest({0, 0, 5}, {0, 0, 1}, VectorXd::Zero(2)));
}

// A body that rotates and bends: the point found is on the ray, and a hand holds it.
TEST(Picking, FindsThePlaceOfABodyThatMovesAndAHandTakesIt) {
  const auto model = testing::frame_model(5, true, 60.0, 300.0, 0.3);
  ContactBody body = testing::make_framed(model, FrameKind::kFree, {});
  ASSERT_TRUE(body.set_contact());
  ASSERT_TRUE(body.set_pose({{1.0, 2.0, 3.0}, turn_by({0.4, -0.3, 1.0})}));
  ASSERT_TRUE(body.set_motion({0.1, 0.0, 0.0}, {1.0, 2.0, 0.5}));
  ASSERT_TRUE(body.apply_force(4, {20.0, -20.0, 20.0}, 5));
  testing::steps_of(body, 40);
  const Triangle& corners = model->drawn().triangles[1];
  const Vector3d weights(0.2, 0.5, 0.3);
  Vector3d target = Vector3d::Zero();
  for (std::size_t k = 0; k < 3; ++k) target += weights[k] * *body.position(corners[k]);
  const Vector3d across = (*body.position(corners[1]) - *body.position(corners[0]))
                              .cross(*body.position(corners[2]) - *body.position(corners[0]))
                              .normalized();
  // Along the normal, from near by: nothing is between.
  for (const double side : {-1.0, 1.0}) {
    const Vector3d origin = target + 1e-3 * side * across;
    const auto hit = body.pick(origin, -5.0 * side * across);
    ASSERT_TRUE(hit) << hit.error().message;
    ASSERT_TRUE(*hit);
    EXPECT_EQ((*hit)->place.triangle, 1U);
    EXPECT_LT(((*hit)->place.weights - weights).norm(), 1e-10);
    EXPECT_LT(((*hit)->point - target).norm(), 1e-12);
    EXPECT_NEAR((*hit)->distance, 1e-3, 1e-12);
    EXPECT_EQ((*hit)->vertex, corners[1]);
    const auto hand = body.grab((*hit)->place, 500.0, 1.0);
    ASSERT_TRUE(hand) << hand.error().message;
    ASSERT_TRUE(body.step().converged);
    EXPECT_GT(body.hand_force(*hand).norm(), 0.0);
    ASSERT_TRUE(body.release(*hand));
    break;
  }
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(body.pick({nan, 0, 0}, {0, 0, 1}));
  EXPECT_FALSE(body.pick({0, 0, 0}, {0, 0, 0}));
  EXPECT_FALSE(body.grab(SurfacePlace{SurfaceKind::kDrawn, 2, {1, 0, 0}}, 1.0));
  EXPECT_FALSE(body.grab(SurfacePlace{SurfaceKind::kDrawn, 0, {0.5, 0.2, 0.2}}, 1.0));
  EXPECT_FALSE(body.pin(SurfacePlace{SurfaceKind::kBoundary, 0, {-0.5, 0.75, 0.75}}));
}

// At a corner a point is the vertex: the same bits.
TEST(Picking, APlaceAtACornerIsTheVertex) {
  const auto model = testing::frame_model(5, true, 60.0, 300.0, 0.3);
  ContactBody by_vertex = testing::make_framed(model, FrameKind::kFree, {});
  ContactBody by_place = testing::make_framed(model, FrameKind::kFree, {});
  for (ContactBody* body : {&by_vertex, &by_place}) ASSERT_TRUE(body->set_contact());
  const VertexId corner = model->drawn().triangles[1][2];
  const auto first = by_vertex.grab(corner, 400.0, 2.0);
  const auto second = by_place.grab(SurfacePlace{SurfaceKind::kDrawn, 1, {0, 0, 1}}, 400.0, 2.0);
  ASSERT_TRUE(first && second);
  for (int k = 0; k < 50; ++k) {
    const Vector3d to(0.01 * k, 0.0, 0.002 * k);
    ASSERT_TRUE(by_vertex.move_hand(*first, to) && by_place.move_hand(*second, to));
    ASSERT_TRUE(by_vertex.step().converged && by_place.step().converged);
  }
  EXPECT_EQ(by_vertex.state().q, by_place.state().q);
  EXPECT_EQ(by_vertex.contact_sums().hand, by_place.contact_sums().hand);
}

// ---- pins ----

struct Pinned {
  FrameKind frame = FrameKind::kFixed;
  const char* method = "ep4";
  double step = 3e-3;
  double beta = 0.0;
  double nonlinearity = 0.3;
};

// A body under gravity that is pinned at one vertex, shaken by a load: how far the vertex strays
// from where it was, and the error of the energy balance.
TEST(Pins, APinnedVertexStaysAndTheAccountCloses) {
  for (const FrameKind frame : {FrameKind::kFixed, FrameKind::kDriven, FrameKind::kFree})
    for (const char* method : {"ep4", "ep2", "avf"})
      for (const double step : {1e-3, 3e-3})
        for (const double beta : {0.0, 1e-3})
          for (const double nonlinearity : {0.0, 0.3}) {
            const auto model =
                testing::frame_model(6, frame == FrameKind::kFree, 30.0, 400.0, nonlinearity);
            IntegratorOptions options;
            options.step = step;
            options.beta = beta;
            ContactBody body = testing::make_framed(model, frame, options, method);
            ASSERT_TRUE(body.set_contact());
            ASSERT_TRUE(body.set_gravity({0.0, 0.0, -9.81}));
            ASSERT_TRUE(
                body.add_load({.kind = SignalKind::kSine, .frequency = 2.0}, 9, {3.0, -2.0, 1.0}));
            const Vector3d place = *body.position(5);
            const auto pin = body.pin(VertexId{5});
            ASSERT_TRUE(pin) << pin.error().message;
            const double start = body.energy().total();
            double stray = 0.0, worst = 0.0, most = start;
            const auto steps = std::llround(1.0 / step);
            for (int k = 0; k < steps; ++k) {
              ASSERT_TRUE(body.step().converged) << method << " " << step << " " << k;
              stray = std::max(stray, (*body.position(5) - place).norm());
              const double energy = body.energy().total();
              most = std::max({most, energy, std::abs(body.sums().gravity)});
              worst = std::max(
                  worst, std::abs(energy - start - body.sums().work + body.sums().dissipated));
            }
            // The body is about a metre long.
            EXPECT_LT(stray, 20.0 * step * step) << method << " " << step;
            EXPECT_LT(worst, 1e-8 * most) << method << " " << step;
            ASSERT_TRUE(body.release(*pin));
            testing::steps_of(body, 200);
          }
}

TEST(Pins, FollowWhereTheyAreMovedAndStopWhatMoves) {
  const auto model = testing::frame_model(6, true, 30.0, 400.0, 0.3);
  ContactBody body = testing::make_framed(model, FrameKind::kFree, {});
  ASSERT_TRUE(body.set_contact());
  ASSERT_TRUE(body.set_motion({2.0, 0.0, 0.0}, {0.0, 3.0, 0.0}));
  const auto pin = body.pin(VertexId{5});
  ASSERT_TRUE(pin);
  const Vector3d place = *body.position(5);
  double first = 0.0, last = 0.0;
  for (int k = 0; k < 300; ++k) {
    ASSERT_TRUE(body.step().converged);
    const double stray = (*body.position(5) - place).norm();
    (k < 10 ? first : last) = std::max(k < 10 || k > 200 ? stray : 0.0, k < 10 ? first : last);
  }
  EXPECT_LT(first, 2e-3);  // 2 m/s in steps of 3 ms
  EXPECT_LT(last, 2e-4);
  for (int k = 0; k < 300; ++k) {
    const Vector3d to = place + Vector3d(0.0, 0.1 * (1.0 - std::cos(0.01 * k)), 0.0);
    ASSERT_TRUE(body.move_hand(*pin, to));
    ASSERT_TRUE(body.step().converged);
    EXPECT_LT((*body.position(5) - to).norm(), 2e-4);
  }
}

TEST(Pins, WhatDoesNotMoveIsRefused) {
  ContactBody body =
      testing::make_framed(testing::frame_model(5, false, 60.0, 300.0), FrameKind::kFixed, {});
  EXPECT_FALSE(body.pin(VertexId{5}));  // without set_contact()
  ASSERT_TRUE(body.set_contact());
  EXPECT_FALSE(body.pin(VertexId{0}));   // it is fixed
  EXPECT_FALSE(body.pin(VertexId{99}));  // there is none
  EXPECT_TRUE(body.pin(VertexId{5}));
}

// In a scene, with a body next to it that a ray meets first.
TEST(Pins, HandsOfAScenePinAndRaysMeetTheNearestBody) {
  Scene scene;
  scene.gravity.values = {{0.0, 0.0, -9.81}};
  for (const double x : {0.0, 3.0}) {
    SceneBody body;
    body.name = x == 0.0 ? "near" : "far";
    body.kind = FrameKind::kFree;
    body.model = "free";
    body.pose.position.x() = x;
    scene.bodies.push_back(body);
    SceneHand hand;
    hand.body = body.name;
    hand.at = "5";
    hand.pin = true;
    scene.hands.push_back(hand);
  }
  Result<SceneWorld> world = SceneWorld::create(scene, [](const SceneBody&) {
    return Result<Model::Pointer>(testing::frame_model(5, true, 60.0, 300.0, 0.3));
  });
  ASSERT_TRUE(world) << world.error().message;
  const Vector3d place = *world->body(1).position(5);
  for (int k = 0; k < 300; ++k) ASSERT_TRUE(world->step().empty());
  EXPECT_LT((*world->body(1).position(5) - place).norm(), 1e-4);
  EXPECT_GT(world->hand_force(1).z(), 0.0);
  const auto middle_of = [&](std::size_t i) {
    const Triangle& corners = world->body(i).model().drawn().triangles[0];
    Vector3d sum = Vector3d::Zero();
    for (const VertexId corner : corners) sum += *world->body(i).position(corner) / 3.0;
    return sum;
  };
  const auto hit = world->pick(middle_of(1) + Vector3d(1e-4, 2e-4, 1e-4), {-1e-4, -2e-4, -1e-4});
  ASSERT_TRUE(hit);
  ASSERT_TRUE(*hit);
  EXPECT_EQ((*hit)->body, 1U);
  const auto none = world->pick({0.0, 0.0, 50.0}, {0.0, 0.0, 1.0});
  ASSERT_TRUE(none);
  EXPECT_FALSE(*none);
}

// ---- hands and joints of any stiffness ----

// A hand that is stiffer than a pin is one. A free and a fixed body are pulled about for a second:
// every step succeeds and the energy closes as with a pin, whatever stiffness and damping are.
TEST(StiffHands, AreLimitedToAPinAndTheAccountCloses) {
  constexpr double kStep = 3e-3;
  for (const FrameKind frame : {FrameKind::kFixed, FrameKind::kFree})
    for (const double stiffness : {1.0, 1e6, 1e9, 1e12, 1e18, 1e300})
      for (const double damping : {0.0, 1e6, 1e300}) {
        const auto model = testing::frame_model(6, frame == FrameKind::kFree, 30.0, 400.0, 0.3);
        ContactBody body = testing::make_framed(model, frame, {.step = kStep});
        ASSERT_TRUE(body.set_contact());
        ASSERT_TRUE(body.set_gravity({0.0, 0.0, -9.81}));
        const HandSpring most = body.stiffest_hand(*model->vertex(5));
        const auto hand = body.grab(VertexId{5}, stiffness, damping);
        ASSERT_TRUE(hand) << hand.error().message;
        const HandSpring used = body.hand_spring(*hand);
        EXPECT_EQ(used.stiffness, std::min(stiffness, most.stiffness));
        EXPECT_LE(used.damping, 0.5 * kStep * most.stiffness);
        if (stiffness > most.stiffness) {
          EXPECT_GE(used.damping, most.damping);
        }
        const Vector3d place = *body.position(5);
        const double start = body.energy().total();
        double worst = 0.0, largest = start;
        for (int k = 0; k < 333; ++k) {
          const double t = kStep * k;
          ASSERT_TRUE(body.move_hand(
              *hand, place + 0.05 * Vector3d(std::sin(3.0 * t), std::sin(2.0 * t), 0.0)));
          ASSERT_TRUE(body.step().converged) << stiffness << " " << damping << " " << k;
          const double energy = body.energy().total();
          largest = std::max({largest, energy, std::abs(body.sums().gravity)});
          worst =
              std::max(worst, std::abs(energy - start - body.sums().work + body.sums().dissipated));
        }
        // As of a pin: the tolerance of the solve, 1e-10 of the momenta, a step.
        EXPECT_LT(worst, 1e-7 * largest) << stiffness << " " << damping;
      }
}

// The same hand on a longer step may be too stiff for it.
TEST(StiffHands, ALongerStepLimitsThemAgain) {
  const auto model = testing::frame_model(6, true, 30.0, 400.0, 0.3);
  ContactBody body = testing::make_framed(model, FrameKind::kFree, {.step = 1e-3});
  ASSERT_TRUE(body.set_contact());
  const auto hand = body.grab(VertexId{5}, 1e12, 0.0);
  ASSERT_TRUE(hand);
  const HandSpring at_first = body.hand_spring(*hand);
  ASSERT_TRUE(body.set_method("ep4", 1e-2));
  const HandSpring now = body.hand_spring(*hand);
  EXPECT_EQ(now.stiffness, body.stiffest_hand(*model->vertex(5)).stiffness);
  EXPECT_LT(now.stiffness, at_first.stiffness);
  testing::steps_of(body, 100);
}

// A joint with a stiffness beyond that of one without keeps bodies as the latter does.
TEST(StiffHands, AJointIsLimitedToOneWithoutAStiffness) {
  const auto model = testing::frame_model(6, true, 30.0, 400.0, 0.3);
  std::vector<ContactBody> bodies;
  for (int k = 0; k < 2; ++k) {
    bodies.push_back(testing::make_framed(model, FrameKind::kFree, {.step = 3e-3}));
    ASSERT_TRUE(bodies.back().set_contact());
  }
  const auto stiff = make_joint(bodies[0], 5, bodies[1], JointOptions{.stiffness = 1e15});
  const auto free = make_joint(bodies[0], 5, bodies[1], JointOptions{});
  const auto soft =
      make_joint(bodies[0], 5, bodies[1], JointOptions{.stiffness = 10.0, .damping = 0.1});
  ASSERT_TRUE(stiff && free && soft);
  EXPECT_EQ(stiff->stiffness, free->stiffness);
  EXPECT_EQ(stiff->damping, free->damping);
  EXPECT_EQ(soft->stiffness, 10.0);
  EXPECT_EQ(soft->damping, 0.1);
}

}  // namespace
}  // namespace tremolo
