// Off-screen pictures show the states: silhouettes against the test's own rasteriser.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <vector>

#include "runtime/apps/view/picture/png_file.h"
#include "runtime/body.h"
#include "tests/viewer/viewer_files.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;
using testing::fresh_folder;
using testing::shoot;
using testing::Shots;

// Coverage of each pixel by a body, 0 to 1.
struct Mask {
  int width = 0, height = 0;
  std::vector<double> cover;

  double area() const { return std::accumulate(cover.begin(), cover.end(), 0.0); }
  Eigen::Vector2d centroid() const {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        sum += cover[y * width + x] * Eigen::Vector2d(x + 0.5, y + 0.5);
    return sum / area();
  }
};

Vector3d vector_of(const nlohmann::json& json) {
  return {json[0].get<double>(), json[1].get<double>(), json[2].get<double>()};
}

// A pinhole camera, from the program's description of it.
class Pinhole {
 public:
  Pinhole(const nlohmann::json& camera, int width, int height)
      : eye_(vector_of(camera["eye"])), width_(width), height_(height) {
    forward_ = (vector_of(camera["target"]) - eye_).normalized();
    right_ = forward_.cross(vector_of(camera["up"])).normalized();
    down_ = forward_.cross(right_);
    focal_ = 0.5 * height / std::tan(0.5 * camera["view_angle"].get<double>());
  }
  Eigen::Vector2d pixel(const Vector3d& x) const {
    const Vector3d d = x - eye_;
    const double depth = forward_.dot(d);
    return {0.5 * width_ + focal_ * right_.dot(d) / depth,
            0.5 * height_ + focal_ * down_.dot(d) / depth};
  }

 private:
  Vector3d eye_, forward_, right_, down_;
  double focal_ = 1.0;
  int width_, height_;
};

double side_of(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& p) {
  return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
}

// Each pixel has kFine x kFine samples, one behind the other.
constexpr int kFine = 4;

void fill(std::vector<char>& inside, int width, int height, const Eigen::Vector2d& a,
          const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
  const Eigen::Vector2d low = a.cwiseMin(b).cwiseMin(c), high = a.cwiseMax(b).cwiseMax(c);
  for (int y = std::max(0, static_cast<int>(low[1])); y < std::min<double>(height, high[1]); ++y)
    for (int x = std::max(0, static_cast<int>(low[0])); x < std::min<double>(width, high[0]); ++x) {
      const Eigen::Vector2d p(x + 0.5, y + 0.5);
      const double u = side_of(a, b, p), v = side_of(b, c, p), w = side_of(c, a, p);
      if ((u >= 0 && v >= 0 && w >= 0) || (u <= 0 && v <= 0 && w <= 0)) inside[y * width + x] = 1;
    }
}

Mask expected_mask(const Body& body, const nlohmann::json& json) {
  Mask mask{json["width"], json["height"], {}};
  const int width = kFine * mask.width, height = kFine * mask.height;
  std::vector<char> inside(static_cast<std::size_t>(width * height));
  const Pinhole camera(json["camera"], mask.width, mask.height);
  std::vector<double> positions(3 * body.model().drawn().rest.size());
  EXPECT_TRUE(body.surface_positions(positions));
  const auto at = [&](VertexId v) {
    return Eigen::Vector2d(kFine *
                           camera.pixel(Eigen::Map<const Vector3d>(positions.data() + 3 * v)));
  };
  for (const Triangle& t : body.model().drawn().triangles)
    fill(inside, width, height, at(t[0]), at(t[1]), at(t[2]));
  mask.cover.resize(mask.width * mask.height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      mask.cover[y / kFine * mask.width + x / kFine] +=
          inside[y * width + x] / double{kFine * kFine};
  return mask;
}

// The mask of a body without blue before white: quarters of a pixel, four samples, that are not
// white.
Mask seen_mask(const Picture& picture) {
  Mask mask{picture.width, picture.height, {}};
  for (std::size_t i = 0; i < picture.pixels.size(); i += 3) {
    const double shown = picture.pixels[i + 2] / 255.0;
    const double light = shown <= 0.04045 ? shown / 12.92 : std::pow((shown + 0.055) / 1.055, 2.4);
    mask.cover.push_back(std::round(4.0 * (1.0 - light)) / 4.0);
  }
  return mask;
}

// Four samples measure a partly covered pixel to a quarter: outlines are a thousand such
// pixels, whose errors are of either sign.
void expect_alike(const Mask& seen, const Mask& expected) {
  ASSERT_EQ(seen.cover.size(), expected.cover.size());
  double different = 0.0;
  for (std::size_t i = 0; i < seen.cover.size(); ++i)
    different += std::abs(seen.cover[i] - expected.cover[i]);
  EXPECT_GT(expected.area(), 1000.0);
  EXPECT_NEAR(seen.area(), expected.area(), 0.001 * expected.area());
  EXPECT_LT(different, 0.008 * expected.area());
  EXPECT_LT((seen.centroid() - expected.centroid()).norm(), 0.05);
}

Picture picture_of(const Shots& shots, std::size_t frame) {
  auto picture = read_png(shots.json["frames"][frame]["file"]);
  EXPECT_TRUE(picture);
  return picture ? std::move(*picture) : Picture{};
}

const std::string kFlat = " --background white --paint '#400000' --lights 2 ";

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
      expect_alike(seen_mask(picture_of(shots, 0)), expected_mask(*body, shots.json));
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
    expect_alike(seen, expected_mask(*shown, shots.json));
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

}  // namespace
}  // namespace tremolo
