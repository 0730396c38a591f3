// Method and step that change while a body runs: it continues from its state, and the energy
// balance stays closed.
#include <algorithm>
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "runtime/world/scene_world.h"
#include "tests/support/frames/frame_models.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

ContactBody moving_body(FrameKind frame, const std::string& method) {
  const auto model = testing::frame_model(6, frame == FrameKind::kFree, 30.0, 400.0, 0.3);
  IntegratorOptions options;
  options.step = 1e-3;
  options.beta = 1e-4;
  ContactBody body = testing::make_framed(model, frame, options, method);
  if (frame == FrameKind::kFree) {
    EXPECT_TRUE(body.set_motion({1.0, 0.0, 0.0}, {2.0, 1.0, 3.0}));
  }
  EXPECT_TRUE(body.apply_force(5, {30.0, 20.0, -50.0}, 40));
  return body;
}

TEST(MethodChange, AccountsStayClosed) {
  constexpr const char* kMethods[] = {"ep4", "avf", "ep2"};
  constexpr double kSteps[] = {1e-3, 2.5e-3, 4e-4};
  for (const FrameKind frame : {FrameKind::kFixed, FrameKind::kDriven, FrameKind::kFree}) {
    ContactBody body = moving_body(frame, "ep4");
    const double start = body.energy().total();
    double most = start, worst = 0.0;
    for (int k = 0; k < 600; ++k) {
      if (k % 50 == 25) {
        const double time = body.time();
        const double step = kSteps[k / 50 % 3];
        ASSERT_TRUE(body.set_method(kMethods[k / 50 % 3], step));
        EXPECT_EQ(body.options().step, step);
        EXPECT_LE(std::abs(body.time() - time), 0.5 * step * (1.0 + 1e-9));
      }
      ASSERT_TRUE(body.step().converged);
      const double energy = body.energy().total();
      most = std::max({most, energy, std::abs(body.sums().work)});
      worst = std::max(worst, std::abs(energy - start - body.sums().work + body.sums().dissipated));
    }
    EXPECT_LT(worst, 1e-10 * most) << static_cast<int>(frame);
    EXPECT_GT(most, 1e-6);
  }
}

// The step after the change is that of a body which has always had the method.
TEST(MethodChange, GoesOnAsAnotherBodyFromThatState) {
  for (const char* method : {"newmark", "imexv", "implicit-euler", "rk4", "verlet", "midpoint"}) {
    ContactBody body = moving_body(FrameKind::kFixed, "ep4");
    for (int k = 0; k < 60; ++k) ASSERT_TRUE(body.step().converged);
    IntegratorOptions options;
    options.step = 5e-4;
    options.beta = 1e-4;
    ContactBody other =
        testing::make_framed(body.model().shared_from_this(), FrameKind::kFixed, options, method);
    ASSERT_TRUE(other.set_state(body.state().q, body.state().p));
    ASSERT_TRUE(body.set_method(method, 5e-4));
    EXPECT_EQ(body.counts().steps, 120);
    for (int k = 0; k < 20; ++k) {
      ASSERT_TRUE(body.step().converged);
      ASSERT_TRUE(other.step().converged);
    }
    EXPECT_EQ(body.state().q, other.state().q) << method;
    EXPECT_EQ(body.state().p, other.state().p) << method;
  }
}

TEST(MethodChange, WhatDoesNotGoLeavesEverythingAsItWas) {
  ContactBody body = moving_body(FrameKind::kFree, "ep4");
  for (int k = 0; k < 10; ++k) ASSERT_TRUE(body.step().converged);
  ContactBody twin = moving_body(FrameKind::kFree, "ep4");
  for (int k = 0; k < 10; ++k) ASSERT_TRUE(twin.step().converged);
  for (const auto& [method, step] :
       {std::pair{"newmark", 1e-3}, {"rk5", 1e-3}, {"ep4", 0.0}, {"ep4", -1.0}}) {
    const Status s = body.set_method(method, step);
    ASSERT_FALSE(s);
    EXPECT_EQ(s.error().kind, ErrorKind::kUsage);
  }
  for (int k = 0; k < 10; ++k) ASSERT_TRUE(body.step().converged);
  for (int k = 0; k < 10; ++k) ASSERT_TRUE(twin.step().converged);
  EXPECT_EQ(body.state().q, twin.state().q);
  EXPECT_EQ(body.counts().steps, twin.counts().steps);
}

TEST(MethodChange, OfAHeldBodyTheHandStays) {
  for (const FrameKind frame : {FrameKind::kFixed, FrameKind::kFree}) {
    ContactBody body = moving_body(frame, "ep4");
    ASSERT_TRUE(body.set_contact());
    const auto hand = body.grab(5, 200.0, 3.0);
    ASSERT_TRUE(hand) << hand.error().message;
    const Vector3d place = *body.position(5) + Vector3d(0.05, 0.0, 0.0);
    ASSERT_TRUE(body.move_hand(*hand, place));
    for (int k = 0; k < 50; ++k) ASSERT_TRUE(body.step().converged);
    ASSERT_TRUE(body.set_method("ep2", 2e-3));
    for (int k = 0; k < 2000; ++k) ASSERT_TRUE(body.step().converged);
    EXPECT_GT(body.hand_force(*hand).norm(), frame == FrameKind::kFree ? 0.0 : 1e-3);
    EXPECT_LT((*body.position(5) - place).norm(), 0.05);
  }
}

}  // namespace
}  // namespace tremolo
