#include "runtime/apps/view/camera/camera.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <Eigen/Geometry>

namespace tremolo {
namespace {

using Eigen::Matrix4d;
using Eigen::Vector3d;

constexpr double kMargin = 1.12;   // size of the picture over that of the framed points
constexpr double kNearest = 1e-3;  // of the distance: closer points are not drawn
constexpr int kLeastSide = 16, kMostSide = 8192;  // pixels
constexpr double kDegreeOfCamera = std::numbers::pi / 180.0;

// The numbers of a list A,B,C; empty if the text is not such a list.
std::vector<double> numbers_of(const std::string& text) {
  std::vector<double> numbers;
  const char* at = text.data();
  const char* end = at + text.size();
  while (true) {
    double value = 0.0;
    const auto [stop, error] = std::from_chars(at, end, value);
    if (error != std::errc{} || !std::isfinite(value)) return {};
    numbers.push_back(value);
    if (stop == end) return numbers;
    if (*stop != ',') return {};
    at = stop + 1;
  }
}

// The range of the points in the picture, as tangents of their directions from the eye.
struct SeenRange {
  double low_x = std::numeric_limits<double>::infinity(), high_x = -low_x;
  double low_y = low_x, high_y = -low_x;
};

SeenRange seen_from(const CameraAxes& axes, const Vector3d& eye, std::span<const double> points) {
  SeenRange range;
  for (std::size_t i = 0; i + 2 < points.size(); i += 3) {
    const Vector3d x = Vector3d(points[i], points[i + 1], points[i + 2]) - eye;
    const double depth = std::max(-axes.back.dot(x), 1e-300);
    const double right = axes.right.dot(x) / depth, up = axes.up.dot(x) / depth;
    range.low_x = std::min(range.low_x, right);
    range.high_x = std::max(range.high_x, right);
    range.low_y = std::min(range.low_y, up);
    range.high_y = std::max(range.high_y, up);
  }
  return range;
}

}  // namespace

Vector3d up_direction(UpAxis up) {
  return up == UpAxis::kZ ? Vector3d::UnitZ() : Vector3d::UnitY();
}

CameraAxes axes_of(const Camera& camera) {
  const Vector3d up = up_direction(camera.up);
  const Vector3d front = camera.up == UpAxis::kZ ? Vector3d(-Vector3d::UnitY()) : Vector3d::UnitZ();
  const Vector3d side = up.cross(front);  // to the right of a viewer of the front
  const double a = camera.azimuth, e = camera.elevation;
  const Vector3d out = std::cos(a) * front + std::sin(a) * side;
  CameraAxes axes;
  axes.right = std::cos(a) * side - std::sin(a) * front;
  axes.back = std::cos(e) * out + std::sin(e) * up;
  axes.up = std::cos(e) * up - std::sin(e) * out;
  return axes;
}

Vector3d eye_of(const Camera& camera) {
  return camera.target + camera.distance * axes_of(camera).back;
}

Matrix4d clip_from_world(const Camera& camera, double aspect, const Vector3d& centre,
                         double radius) {
  const CameraAxes axes = axes_of(camera);
  const Vector3d eye = eye_of(camera);
  const double middle = axes.back.dot(eye - centre);
  const double far = std::max(middle + radius, 2.0 * kNearest * camera.distance);
  const double near = std::max(middle - radius, kNearest * std::max(camera.distance, far));
  Matrix4d view = Matrix4d::Identity();
  view.row(0) << axes.right.transpose(), -axes.right.dot(eye);
  view.row(1) << axes.up.transpose(), -axes.up.dot(eye);
  view.row(2) << axes.back.transpose(), -axes.back.dot(eye);
  const double scale = 1.0 / std::tan(0.5 * camera.view_angle);
  Matrix4d projection = Matrix4d::Zero();
  projection(0, 0) = scale / aspect;
  projection(0, 2) = -camera.shift;
  projection(1, 1) = scale;
  projection(2, 2) = -(far + near) / (far - near);
  projection(2, 3) = -2.0 * far * near / (far - near);
  projection(3, 2) = -1.0;
  return projection * view;
}

CameraRay ray_through(const Camera& camera, double aspect, double x, double y) {
  const CameraAxes axes = axes_of(camera);
  const double height = std::tan(0.5 * camera.view_angle);
  const Vector3d direction = (2.0 * x - 1.0 - camera.shift) * height * aspect * axes.right +
                             (1.0 - 2.0 * y) * height * axes.up - axes.back;
  return {eye_of(camera), direction.normalized()};
}

void frame_points(std::span<const double> points, double aspect, Camera& camera) {
  if (points.size() < 3) return;
  const CameraAxes axes = axes_of(camera);
  Vector3d low = Vector3d::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (std::size_t i = 0; i + 2 < points.size(); i += 3) {
    const Vector3d x(points[i], points[i + 1], points[i + 2]);
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  camera.target = 0.5 * (low + high);
  const double size = std::max((high - low).norm(), 1e-9);
  const double tall = std::tan(0.5 * camera.view_angle) / kMargin;
  // On the side to which the target is shifted there is less room.
  const double wide = tall * aspect * (1.0 - std::abs(camera.shift));
  camera.distance = size / std::tan(0.5 * camera.view_angle);
  // Centre the points, then reduce the distance until they fill the picture; each changes the other
  // a little.
  for (int pass = 0; pass < 20; ++pass) {
    const SeenRange seen = seen_from(axes, eye_of(camera), points);
    camera.target += camera.distance * (0.5 * (seen.low_x + seen.high_x) * axes.right +
                                        0.5 * (seen.low_y + seen.high_y) * axes.up);
    const double fills =
        std::max(0.5 * (seen.high_x - seen.low_x) / wide, 0.5 * (seen.high_y - seen.low_y) / tall);
    camera.distance = std::max(camera.distance * std::clamp(fills, 0.6, 1.6), 0.6 * size);
  }
}

Result<CameraWish> parse_camera(const std::string& text) {
  const std::vector<double> numbers = numbers_of(text);
  if (numbers.size() != 2 && numbers.size() != 3)
    return usage_error("--camera " + text + ": expected AZIMUTH,ELEVATION[,ZOOM] in degrees");
  const double zoom = numbers.size() == 3 ? numbers[2] : 1.0;
  if (std::abs(numbers[1]) > 90.0)
    return content_error("--camera " + text + ": the elevation must be within -90 and 90 degrees");
  if (!(zoom >= 1e-3 && zoom <= 1e3))
    return content_error("--camera " + text + ": the zoom must be from 0.001 to 1000");
  return CameraWish{kDegreeOfCamera * numbers[0], kDegreeOfCamera * numbers[1], zoom};
}

Result<PictureSize> parse_size(const std::string& text) {
  PictureSize size;
  const char* end = text.data() + text.size();
  const auto first = std::from_chars(text.data(), end, size.width);
  if (first.ec == std::errc{} && first.ptr != end && *first.ptr == 'x') {
    const auto second = std::from_chars(first.ptr + 1, end, size.height);
    if (second.ec == std::errc{} && second.ptr == end) {
      for (const int side : {size.width, size.height})
        if (side < kLeastSide || side > kMostSide)
          return content_error("--size " + text + ": both must be from " +
                               std::to_string(kLeastSide) + " to " + std::to_string(kMostSide));
      return size;
    }
  }
  return usage_error("--size " + text + ": expected WIDTHxHEIGHT in pixels, as in 1280x720");
}

}  // namespace tremolo
