// Off-screen pictures show the states: silhouettes against the test's own rasteriser.
#include <cmath>
#include <fstream>
#include <numbers>
#include <set>
#include <vector>

#include "runtime/body.h"
#include "tests/viewer/masks.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;
using testing::expect_alike;
using testing::expected_mask;
using testing::fresh_folder;
using testing::kFlat;
using testing::Mask;
using testing::picture_of;
using testing::seen_mask;
using testing::shoot;
using testing::Shots;

SurfaceMesh surface_of(const Body& body) {
  std::vector<double> positions(3 * body.model().drawn().rest.size());
  EXPECT_TRUE(body.surface_positions(positions));
  SurfaceMesh surface;
  for (std::size_t i = 0; i < positions.size(); i += 3)
    surface.vertices.emplace_back(Eigen::Map<const Vector3d>(positions.data() + i));
  surface.triangles = body.model().drawn().triangles;
  return surface;
}

TEST(ViewerPicture, ABodyAtRestIsWhereItsVerticesAre) {
  if (const std::string why = testing::no_pictures(); !why.empty()) GTEST_SKIP() << why;
  for (const char* name : {"horse", "beam", "heart"}) {
    SCOPED_TRACE(name);
    const auto model = Model::load(testing::sample_model(name));
    ASSERT_TRUE(model) << model.error().message;
    const auto body = Body::create(*model);
    ASSERT_TRUE(body);
    for (const char* camera : {"0,0", "140,35,0.7"}) {
      const Shots shots = shoot(fresh_folder(), testing::sample_model(name),
                                kFlat + "--size 400x300 --camera " + camera);
      ASSERT_EQ(shots.result.code, 0) << shots.result.err;
      expect_alike(seen_mask(picture_of(shots, 0)), expected_mask({surface_of(*body)}, shots.json));
    }
  }
}

// The times of the pictures are between steps.
TEST(ViewerPicture, AMovingBodyMovesAsTheStatesSay) {
  if (const std::string why = testing::no_pictures(); !why.empty()) GTEST_SKIP() << why;
  const std::string file = testing::sample_model("beam");
  const Shots shots = shoot(
      fresh_folder(), file,
      kFlat + "--size 400x300 --load square --scale 2 --frames 4 --rate 16 --camera 10,5,0.6");
  ASSERT_EQ(shots.result.code, 0) << shots.result.err;
  const auto model = Model::load(file);
  ASSERT_TRUE(model);
  auto body = Body::create(*model);
  ASSERT_TRUE(body);
  ASSERT_TRUE(body->add_default_load({.kind = SignalKind::kSquare}, 2.0));
  std::vector<Eigen::Vector2d> centroids;
  for (std::size_t k = 0; k < 4; ++k) {
    const double t = static_cast<double>(k) / 16.0;
    EXPECT_NEAR(shots.json["frames"][k]["time"].get<double>(), t, 1e-12);
    Eigen::VectorXd before = body->state().q;
    while (body->time() < t - 1e-12) {
      before = body->state().q;
      ASSERT_TRUE(body->step().converged);
    }
    const double share = k == 0 ? 1.0 : 1.0 - (body->time() - t) / body->options().step;
    auto shown = Body::create(*model);
    ASSERT_TRUE(shown);
    ASSERT_TRUE(shown->set_state(before + share * (body->state().q - before),
                                 Eigen::VectorXd::Zero(before.size())));
    const Mask seen = seen_mask(picture_of(shots, k));
    expect_alike(seen, expected_mask({surface_of(*shown)}, shots.json));
    centroids.push_back(seen.centroid());
  }
  // It does move, by pixels: far more than the bound above.
  EXPECT_GT((centroids[3] - centroids[0]).norm(), 3.0);
}

TEST(ViewerPicture, TheSameIsDrawnTwiceAndWiresShow) {
  if (const std::string why = testing::no_pictures(); !why.empty()) GTEST_SKIP() << why;
  const std::string file = testing::sample_model("beam"), flags = "--size 200x150 --lights 8 ";
  const Picture one = picture_of(shoot(fresh_folder(), file, flags), 0);
  const Picture again = picture_of(shoot(fresh_folder(), file, flags), 0);
  const Picture wires = picture_of(shoot(fresh_folder(), file, flags + "--wire"), 0);
  EXPECT_EQ(one.pixels, again.pixels);
  std::size_t darker = 0;
  for (std::size_t i = 0; i < one.pixels.size(); i += 3)
    darker += wires.pixels[i] + 20 < one.pixels[i] ? 1U : 0U;
  EXPECT_GT(darker, 300U);
}

// Several colours from still to red.
TEST(ViewerPicture, DisplacementIsColoured) {
  if (const std::string why = testing::no_pictures(); !why.empty()) GTEST_SKIP() << why;
  const Picture picture = picture_of(
      shoot(fresh_folder(), testing::sample_model("beam"),
            "--size 300x200 --background white --colour moved --from 0.05 --load square"),
      0);
  int red = 0, blue = 0;
  for (std::size_t i = 0; i < picture.pixels.size(); i += 3) {
    const int r = picture.pixels[i], b = picture.pixels[i + 2];
    red += r > b + 60 ? 1 : 0;
    blue += b > r + 60 ? 1 : 0;
  }
  EXPECT_GT(red, 500);
  EXPECT_GT(blue, 500);
}

