#include "runtime/apps/view/shape/collider_shape.h"

#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <variant>

namespace tremolo {
namespace {

using Eigen::Vector3d;

// Of round shapes, and of a hemisphere: an outline is off the circle by 1 - cos(pi/96) of its
// radius, which is less than a fifth of a pixel for a radius of 350 pixels.
constexpr int kSides = 96;
constexpr int kRings = 24;

// A point of the outline of a body of revolution about z: its distance from the axis, its height,
// and the normal there, (outwards, upwards).
struct OutlinePoint {
  double radius = 0.0, height = 0.0;
  double out = 0.0, up = 0.0;
};

// outline: from the top down.
TriangleShape turned_shape(const std::vector<OutlinePoint>& outline) {
  TriangleShape shape;
  for (const OutlinePoint& point : outline)
    for (int side = 0; side <= kSides; ++side) {
      const double angle = 2.0 * std::numbers::pi * side / kSides;
      const double x = std::cos(angle), y = std::sin(angle);
      shape.add({point.radius * x, point.radius * y, point.height},
                {point.out * x, point.out * y, point.up});
    }
  constexpr std::uint32_t kRow = kSides + 1;
  for (std::uint32_t row = 0; row + 1 < outline.size(); ++row)
    for (std::uint32_t side = 0; side < kSides; ++side) {
      const std::uint32_t a = row * kRow + side, b = a + kRow;
      shape.add_triangle(a, b, b + 1);
      shape.add_triangle(a, b + 1, a + 1);
    }
  return shape;
}

TriangleShape capsule_of(double radius, double half_length) {
  std::vector<OutlinePoint> outline;
  for (const double end : {1.0, -1.0})
    for (int ring = 0; ring <= kRings; ++ring) {
      const double angle = 0.5 * std::numbers::pi * ring / kRings;
      const double out = end > 0.0 ? std::sin(angle) : std::cos(angle);
      const double up = end > 0.0 ? std::cos(angle) : -std::sin(angle);
      outline.push_back({radius * out, end * half_length + radius * up, out, up});
    }
  return turned_shape(outline);
}

TriangleShape cylinder_of(double radius, double h) {
  return turned_shape({{0.0, h, 0.0, 1.0},
                       {radius, h, 0.0, 1.0},
                       {radius, h, 1.0, 0.0},
                       {radius, -h, 1.0, 0.0},
                       {radius, -h, 0.0, -1.0},
                       {0.0, -h, 0.0, -1.0}});
}

TriangleShape box_of(const Vector3d& half) {
  TriangleShape shape;
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {1.0, -1.0}) {
      const Vector3d normal = side * Vector3d::Unit(axis);
      const Vector3d across = Vector3d::Unit((axis + 1) % 3);
      const Vector3d along = normal.cross(across);
      std::array<std::uint32_t, 4> corners{};
      constexpr std::array<std::pair<double, double>, 4> kCorners = {
          {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}};
      for (std::size_t k = 0; k < 4; ++k)
        corners[k] = shape.add(
            half.cwiseProduct(normal + kCorners[k].first * across + kCorners[k].second * along),
            normal);
      shape.add_triangle(corners[0], corners[1], corners[2]);
      shape.add_triangle(corners[0], corners[2], corners[3]);
    }
  return shape;
}

struct ShapeMaker {
  double plane_radius;

  TriangleShape operator()(const PlaneShape&) const { return disc_shape(plane_radius); }
  TriangleShape operator()(const SphereShape& shape) const { return ball_shape(shape.radius); }
  TriangleShape operator()(const CapsuleShape& shape) const {
    return capsule_of(shape.radius, shape.half_length);
  }
  TriangleShape operator()(const BoxShape& shape) const { return box_of(shape.half_extents); }
  TriangleShape operator()(const CylinderShape& shape) const {
    return cylinder_of(shape.radius, shape.half_length);
  }
  TriangleShape operator()(const GridShape& shape) const { return iso_surface(*shape.grid); }
};

}  // namespace

TriangleShape ball_shape(double radius) {
  return capsule_of(radius, 0.0);
}

TriangleShape disc_shape(double radius) {
  // Rings make values at vertices accurate near the middle of a large disc.
  std::vector<OutlinePoint> outline;
  for (const double share : {0.0, 0.01, 0.03, 0.1, 0.3, 1.0})
    outline.push_back({share * radius, 0.0, 0.0, 1.0});
  return turned_shape(outline);
}

TriangleShape collider_shape(const Collider& collider, double plane_radius) {
  return std::visit(ShapeMaker{plane_radius}, collider);
}

}  // namespace tremolo
