// The camera: its mapping, and its framing.
#include "runtime/apps/view/camera/camera.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace tremolo {
namespace {

using Eigen::Vector3d;

Camera some_camera(UpAxis up) {
  Camera camera;
  camera.target = {0.2, -0.1, 0.4};
  camera.azimuth = 0.7;
  camera.elevation = -0.3;
  camera.distance = 2.0;
  camera.up = up;
  camera.shift = 0.15;
  return camera;
}

TEST(Camera, ARayThroughAPlaceMeetsWhatIsDrawnThere) {
  for (const UpAxis up : {UpAxis::kY, UpAxis::kZ}) {
    const Camera camera = some_camera(up);
    for (const auto& [x, y] : {std::pair{0.5, 0.5}, {0.1, 0.9}, {0.93, 0.2}}) {
      const CameraRay ray = ray_through(camera, 1.6, x, y);
      const Vector3d place = ray.origin + 1.7 * ray.direction;
      const Eigen::Vector4d clip =
          clip_from_world(camera, 1.6, camera.target, 1.0) * place.homogeneous();
      EXPECT_NEAR(clip[0] / clip[3], 2.0 * x - 1.0, 1e-12);
      EXPECT_NEAR(clip[1] / clip[3], 1.0 - 2.0 * y, 1e-12);
      EXPECT_LT(std::abs(clip[2] / clip[3]), 1.0);
    }
  }
}

TEST(Camera, StandsInFrontOfAWorldAndUpIsUp) {
  Camera camera;
  EXPECT_LT((axes_of(camera).back - Vector3d(0, -1, 0)).norm(), 1e-15);
  EXPECT_LT((axes_of(camera).right - Vector3d(1, 0, 0)).norm(), 1e-15);
  camera.up = UpAxis::kY;
  EXPECT_LT((axes_of(camera).back - Vector3d(0, 0, 1)).norm(), 1e-15);
  EXPECT_LT((axes_of(camera).right - Vector3d(1, 0, 0)).norm(), 1e-15);
  const CameraAxes axes = axes_of(some_camera(UpAxis::kY));
  EXPECT_NEAR(axes.right.cross(axes.up).dot(axes.back), 1.0, 1e-12);
}

TEST(Camera, FramedPointsAreInsideAndFillThePicture) {
  std::mt19937 generator(3);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (const double aspect : {0.5, 1.0, 2.0}) {
    std::vector<double> points;
    for (int i = 0; i < 100; ++i)
      points.insert(points.end(), {5.0 + 0.3 * uniform(generator), 0.1 * uniform(generator),
                                   0.2 * uniform(generator) - 3.0});
    Camera camera = some_camera(UpAxis::kZ);
    frame_points(points, aspect, camera);
    const Eigen::Matrix4d clip = clip_from_world(camera, aspect, camera.target, 10.0);
    double farthest = 0.0;
    for (std::size_t i = 0; i < points.size(); i += 3) {
      const Eigen::Vector4d x =
          clip * Eigen::Vector4d(points[i], points[i + 1], points[i + 2], 1.0);
      farthest = std::max({farthest, (std::abs(x[0] / x[3]) - camera.shift) / (1.0 - camera.shift),
                           std::abs(x[1] / x[3])});
      EXPECT_LT(std::abs(x[0] / x[3]), 1.0);
      EXPECT_LT(std::abs(x[1] / x[3]), 1.0);
    }
    EXPECT_GT(farthest, 0.8) << aspect;
    EXPECT_LT(farthest, 0.95) << aspect;
  }
}

TEST(Camera, TextsAreReadOrRefused) {
  const auto wish = parse_camera("90,-45,2");
  ASSERT_TRUE(wish);
  EXPECT_NEAR(wish->azimuth, 0.5 * std::numbers::pi, 1e-15);
  EXPECT_NEAR(wish->elevation, -0.25 * std::numbers::pi, 1e-15);
  EXPECT_EQ(wish->zoom, 2.0);
  for (const char* text : {"", "1", "1,2,3,4", "a,b", "1,,2", "1,2x", "nan,0"})
    EXPECT_EQ(parse_camera(text).error().kind, ErrorKind::kUsage) << text;
  for (const char* text : {"0,91", "0,0,0", "0,0,-1"})
    EXPECT_EQ(parse_camera(text).error().kind, ErrorKind::kContent) << text;
  ASSERT_TRUE(parse_size("640x480"));
  EXPECT_EQ(parse_size("640x480")->height, 480);
  for (const char* text : {"", "640", "640x", "x480", "640x480x2", "640,480"})
    EXPECT_EQ(parse_size(text).error().kind, ErrorKind::kUsage) << text;
  for (const char* text : {"0x480", "640x9000", "-3x20"})
    EXPECT_EQ(parse_size(text).error().kind, ErrorKind::kContent) << text;
}

}  // namespace
}  // namespace tremolo
