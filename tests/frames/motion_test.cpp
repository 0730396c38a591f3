// Motions of frames: poses at any time, smooth ramps, keys, records and jumps.
#include "runtime/math/motion.h"

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace tremolo {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

MotionPath path_of(MotionPart part, const Pose& base = {}) {
  Motion motion;
  motion.parts.push_back(std::move(part));
  Result<MotionPath> path = MotionPath::create(motion, base);
  EXPECT_TRUE(path) << (path ? "" : path.error().message);
  return std::move(*path);
}

Vector3d speed_of(const MotionPath& path, double t) {
  constexpr double kBit = 1e-5;
  return (path.pose(t + kBit).position - path.pose(t - kBit).position) / (2.0 * kBit);
}

KeyframeMotion jumping_keys(JumpRule rule) {
  KeyframeMotion keys;
  const Quaterniond half = turn_by({0.0, 0.0, 1.5});
  keys.keys = {{0.0, {}},
               {1.0, {Vector3d(1.0, 0.0, 0.0), Quaterniond::Identity()}},
               {1.0, {Vector3d(5.0, 0.0, 0.0), half}},
               {2.0, {Vector3d(6.0, 0.0, 0.0), half}}};
  keys.interpolation = Interpolation::kLinear;
  keys.jumps = rule;
  return keys;
}

TEST(Motion, CoursePathIsTheIntegralOfItsRate) {
  for (const Course& course : {Course{0.5, 3.0, 0.7}, Course{kSinceEver, 2.0, 0.4},
                               Course{1.0, kForEver, 0.3}, Course{0.5, 2.0, 0.0}}) {
    double sum = course.path(0.0);
    constexpr int kPieces = 40000;
    for (int k = 0; k < kPieces; ++k) sum += 4.0 / kPieces * course.rate(4.0 * (k + 0.5) / kPieces);
    EXPECT_NEAR(course.path(4.0), sum, 1e-4);
    EXPECT_EQ(course.rate(3.9), course.end < 3.5 ? 0.0 : 1.0);
  }
}

TEST(Motion, ShakeIsASineInsideItsRamps) {
  const MotionPath path =
      path_of(ShakeMotion{{0.1, 0.0, -0.2}, 2.0, {.start = 1.0, .end = 4.0, .ramp = 0.5}});
  EXPECT_EQ(path.pose(0.9).position, Vector3d::Zero());
  EXPECT_EQ(path.pose(4.6).position, Vector3d::Zero());
  const double sine = std::sin(2.0 * M_PI * 2.0 * 1.37);
  EXPECT_LE((path.pose(2.37).position - sine * Vector3d(0.1, 0.0, -0.2)).norm(), 1e-15);
}

TEST(Motion, SpinTurnsAboutItsPointAndLeavesThatWhereItIs) {
  const Vector3d about(0.3, 0.2, -0.1);
  const Pose base{{1.0, 0.0, 0.0}, turn_by({0.2, 0.0, 0.0})};
  const MotionPath path = path_of(SpinMotion{{0.0, 0.0, 2.0}, about, 3.0, {}}, base);
  for (const double t : {-2.0, 0.0, 0.7, 100.0}) {
    const Pose pose = path.pose(t);
    EXPECT_LE((pose.rotation.toRotationMatrix() -
               (turn_by({0.0, 0.0, 3.0 * t}) * base.rotation).toRotationMatrix())
                  .norm(),
              1e-13);
    EXPECT_NEAR((pose.position - about).norm(), (base.position - about).norm(), 1e-13);
  }
}

TEST(Motion, PartsFollowEachOther) {
  Motion motion;
  motion.parts.push_back(GlideMotion{{1.0, 0.0, 0.0}, {}});
  motion.parts.push_back(SpinMotion{{0.0, 0.0, 1.0}, Vector3d::Zero(), 0.5 * M_PI, {}});
  const MotionPath path = *MotionPath::create(motion);
  EXPECT_LE((path.pose(1.0).position - Vector3d(0.0, 1.0, 0.0)).norm(), 1e-15);
}

TEST(Motion, FallIsAParabolaThatComesToRest) {
  const Vector3d g(0.0, 0.0, -10.0);
  const MotionPath path = path_of(FallMotion{g, {.start = 1.0, .end = 2.0, .ramp = 0.1}});
  EXPECT_EQ(path.pose(0.5).position, Vector3d::Zero());
  EXPECT_LE((path.pose(1.6).position - 0.5 * 0.36 * g).norm(), 1e-14);
  EXPECT_LE((path.pose(2.2).position - (0.5 + 0.05) * g).norm(), 1e-14);
  EXPECT_LE(speed_of(path, 2.5).norm(), 1e-10);
}

TEST(Motion, SmoothKeysAreMetWithContinuousAccelerationFromRestToRest) {
  KeyframeMotion keys;
  const std::vector<double> times = {0.0, 0.4, 1.0, 1.3, 2.0};
  for (std::size_t k = 0; k < times.size(); ++k) {
    const auto x = static_cast<double>(k);
    // Signs of quaternions do not matter.
    Quaterniond turn = turn_by({0.3 * x, 0.1 * x * x, -0.4});
    if (k % 2 == 1) turn.coeffs() *= -1.0;
    keys.keys.push_back({times[k], {Vector3d(x * x, -x, 1.0), turn}});
  }
  const MotionPath path = path_of(keys);
  for (const Keyframe& key : keys.keys) {
    EXPECT_LE((path.pose(key.time).position - key.pose.position).norm(), 1e-14);
    EXPECT_LE(path.pose(key.time).rotation.angularDistance(key.pose.rotation), 1e-7);
  }
  EXPECT_LE(speed_of(path, 0.0).norm() + speed_of(path, 2.0).norm(), 1e-3);
  constexpr double kBit = 1e-4;
  for (const double t : {0.4, 1.0, 1.3}) {
    const Vector3d left = speed_of(path, t) - speed_of(path, t - kBit);
    const Vector3d right = speed_of(path, t + kBit) - speed_of(path, t);
    EXPECT_LE((left - right).norm() / kBit, 0.1) << t;
  }
}

TEST(Motion, RecordOfAccelerationsIsIntegratedExactly) {
  RecordMotion record;
  record.times = {0.0, 0.5, 2.0, 2.5};
  for (const double a : {0.0, 1.0, -0.5, 0.0}) record.accelerations.emplace_back(a, 2.0 * a, 0.0);
  const MotionPath path = path_of(record);
  double speed = 0.0, place = 0.0;
  const auto acceleration = [](double t) {
    if (t < 0.5) return 2.0 * t;
    if (t < 2.0) return 1.0 - (t - 0.5);
    return t < 2.5 ? -0.5 + (t - 2.0) : 0.0;
  };
  constexpr int kPieces = 30000;
  for (int k = 0; k < kPieces; ++k) {
    const double h = 3.0 / kPieces, a = acceleration((k + 0.5) * h);
    place += h * speed + 0.5 * h * h * a;
    speed += h * a;
  }
  EXPECT_NEAR(path.pose(3.0).position.x(), place, 1e-7);
  EXPECT_NEAR(path.pose(3.0).position.y(), 2.0 * place, 1e-7);
  EXPECT_EQ(path.pose(-1.0).position, Vector3d::Zero());
}

TEST(Motion, JumpIsToldCutOrBlended) {
  const MotionPath refused = path_of(jumping_keys(JumpRule::kRefuse));
  EXPECT_EQ(refused.refused_jump(), 1.0);
  const MotionPath cut = path_of(jumping_keys(JumpRule::kTeleport));
  EXPECT_EQ(cut.refused_jump(), kForEver);
  ASSERT_EQ(cut.jumps(), std::vector<double>{1.0});
  EXPECT_NEAR(cut.pose(0.999).position.x(), 0.999, 1e-12);
  EXPECT_NEAR(cut.pose(1.0).position.x(), 5.0, 1e-12);
  // Straight lines go on where a piece is asked beyond its end: a body feels no kick.
  EXPECT_NEAR(cut.pose_in(0, 1.1).position.x(), 1.1, 1e-12);
  EXPECT_NEAR(cut.pose_in(1, 0.9).position.x(), 4.9, 1e-12);
  KeyframeMotion keys = jumping_keys(JumpRule::kSmooth);
  keys.smooth_time = 0.2;
  const MotionPath blended = path_of(keys);
  EXPECT_TRUE(blended.jumps().empty());
  EXPECT_NEAR(blended.pose(1.0).position.x(), 3.0, 1e-12);
  EXPECT_NEAR(blended.pose(0.89).position.x(), 0.89, 1e-12);
  for (double t = 0.85; t < 1.15; t += 1e-3)
    EXPECT_LE((blended.pose(t + 1e-3).position - blended.pose(t).position).norm(), 0.05) << t;
}

TEST(Motion, WhatIsNoneIsToldByItsPart) {
  const auto why = [](MotionPart part) {
    Motion motion;
    motion.parts.push_back(GlideMotion{});
    motion.parts.push_back(std::move(part));
    const Result<MotionPath> path = MotionPath::create(motion);
    EXPECT_FALSE(path);
    return path ? std::string() : path.error().message;
  };
  EXPECT_NE(why(ShakeMotion{{1, 0, 0}, 0.0, {0.0, 1.0, 0.1}}).find("part 2"), std::string::npos);
  EXPECT_NE(why(ShakeMotion{{1, 0, 0}, 1.0, {}}).find("start"), std::string::npos);
  EXPECT_NE(why(SpinMotion{Vector3d::Zero(), Vector3d::Zero(), 1.0, {}}).find("axis"),
            std::string::npos);
  EXPECT_NE(why(GlideMotion{{NAN, 0, 0}, {}}).find("finite"), std::string::npos);
  EXPECT_NE(why(GlideMotion{{1, 0, 0}, {0.0, 0.1, 0.5}}).find("ramp"), std::string::npos);
  EXPECT_NE(why(KeyframeMotion{}).find("no keys"), std::string::npos);
  KeyframeMotion keys = jumping_keys(JumpRule::kRefuse);
  keys.keys[3].time = 0.5;
  EXPECT_NE(why(keys).find("moment 4 is earlier"), std::string::npos);
  keys.keys[3].time = 1.0;
  EXPECT_NE(why(keys).find("moment 4 stands at the time of two"), std::string::npos);
  keys = jumping_keys(JumpRule::kRefuse);
  keys.keys[2].pose.rotation.coeffs() *= 1.1;
  EXPECT_NE(why(keys).find("key 3: the quaternion is of length 1.1"), std::string::npos);
  EXPECT_NE(why(RecordMotion{}).find("two moments"), std::string::npos);
}

}  // namespace
}  // namespace tremolo
