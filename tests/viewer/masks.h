// Silhouettes of pictures, and what they are by the tests' own rasteriser.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "common/mesh/surface_mesh.h"
#include "runtime/apps/view/picture/png_file.h"
#include "tests/viewer/viewer_files.h"

namespace tremolo::testing {

// Coverage of each pixel by bodies, 0 to 1.
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

inline Eigen::Vector3d vector_of(const nlohmann::json& json) {
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
  Eigen::Vector2d pixel(const Eigen::Vector3d& x) const {
    const Eigen::Vector3d d = x - eye_;
    const double depth = forward_.dot(d);
    return {0.5 * width_ + focal_ * right_.dot(d) / depth,
            0.5 * height_ + focal_ * down_.dot(d) / depth};
  }

 private:
  Eigen::Vector3d eye_, forward_, right_, down_;
  double focal_ = 1.0;
  int width_, height_;
};

inline double side_of(const Eigen::Vector2d& a, const Eigen::Vector2d& b,
                      const Eigen::Vector2d& p) {
  return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
}

// Each pixel has kFine x kFine samples, one behind the other.
inline constexpr int kFine = 4;

inline void fill(std::vector<char>& inside, int width, int height, const Eigen::Vector2d& a,
                 const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
  const Eigen::Vector2d low = a.cwiseMin(b).cwiseMin(c), high = a.cwiseMax(b).cwiseMax(c);
  for (int y = std::max(0, static_cast<int>(low[1])); y < std::min<double>(height, high[1]); ++y)
    for (int x = std::max(0, static_cast<int>(low[0])); x < std::min<double>(width, high[0]); ++x) {
      const Eigen::Vector2d p(x + 0.5, y + 0.5);
      const double u = side_of(a, b, p), v = side_of(b, c, p), w = side_of(c, a, p);
      if ((u >= 0 && v >= 0 && w >= 0) || (u <= 0 && v <= 0 && w <= 0)) inside[y * width + x] = 1;
    }
}

inline Mask expected_mask(const std::vector<SurfaceMesh>& surfaces, const nlohmann::json& json) {
  Mask mask{json["width"], json["height"], {}};
  const int width = kFine * mask.width, height = kFine * mask.height;
  std::vector<char> inside(static_cast<std::size_t>(width * height));
  const Pinhole camera(json["camera"], mask.width, mask.height);
  for (const SurfaceMesh& surface : surfaces) {
    const auto at = [&](VertexId v) {
      return Eigen::Vector2d(kFine * camera.pixel(surface.vertices[static_cast<std::size_t>(v)]));
    };
    for (const Triangle& t : surface.triangles)
      fill(inside, width, height, at(t[0]), at(t[1]), at(t[2]));
  }
  mask.cover.resize(static_cast<std::size_t>(mask.width * mask.height));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      mask.cover[y / kFine * mask.width + x / kFine] +=
          inside[y * width + x] / double{kFine * kFine};
  return mask;
}

// The mask of a body without blue before white: quarters of a pixel, four samples, that are not
// white.
inline Mask seen_mask(const Picture& picture) {
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
inline void expect_alike(const Mask& seen, const Mask& expected) {
  ASSERT_EQ(seen.cover.size(), expected.cover.size());
  double different = 0.0;
  for (std::size_t i = 0; i < seen.cover.size(); ++i)
    different += std::abs(seen.cover[i] - expected.cover[i]);
  EXPECT_GT(expected.area(), 1000.0);
  EXPECT_NEAR(seen.area(), expected.area(), 0.001 * expected.area());
  EXPECT_LT(different, 0.008 * expected.area());
  EXPECT_LT((seen.centroid() - expected.centroid()).norm(), 0.05);
}

inline Picture picture_of(const Shots& shots, std::size_t frame) {
  auto picture = read_png(shots.json["frames"][frame]["file"]);
  EXPECT_TRUE(picture);
  return picture ? std::move(*picture) : Picture{};
}

// All bodies in a colour without blue, before white.
inline const std::string kFlat = " --background white --paint '#400000' --lights 2 ";

}  // namespace tremolo::testing
