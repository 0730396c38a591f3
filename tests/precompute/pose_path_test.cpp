// The motion of a support between the times at which it is given.
#include "precompute/reference/world/pose_path.h"

#include <cmath>

#include <gtest/gtest.h>

#include "precompute/system/failure.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

const Vector3d kAxis = Vector3d(2, -1, 3).normalized();

// A rotation about a fixed axis, so that the spin is known.
double angle_at(double time) {
  return 3.0 * std::sin(2.0 * time);
}

PosePath sampled_path(int rows) {
  std::vector<double> times;
  std::vector<PosePath::Row> values;
  for (int i = 0; i < rows; ++i) {
    const double x = static_cast<double>(i) / (rows - 1);
    const double time = x + 0.03 * std::sin(9.0 * x) * (1.0 - x);  // uneven
    const double half = 0.5 * angle_at(time), sign = i % 3 == 0 ? -1.0 : 1.0;
    const Vector3d v = sign * std::sin(half) * kAxis;
    times.push_back(time);
    values.push_back({std::sin(5 * time), time * time, std::exp(time), sign * std::cos(half), v.x(),
                      v.y(), v.z()});
  }
  return {times, values};
}

// Largest errors of position, rotation, speed and spin.
Eigen::Vector4d path_errors(int rows) {
  const PosePath path = sampled_path(rows);
  Eigen::Vector4d worst = Eigen::Vector4d::Zero();
  for (int i = 0; i <= 1000; ++i) {
    const double t = 1e-3 * i;
    const RigidMotion motion = path.at(t);
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(angle_at(t), kAxis).toRotationMatrix();
    worst = worst.cwiseMax(
        Eigen::Vector4d((motion.position - Vector3d(std::sin(5 * t), t * t, std::exp(t))).norm(),
                        (motion.turn - turn).norm(),
                        (motion.speed - Vector3d(5 * std::cos(5 * t), 2 * t, std::exp(t))).norm(),
                        (motion.spin - 6.0 * std::cos(2.0 * t) * kAxis).norm()));
  }
  return worst;
}

TEST(PosePathOfASupport, FollowsASmoothMotionToFourthOrderAndItsRatesToThird) {
  const Eigen::Vector4d coarse = path_errors(21), fine = path_errors(41);
  for (int i = 0; i < 2; ++i) EXPECT_GE(coarse[i] / fine[i], 10.0) << i;
  for (int i = 2; i < 4; ++i) EXPECT_GE(coarse[i] / fine[i], 5.5) << i;
  EXPECT_LE(fine.head<2>().maxCoeff(), 1e-5);
}

TEST(PosePathOfASupport, HasContinuousAccelerations) {
  const PosePath path = sampled_path(9);
  const double tiny = 1e-6;
  const auto acceleration = [&](double t) {
    return ((path.at(t + tiny).speed - path.at(t - tiny).speed) / (2.0 * tiny)).eval();
  };
  for (int i = 1; i < 8; ++i) {
    const double x = i / 8.0, knot = x + 0.03 * std::sin(9.0 * x) * (1.0 - x);
    const Vector3d before = acceleration(knot - 2.0 * tiny),
                   after = acceleration(knot + 2.0 * tiny);
    EXPECT_LE((after - before).norm(), 1e-2) << i;  // of about 25; a jump would be of order 1
  }
}

TEST(PosePathOfASupport, OfTwoRowsIsALineAndOfThreeAParabola) {
  const PosePath line({0.0, 2.0}, {{0, 0, 0, 1, 0, 0, 0}, {4, -2, 0, 1, 0, 0, 0}});
  EXPECT_LE((line.at(0.5).position - Vector3d(1, -0.5, 0)).norm(), 1e-15);
  EXPECT_LE((line.at(1.9).speed - Vector3d(2, -1, 0)).norm(), 1e-14);
  const PosePath parabola({0.0, 1.0, 3.0},
                          {{0, 0, 0, 1, 0, 0, 0}, {1, 0, 0, 1, 0, 0, 0}, {9, 0, 0, 1, 0, 0, 0}});
  for (const double t : {0.3, 1.7, 2.9}) {
    EXPECT_NEAR(parabola.at(t).position.x(), t * t, 1e-13);
    EXPECT_NEAR(parabola.at(t).speed.x(), 2.0 * t, 1e-13);
  }
}

TEST(PosePathOfASupport, RefusesATurnThatTheRowsDoNotShow) {
  EXPECT_THROW(PosePath({0.0, 1.0}, {{0, 0, 0, 1, 0, 0, 0}, {0, 0, 0, 0.6, 0.8, 0, 0}}), Failure);
}

}  // namespace
}  // namespace tremolo
