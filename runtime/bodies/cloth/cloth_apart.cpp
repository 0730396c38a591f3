// Checks that a scene's cloths do not start inside its balls and colliders.
#include <algorithm>
#include <cmath>
#include <string>
#include <variant>

#include <Eigen/Geometry>

#include "common/text.h"
#include "runtime/bodies/cloth/cloth_world_inside.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

double distance_to_segment(const Vector3d& x, const Vector3d& a, const Vector3d& b) {
  const Vector3d ab = b - a;
  const double along = std::clamp((x - a).dot(ab) / ab.squaredNorm(), 0.0, 1.0);
  return (x - a - along * ab).norm();
}

double distance_to_triangle(const Vector3d& x, const Vector3d& a, const Vector3d& b,
                            const Vector3d& c) {
  const Vector3d normal = (b - a).cross(c - a);
  const auto inwards = [&](const Vector3d& from, const Vector3d& to) {
    return normal.dot((to - from).cross(x - from)) >= 0.0;
  };
  if (inwards(a, b) && inwards(b, c) && inwards(c, a))
    return std::abs(normal.dot(x - a)) / normal.norm();
  return std::min(
      {distance_to_segment(x, a, b), distance_to_segment(x, b, c), distance_to_segment(x, c, a)});
}

struct Sphere {
  std::string name;
  Vector3d center = Vector3d::Zero();
  double radius = 0.0;
};

// Only particles have contact: a sphere between them would not be detected.
Status check_triangles(const WorldCloth& cloth, const Sphere& sphere) {
  const auto held = cloth.model.held();
  for (const Triangle& t : cloth.model.parts().triangles) {
    const auto is_held = [&held](VertexId v) { return held[v] != 0; };
    if (std::all_of(t.begin(), t.end(), is_held)) continue;
    const auto at = [&cloth](VertexId v) -> Vector3d {
      return cloth.state.x.segment<3>(3 * static_cast<Eigen::Index>(v));
    };
    const double deep =
        sphere.radius - distance_to_triangle(sphere.center, at(t[0]), at(t[1]), at(t[2]));
    if (deep > cloth.scene.thickness)
      return content_error("cloth '" + cloth.scene.name + "': the triangle of particles " +
                           std::to_string(t[0]) + ", " + std::to_string(t[1]) + " and " +
                           std::to_string(t[2]) + " begins " + number_text(deep) + " m inside " +
                           sphere.name);
  }
  return Success{};
}

}  // namespace

Status ClothWorld::Inside::check_particles(const WorldCloth& cloth) const {
  const auto held = cloth.model.held();
  for (std::size_t i = 0; i < held.size(); ++i) {
    const Vector3d x = cloth.state.x.segment<3>(3 * static_cast<Eigen::Index>(i));
    if (held[i] != 0) continue;
    const auto inside = [&](const std::string& what, double distance) -> Status {
      if (distance >= -cloth.scene.thickness) return Success{};
      return content_error("cloth '" + cloth.scene.name + "': particle " + std::to_string(i) +
                           " begins " + number_text(-distance) + " m inside " + what);
    };
    for (std::size_t k = 0; k < balls.size(); ++k)
      if (Status s = inside("ball '" + scene.balls[k].name + "'",
                            (x - balls[k].now.position).norm() - balls[k].radius);
          !s)
        return s;
    for (std::size_t k = 0; k < scene.colliders.size(); ++k) {
      const PlacedCollider& placed = colliders.placed()[k];
      const Vector3d place = placed.start.rotation.conjugate() * (x - placed.start.position);
      if (Status s = inside("collider '" + scene.colliders[k].name + "'",
                            signed_distance(placed.shape, place).distance);
          !s)
        return s;
    }
  }
  return Success{};
}

Status ClothWorld::Inside::check_apart() const {
  for (const auto& cloth : cloths) {
    if (Status s = check_particles(*cloth); !s) return s;
    for (std::size_t k = 0; k < balls.size(); ++k) {
      const Sphere ball{"ball '" + scene.balls[k].name + "'", balls[k].now.position,
                        balls[k].radius};
      if (Status s = check_triangles(*cloth, ball); !s) return s;
    }
    for (std::size_t k = 0; k < scene.colliders.size(); ++k)
      if (const auto* shape = std::get_if<SphereShape>(&colliders.placed()[k].shape)) {
        const Sphere sphere{"collider '" + scene.colliders[k].name + "'",
                            colliders.placed()[k].start.position, shape->radius};
        if (Status s = check_triangles(*cloth, sphere); !s) return s;
      }
  }
  return Success{};
}

}  // namespace tremolo