// Bent by its end, the beam is red by its clamp and blue at the end.
TEST(ViewerPicture, StressIsColouredAndTold) {
  if (const std::string why = testing::no_pictures(); !why.empty()) GTEST_SKIP() << why;
  const std::string flags =
      "--size 300x200 --background white --colour stress --from 0.05 --load square";
  const Shots shots = shoot(fresh_folder(), testing::sample_model("beam"), flags);
  const Picture picture = picture_of(shots, 0);
  double red = 0, blue = 0, red_x = 0, blue_x = 0;
  for (std::size_t i = 0; i < picture.pixels.size(); i += 3) {
    const int r = picture.pixels[i], b = picture.pixels[i + 2];
    const auto x = static_cast<double>(i / 3 % 300);
    red += r > b + 60 ? 1 : 0;
    red_x += r > b + 60 ? x : 0;
    blue += b > r + 60 ? 1 : 0;
    blue_x += b > r + 60 ? x : 0;
  }
  EXPECT_GT(red, 50);
  EXPECT_GT(blue, 500);
  EXPECT_GT(std::abs(red_x / red - blue_x / blue), 50) << "pixels between the two";
  EXPECT_GT(shots.json["largest_stress"].get<double>(), 100.0);
  // Three hundred times as much is not reached anywhere.
  const Shots pale =
      shoot(fresh_folder(), testing::sample_model("beam"), flags + " --stress-full 1e9");
  const Picture cold = picture_of(pale, 0);
  for (std::size_t i = 0; i < cold.pixels.size(); i += 3)
    ASSERT_LE(cold.pixels[i], cold.pixels[i + 2] + 60);
}

TEST(ViewerPicture, ASceneOfBodiesAndCollidersIsDrawn) {
  if (const std::string why = testing::no_pictures(); !why.empty()) GTEST_SKIP() << why;
  const Shots shots = shoot(fresh_folder(), TREMOLO_SOURCE_DIR "/assets/scenes/bells.toml",
                            "--size 300x200 --frames 2 --rate 10 --lights 8");
  // The scene names models next to itself, in a tree that has them.
  if (shots.result.code == 1 && shots.result.err.find("no such basis file") != std::string::npos)
    GTEST_SKIP() << shots.result.err;
  ASSERT_EQ(shots.result.code, 0) << shots.result.err;
  const Picture first = picture_of(shots, 0), second = picture_of(shots, 1);
  EXPECT_NE(first.pixels, second.pixels);
  std::set<int> colours;
  for (std::size_t i = 0; i < first.pixels.size(); i += 3)
    colours.insert((first.pixels[i] >> 5) << 6 | (first.pixels[i + 1] >> 5) << 3 |
                   first.pixels[i + 2] >> 5);
  EXPECT_GT(colours.size(), 20U);
}

// The outline of a rigid ball is off a circle by less than a pixel.
TEST(ViewerPicture, ARigidBallIsRound) {
  if (const std::string why = testing::no_pictures(); !why.empty()) GTEST_SKIP() << why;
  const std::string folder = fresh_folder();
  std::ofstream(folder + "/ball.toml")
      << "step = 0.01\nduration = 1\ngravity = [0, 0, 0]\n[[bodies]]\nname = \"ball\"\n"
         "kind = \"rigid\"\nshape = \"sphere\"\nradius = 0.1\n";
  const Shots shots = shoot(folder, "ball.toml", kFlat + "--size 600x600 --camera 20,30,0.8");
  ASSERT_EQ(shots.result.code, 0) << shots.result.err;
  const Mask seen = seen_mask(picture_of(shots, 0));
  const Eigen::Vector2d centre = seen.centroid();
  const double radius = std::sqrt(seen.area() / std::numbers::pi);
  EXPECT_GT(radius, 150.0);
  for (int k = 0; k < 360; ++k) {
    const double angle = std::numbers::pi * k / 180.0;
    const Eigen::Vector2d out(std::cos(angle), std::sin(angle));
    double length = 0.0;  // the covered part of a ray from the centre
    for (double r = 0.0; r < 1.2 * radius; r += 0.1) {
      const Eigen::Vector2d p = centre + r * out;
      const auto pixel = static_cast<std::size_t>(p.y()) * 600 + static_cast<std::size_t>(p.x());
      length += 0.1 * seen.cover[pixel];
    }
    EXPECT_NEAR(length, radius, 0.75) << k;
  }
}

// A face that is seen from its front has one shade up to its edges.
TEST(ViewerPicture, ABlockHasSharpEdges) {
  if (const std::string why = testing::no_pictures(); !why.empty()) GTEST_SKIP() << why;
  const Shots shots = shoot(fresh_folder(), testing::sample_model("finger"),
                            "--size 300x300 --background white --lights 2 --camera 0,0");
  ASSERT_EQ(shots.result.code, 0) << shots.result.err;
  const Picture picture = picture_of(shots, 0);
  int left = 300, right = 0;
  const auto row = [&](int x) { return picture.pixels.data() + 3 * (150 * 300 + x); };
  for (int x = 0; x < 300; ++x)
    if (row(x)[2] < 200) {
      left = std::min(left, x);
      right = std::max(right, x);
    }
  ASSERT_GT(right - left, 20);
  const int middle = row((left + right) / 2)[0];
  for (const int x : {left + 2, right - 2}) EXPECT_NEAR(row(x)[0], middle, 6) << x;
}

}  // namespace
}  // namespace tremolo
