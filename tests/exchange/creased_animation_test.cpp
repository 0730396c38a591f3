// Sharp edges of bodies that deform.
#include "runtime/io/exchange/creased_animation.h"

#include <filesystem>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "runtime/io/exchange/glb_writer.h"
#include "runtime/io/exchange/morph_targets.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/wavy_animation.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

// A cube whose corners move in two modes.
Animation cube_animation() {
  Animation animation = testing::wavy_animation(3, 2, 4);
  AnimatedShape& shape = animation.shapes[0];
  RenderSurface& surface = shape.surface;
  surface = {};
  for (int k = 0; k < 8; ++k) surface.vertices.emplace_back(k & 1, (k >> 1) & 1, (k >> 2) & 1);
  surface.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                       {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  surface.object_of.assign(12, 0);
  surface.material_of.assign(12, 0);
  surface.objects = surface.materials = {"cube"};
  shape.smooth_groups.clear();
  shape.modes.resize(24, 2);
  for (Eigen::Index i = 0; i < shape.modes.size(); ++i)
    shape.modes(i / 2, i % 2) = 0.05 * std::sin(1.7 * static_cast<double>(i));
  return animation;
}

// The largest distance of a corner's normal from that of its triangle.
double off_flat(const AnimatedShape& shape, const std::vector<Vector3d>& places) {
  const std::vector<Vector3d> normals = smooth_normals(shape, places);
  double worst = 0.0;
  for (const auto& [a, b, c] : shape.surface.triangles) {
    const auto at = [&](VertexId v) { return places[static_cast<std::size_t>(v)]; };
    const Vector3d flat = (at(b) - at(a)).cross(at(c) - at(a)).normalized();
    for (const VertexId v : {a, b, c})
      worst = std::max(worst, (normals[static_cast<std::size_t>(v)] - flat).norm());
  }
  return worst;
}

TEST(CreasedAnimation, ACubeThatDeformsHasSharpEdges) {
  const Animation animation = cube_animation();
  ASSERT_TRUE(check_animation(animation));
  const std::optional<Animation> split = split_creases(animation);
  ASSERT_TRUE(split);
  const Status good = check_animation(*split);
  ASSERT_TRUE(good) << good.error().message;
  const AnimatedShape &before = animation.shapes[0], &after = split->shapes[0];
  ASSERT_EQ(after.surface.vertices.size(), 24U);
  EXPECT_GT(off_flat(before, before.surface.vertices), 0.5);
  EXPECT_LT(off_flat(after, after.surface.vertices), 1e-12);
  for (std::size_t frame = 0; frame < animation.frames(); ++frame) {
    std::vector<Vector3d> places(8), more(24);
    local_positions(animation, animation.bodies[0], frame, {places[0].data(), 24});
    local_positions(*split, split->bodies[0], frame, {more[0].data(), 72});
    for (std::size_t v = 0; v < 8; ++v) EXPECT_EQ(places[v], more[v]);
    for (std::size_t t = 0; t < 12; ++t)
      for (std::size_t k = 0; k < 3; ++k)
        EXPECT_EQ(places[static_cast<std::size_t>(before.surface.triangles[t][k])],
                  more[static_cast<std::size_t>(after.surface.triangles[t][k])]);
    // Its faces bend a little.
    EXPECT_LT(off_flat(after, more), 0.2);
  }
  const testing::TemporaryFolder folder;
  GlbOptions options;
  const auto sharp = write_glb(folder.file("sharp.glb"), animation, options);
  ASSERT_TRUE(sharp) << sharp.error().message;
  EXPECT_EQ(sharp->vertices, 24U);
  options.normals = false;
  const auto plain = write_glb(folder.file("plain.glb"), animation, options);
  ASSERT_TRUE(plain) << plain.error().message;
  EXPECT_EQ(plain->vertices, 8U);
}

TEST(CreasedAnimation, DisplacementsAndBonesFollow) {
  Animation animation = cube_animation();
  AnimatedShape& shape = animation.shapes[0];
  AnimatedBody& body = animation.bodies[0];
  shape.modes.resize(24, 0);
  body.q.clear();
  for (std::size_t i = 0; i < 24 * animation.frames(); ++i)
    body.displacements.push_back(0.01 * std::cos(static_cast<double>(i)));
  const std::optional<Animation> split = split_creases(animation);
  ASSERT_TRUE(split);
  const Status good = check_animation(*split);
  ASSERT_TRUE(good) << good.error().message;
  std::vector<Vector3d> places(8), more(24);
  const std::size_t last = animation.frames() - 1;
  world_positions(animation, body, last, {places[0].data(), 24});
  world_positions(*split, split->bodies[0], last, {more[0].data(), 72});
  for (std::size_t t = 0; t < 12; ++t)
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_EQ(places[static_cast<std::size_t>(shape.surface.triangles[t][k])],
                more[static_cast<std::size_t>(split->shapes[0].surface.triangles[t][k])]);
}

TEST(CreasedAnimation, SmoothShapesAndNormalsOfAnAuthorStay) {
  EXPECT_FALSE(split_creases(testing::wavy_animation(5, 2, 3)));
  Animation animation = cube_animation();
  animation.shapes[0].surface.normals.assign(8, Eigen::Vector3f::UnitZ());
  EXPECT_FALSE(split_creases(animation));
}

}  // namespace
}  // namespace tremolo
