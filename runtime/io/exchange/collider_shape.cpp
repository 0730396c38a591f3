#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "runtime/io/exchange/recording.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

constexpr int kSectors = 72;  // around the axis: the sagitta is 1 - cos(pi/72), 0.1 % of a radius
constexpr int kRings = 18;    // from the equator to a pole

struct Solid {
  std::vector<Vector3d> vertices;
  std::vector<Triangle> triangles;

  VertexId add(const Vector3d& x) {
    vertices.push_back(x);
    return static_cast<VertexId>(vertices.size()) - 1;
  }
  void add_quad(VertexId a, VertexId b, VertexId c, VertexId d) {
    triangles.push_back({a, b, c});
    triangles.push_back({a, c, d});
  }
};

// A circle about the z axis, of which the first vertex is returned.
VertexId add_circle(Solid& solid, double radius, double z) {
  const auto first = static_cast<VertexId>(solid.vertices.size());
  for (int k = 0; k < kSectors; ++k) {
    const double angle = 2.0 * std::numbers::pi * k / kSectors;
    solid.add({radius * std::cos(angle), radius * std::sin(angle), z});
  }
  return first;
}

void add_band(Solid& solid, VertexId below, VertexId above) {
  for (int k = 0; k < kSectors; ++k) {
    const int next = (k + 1) % kSectors;
    solid.add_quad(below + k, below + next, above + next, above + k);
  }
}

// A lid from a circle to a point of the axis; up: it is above.
void add_lid(Solid& solid, VertexId circle, double z, bool up) {
  const VertexId tip = solid.add({0, 0, z});
  for (int k = 0; k < kSectors; ++k) {
    const VertexId a = circle + k, b = circle + (k + 1) % kSectors;
    solid.triangles.push_back(up ? Triangle{a, b, tip} : Triangle{b, a, tip});
  }
}

Solid make_capsule(double radius, double half) {
  Solid solid;
  // Angle above the equator and end of the segment; the equator is listed once for each end.
  std::vector<std::pair<double, double>> circles;
  for (int ring = -kRings + 1; ring < kRings; ++ring) {
    const double angle = 0.5 * std::numbers::pi * ring / kRings;
    if (ring <= 0) circles.emplace_back(angle, -half);
    if (ring > 0 || (ring == 0 && half > 0.0)) circles.emplace_back(angle, half);
  }
  VertexId lowest = 0, last = 0;
  for (std::size_t k = 0; k < circles.size(); ++k) {
    const auto& [angle, end] = circles[k];
    const VertexId circle =
        add_circle(solid, radius * std::cos(angle), end + radius * std::sin(angle));
    if (k == 0) lowest = circle;
    if (k > 0) add_band(solid, last, circle);
    last = circle;
  }
  add_lid(solid, lowest, -half - radius, false);
  add_lid(solid, last, half + radius, true);
  return solid;
}

// Lids have vertices of their own, so that the edge stays sharp.
Solid make_cylinder(double radius, double half) {
  Solid solid;
  const VertexId below = add_circle(solid, radius, -half), above = add_circle(solid, radius, half);
  add_band(solid, below, above);
  const VertexId bottom = add_circle(solid, radius, -half), top = add_circle(solid, radius, half);
  add_lid(solid, bottom, -half, false);
  add_lid(solid, top, half, true);
  return solid;
}

// Six faces with corners of their own.
Solid make_box(const Vector3d& half) {
  Solid solid;
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {-1.0, 1.0}) {
      const int u = (axis + 1) % 3, v = (axis + 2) % 3;
      VertexId corners[4];
      for (int k = 0; k < 4; ++k) {
        Vector3d x;
        x[axis] = side * half[axis];
        x[u] = (k == 1 || k == 2 ? side : -side) * half[u];
        x[v] = (k >= 2 ? 1.0 : -1.0) * half[v];
        corners[k] = solid.add(x);
      }
      solid.add_quad(corners[0], corners[1], corners[2], corners[3]);
    }
  return solid;
}

Solid make_square(double half) {
  Solid solid;
  for (const auto& [x, y] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}})
    solid.add({half * x, half * y, 0.0});
  solid.add_quad(0, 1, 2, 3);
  return solid;
}

}  // namespace

std::optional<AnimatedShape> collider_shape(const Collider& collider, const std::string& name,
                                            double plane) {
  Solid solid;
  if (std::holds_alternative<PlaneShape>(collider)) {
    solid = make_square(plane);
  } else if (const auto* sphere = std::get_if<SphereShape>(&collider)) {
    solid = make_capsule(sphere->radius, 0.0);
  } else if (const auto* capsule = std::get_if<CapsuleShape>(&collider)) {
    solid = make_capsule(capsule->radius, capsule->half_length);
  } else if (const auto* box = std::get_if<BoxShape>(&collider)) {
    solid = make_box(box->half_extents);
  } else if (const auto* cylinder = std::get_if<CylinderShape>(&collider)) {
    solid = make_cylinder(cylinder->radius, cylinder->half_length);
  } else {
    return std::nullopt;
  }
  AnimatedShape shape;
  shape.name = name;
  shape.plane = std::holds_alternative<PlaneShape>(collider);
  shape.surface.vertices = std::move(solid.vertices);
  shape.surface.triangles = std::move(solid.triangles);
  shape.surface.object_of.assign(shape.surface.triangles.size(), 0);
  shape.surface.material_of.assign(shape.surface.triangles.size(), 0);
  shape.surface.objects = {name};
  shape.surface.materials = {name};
  return shape;
}

}  // namespace tremolo
