// Modes of recorded motion.
#include <cmath>

#include <gtest/gtest.h>

#include "runtime/io/exchange/recording.h"

namespace tremolo {
namespace {

constexpr int kStripFrames = 30, kStripVertices = 50;

// A strip whose vertices are displaced by `parts` fields, each with a signal of its own.
Animation strip_of(int parts) {
  Animation animation;
  AnimatedShape shape;
  shape.name = "strip";
  for (int i = 0; i < kStripVertices; ++i)
    shape.surface.vertices.emplace_back(0.1 * (i / 2), 0.1 * (i % 2), 0.0);
  for (VertexId i = 0; i + 2 < kStripVertices; ++i)
    shape.surface.triangles.push_back({i, i + 1, i + 2});
  shape.surface.object_of.assign(shape.surface.triangles.size(), 0);
  shape.surface.material_of.assign(shape.surface.triangles.size(), 0);
  shape.surface.objects = shape.surface.materials = {"strip"};
  AnimatedBody body;
  body.name = "strip";
  for (int frame = 0; frame < kStripFrames; ++frame) {
    animation.times.push_back(0.1 * frame);
    body.poses.emplace_back();
    for (int k = 0; k < 3 * kStripVertices; ++k) {
      double sum = 0.0;
      for (int part = 0; part < parts; ++part)
        sum += std::pow(0.5, part) * std::sin(0.3 * (part + 1) * k + part) *
               std::cos(0.2 * (part + 1) * frame);
      body.displacements.push_back(0.1 * sum);
    }
  }
  animation.shapes.push_back(std::move(shape));
  animation.bodies.push_back(std::move(body));
  return animation;
}

double farthest_apart(const Animation& a, const Animation& b) {
  double most = 0.0;
  std::vector<double> at(3 * kStripVertices), other(3 * kStripVertices);
  for (std::size_t frame = 0; frame < a.frames(); ++frame) {
    world_positions(a, a.bodies[0], frame, at);
    world_positions(b, b.bodies[0], frame, other);
    for (std::size_t k = 0; k < at.size(); k += 3)
      most = std::max(
          most, std::hypot(at[k] - other[k], at[k + 1] - other[k + 1], at[k + 2] - other[k + 2]));
  }
  return most;
}

TEST(RecordedModes, MotionOfThreeFieldsHasThreeModesAndIsKept) {
  const Animation recorded = strip_of(3);
  Animation described = recorded;
  const Result<double> error = describe_by_modes(described, 20, 1e-9);
  ASSERT_TRUE(error) << error.error().message;
  EXPECT_EQ(described.shapes[0].modes.cols(), 3);
  EXPECT_TRUE(check_animation(described));
  EXPECT_LE(farthest_apart(recorded, described), 1e-9 * largest_extent(recorded.shapes[0]));
}

TEST(RecordedModes, TheErrorThatIsToldIsTheOneThatIsThere) {
  const Animation recorded = strip_of(8);
  double before = 1.0;
  for (const std::size_t most : {2U, 4U, 6U}) {
    Animation described = recorded;
    const Result<double> error = describe_by_modes(described, most, 0.0);
    ASSERT_TRUE(error);
    EXPECT_EQ(described.shapes[0].modes.cols(), static_cast<Eigen::Index>(most));
    const double size = largest_extent(recorded.shapes[0]);
    EXPECT_NEAR(*error * size, farthest_apart(recorded, described), 1e-12);
    EXPECT_LT(*error, 0.7 * before);
    before = *error;
  }
}

TEST(RecordedModes, NoMoreAreTakenThanAreAskedFor) {
  Animation described = strip_of(8);
  const Result<double> error = describe_by_modes(described, 20, 1e-2);
  ASSERT_TRUE(error);
  EXPECT_LE(*error, 1e-2);
  EXPECT_LT(described.shapes[0].modes.cols(), 8);
}

}  // namespace
}  // namespace tremolo
