// Modes as morph targets: the sum in viewers is X + U q.
#include "runtime/io/exchange/morph_targets.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "runtime/io/exchange/bent_normals.h"
#include "tests/support/wavy_animation.h"

namespace tremolo {
namespace {

using testing::wavy_animation;

Eigen::VectorXf shown(const MorphTargets& targets, const std::vector<float>& weights) {
  const Eigen::Map<const Eigen::VectorXf> w(weights.data(),
                                            static_cast<Eigen::Index>(weights.size()));
  return targets.positions.col(0) + targets.positions.rightCols(w.size()) * w;
}

double farthest(const Animation& animation, const AnimatedBody& body, std::size_t frame,
                const Eigen::VectorXf& places) {
  std::vector<double> exact(static_cast<std::size_t>(places.size()));
  local_positions(animation, body, frame, exact);
  return (places.cast<double>() - Eigen::Map<const Eigen::VectorXd>(exact.data(), places.size()))
      .cwiseAbs()
      .maxCoeff();
}

TEST(MorphTargets, BothFormsAreTheShapeToTheDigitsOfAFloat) {
  const Animation animation = wavy_animation(9, 30, 40);
  const AnimatedBody& body = animation.bodies[0];
  for (const bool plain : {false, true}) {
    const TargetRanges ranges = target_ranges(animation, 0, plain);
    const MorphTargets targets = morph_targets(animation.shapes[0], ranges, false);
    for (std::size_t f = 0; f < animation.frames(); ++f) {
      const std::vector<float> weights = target_weights(coordinates_at(animation, body, f), ranges);
      EXPECT_LE(farthest(animation, body, f, shown(targets, weights)), 1e-6) << plain << " " << f;
    }
    EXPECT_EQ(targets.normals.size(), 0);
  }
}

TEST(MorphTargets, WeightsOfTheBoundedFormReachZeroAndOneAndNoFarther) {
  const Animation animation = wavy_animation(4, 6, 50);
  const TargetRanges ranges = target_ranges(animation, 0, false);
  ASSERT_EQ(ranges.targets.size(), 6U);
  std::vector<float> low(6, 2.0f), high(6, -2.0f);
  for (std::size_t f = 0; f < animation.frames(); ++f) {
    const auto weights = target_weights(coordinates_at(animation, animation.bodies[0], f), ranges);
    for (std::size_t k = 0; k < 6; ++k) {
      low[k] = std::min(low[k], weights[k]);
      high[k] = std::max(high[k], weights[k]);
    }
  }
  for (std::size_t k = 0; k < 6; ++k) {
    EXPECT_EQ(low[k], 0.0f);
    EXPECT_EQ(high[k], 1.0f);
  }
}

TEST(MorphTargets, ACoordinateThatNeverChangesIsInTheBaseAndNoTarget) {
  Animation animation = wavy_animation(4, 3, 20);
  AnimatedBody& body = animation.bodies[0];
  for (std::size_t f = 0; f < 20; ++f) body.q[3 * f + 1] = 0.05;
  const TargetRanges ranges = target_ranges(animation, 0, false);
  ASSERT_EQ(ranges.targets.size(), 2U);
  EXPECT_EQ(ranges.targets[1].coordinate, 2);
  const MorphTargets targets = morph_targets(animation.shapes[0], ranges, false);
  const auto weights = target_weights(coordinates_at(animation, body, 7), ranges);
  EXPECT_LE(farthest(animation, body, 7, shown(targets, weights)), 1e-6);
  // The plain form has the rest shape as its base: only coordinates that are always zero can be
  // left out.
  EXPECT_EQ(target_ranges(animation, 0, true).targets.size(), 3U);
  for (std::size_t f = 0; f < 20; ++f) body.q[3 * f + 1] = 0.0;
  EXPECT_EQ(target_ranges(animation, 0, true).targets.size(), 2U);
}

TEST(MorphTargets, BodiesOfOneShapeShareTheirRanges) {
  Animation animation = wavy_animation(4, 2, 10);
  AnimatedBody other = animation.bodies[0];
  other.name = "other";
  for (double& q : other.q) q += 1.0;
  animation.bodies.push_back(other);
  const TargetRanges ranges = target_ranges(animation, 0, false);
  const MorphTargets targets = morph_targets(animation.shapes[0], ranges, false);
  for (const AnimatedBody& body : animation.bodies)
    EXPECT_LE(farthest(animation, body, 4,
                       shown(targets, target_weights(coordinates_at(animation, body, 4), ranges))),
              1e-6);
}

// The normals of the bent sheet, as the first order has them, degrees off at most.
double normal_error(double amplitude, bool plain) {
  const Animation animation = wavy_animation(9, 4, 30, amplitude);
  const TargetRanges ranges = target_ranges(animation, 0, plain);
  const MorphTargets targets = morph_targets(animation.shapes[0], ranges, true);
  for (Eigen::Index v = 0; v < 81; ++v)
    EXPECT_NEAR((targets.normals.col(0).segment<3>(3 * v).norm()), 1.0f, 1e-6f);
  return morph_error(animation, 0, ranges, targets).normal_max;
}

TEST(MorphTargets, NormalsErrByTheSecondOrder) {
  for (const bool plain : {false, true}) {
    const double once = normal_error(0.02, plain), half = normal_error(0.01, plain);
    EXPECT_GT(once, 0.01);
    EXPECT_NEAR(once / half, 4.0, 0.1) << plain;
  }
}

struct BentError {
  double largest = 0.0;  // degrees
  std::size_t targets = 0;
};

// The normals of two strongly bent sheets of one shape with targets of their own.
BentError bent_error(std::size_t count, bool plain) {
  Animation animation = wavy_animation(9, 4, 30, 0.5);
  AnimatedBody other = animation.bodies[0];
  other.name = "other";
  for (double& q : other.q) q *= -0.7;
  animation.bodies.push_back(other);
  const TargetRanges ranges = target_ranges(animation, 0, plain);
  MorphTargets targets = morph_targets(animation.shapes[0], ranges, true);
  const Eigen::Index before = targets.normals.cols();
  const BentNormals bent = add_bent_normals(animation, 0, ranges, plain, count, targets);
  EXPECT_EQ(targets.normals.cols(), before + static_cast<Eigen::Index>(bent.targets));
  for (Eigen::Index v = 0; v < 81; ++v)
    EXPECT_NEAR((targets.normals.col(0).segment<3>(3 * v).norm()), 1.0f, 1e-6f);
  for (const Eigen::MatrixXf& weights : bent.weights) {
    if (weights.size() == 0 || plain) continue;
    EXPECT_GE(weights.minCoeff(), 0.0f);
    EXPECT_LE(weights.maxCoeff(), 1.0f);
  }
  return {morph_error(animation, 0, ranges, targets, bent.weights).normal_max, bent.targets};
}

TEST(MorphTargets, TargetsOfNormalsFollowStrongBending) {
  for (const bool plain : {false, true}) {
    const double none = bent_error(0, plain).largest, some = bent_error(4, plain).largest,
                 more = bent_error(12, plain).largest;
    EXPECT_GT(none, 10.0) << plain;
    EXPECT_LT(some, 0.5 * none) << plain;
    EXPECT_LT(more, 0.1 * some) << plain;
    // All frames are held by as many targets as there are of them: what is left is rounding.
    const BentError all = bent_error(100, plain);
    EXPECT_LT(all.largest, 0.01) << plain;
    EXPECT_LE(all.targets, 60U) << plain;
  }
}

// A still frame has no weights that change: its base has the normals of the bent shape.
TEST(MorphTargets, OfOneFrameTheBaseHasTheNormals) {
  const Animation animation = wavy_animation(9, 4, 1, 0.12);
  const TargetRanges ranges = target_ranges(animation, 0, false);
  MorphTargets targets = morph_targets(animation.shapes[0], ranges, true);
  const BentNormals bent = add_bent_normals(animation, 0, ranges, false, 8, targets);
  EXPECT_EQ(bent.targets, 0U);
  EXPECT_LT(morph_error(animation, 0, ranges, targets, bent.weights).normal_max, 0.01);
}

TEST(MorphTargets, WhereTheNormalIsLostTheRestShapesIsKept) {
  Animation animation = wavy_animation(3, 1, 2);
  // At q = 1 the sheet is folded to nothing.
  const std::vector<Eigen::Vector3d>& rest = animation.shapes[0].surface.vertices;
  for (std::size_t v = 0; v < rest.size(); ++v)
    animation.shapes[0].modes.block<3, 1>(3 * static_cast<Eigen::Index>(v), 0) = -rest[v];
  animation.bodies[0].q = {0.5, 1.0};  // the first order has no normal left at a half
  const TargetRanges ranges = target_ranges(animation, 0, false);
  const MorphTargets targets = morph_targets(animation.shapes[0], ranges, true);
  EXPECT_TRUE(targets.normals.allFinite());
  for (Eigen::Index v = 0; v < 9; ++v)
    EXPECT_NEAR((targets.normals.col(0).segment<3>(3 * v).norm()), 1.0f, 1e-6f);
}

}  // namespace
}  // namespace tremolo
