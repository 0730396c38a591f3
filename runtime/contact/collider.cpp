#include "runtime/contact/collider.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "formats/collider/collider_file.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// The squares of lengths between these are far from zero and from infinity.
constexpr double kShortest = 1e-15;
constexpr double kLongest = 1e15;

double sign_of(double x) {
  return x < 0.0 ? -1.0 : 1.0;
}

// Length and direction of v; `otherwise` is the direction of a zero vector.
double length_and_direction(const Vector3d& v, const Vector3d& otherwise, Vector3d& direction) {
  const double squared = v.squaredNorm();
  if (squared > 1e-200 && squared < 1e200) {
    const double length = std::sqrt(squared);
    direction = v / length;
    return length;
  }
  const double largest = v.cwiseAbs().maxCoeff();
  if (!(largest > std::numeric_limits<double>::min())) {
    direction = otherwise;
    return 0.0;
  }
  const Vector3d scaled = v / largest;
  const double length = scaled.norm();
  direction = scaled / length;
  return largest * length;
}

CollisionDistance distance_of(const PlaneShape&, const Vector3d& x) {
  return {x.z(), Vector3d::UnitZ()};
}

CollisionDistance distance_of(const SphereShape& sphere, const Vector3d& x) {
  CollisionDistance found;
  found.distance = length_and_direction(x, Vector3d::UnitZ(), found.normal) - sphere.radius;
  return found;
}

CollisionDistance distance_of(const CapsuleShape& capsule, const Vector3d& x) {
  const double along = std::clamp(x.z(), -capsule.half_length, capsule.half_length);
  CollisionDistance found;
  found.distance =
      length_and_direction({x.x(), x.y(), x.z() - along}, Vector3d::UnitX(), found.normal) -
      capsule.radius;
  return found;
}

CollisionDistance distance_of(const BoxShape& box, const Vector3d& x) {
  const Vector3d beyond = x.cwiseAbs() - box.half_extents;
  int axis = 0;
  const double most = beyond.maxCoeff(&axis);
  CollisionDistance found{most, Vector3d::Zero()};
  found.normal[axis] = sign_of(x[axis]);
  if (!(most > 0.0)) return found;
  Vector3d out = beyond.cwiseMax(0.0);
  for (int i = 0; i < 3; ++i) out[i] *= sign_of(x[i]);
  found.distance = length_and_direction(out, found.normal, found.normal);
  return found;
}

CollisionDistance distance_of(const CylinderShape& cylinder, const Vector3d& x) {
  Vector3d radial;
  const double aside =
      length_and_direction({x.x(), x.y(), 0.0}, Vector3d::UnitX(), radial) - cylinder.radius;
  const double above = std::abs(x.z()) - cylinder.half_length;
  const Vector3d axial = sign_of(x.z()) * Vector3d::UnitZ();
  if (aside > 0.0 && above > 0.0) {
    CollisionDistance found;
    found.distance = length_and_direction(aside * radial + above * axial, radial, found.normal);
    return found;
  }
  return aside > above ? CollisionDistance{aside, radial} : CollisionDistance{above, axial};
}

CollisionDistance distance_of(const GridShape& shape, const Vector3d& x) {
  const DistanceGrid::Sample sample = shape.grid->at(x);
  return {sample.distance, sample.gradient};
}

BoundingBox around_origin(const Vector3d& half) {
  return {-half, half};
}

BoundingBox bounds_of(const PlaneShape&) {
  return {Vector3d::Constant(-kInfinity), Vector3d(kInfinity, kInfinity, 0.0)};
}
BoundingBox bounds_of(const SphereShape& sphere) {
  return around_origin(Vector3d::Constant(sphere.radius));
}
BoundingBox bounds_of(const CapsuleShape& capsule) {
  return around_origin({capsule.radius, capsule.radius, capsule.half_length + capsule.radius});
}
BoundingBox bounds_of(const BoxShape& box) {
  return around_origin(box.half_extents);
}
BoundingBox bounds_of(const CylinderShape& cylinder) {
  return around_origin({cylinder.radius, cylinder.radius, cylinder.half_length});
}
BoundingBox bounds_of(const GridShape& shape) {
  return shape.grid->solid_box();
}

Error bad_value(const char* shape, const char* what, double value, const char* expected) {
  return content_error(std::string(shape) + " collider: " + what + " is " + std::to_string(value) +
                       ", expected " + expected);
}

Status check_length(const char* shape, const char* what, double value) {
  if (value >= kShortest && value <= kLongest) return Success{};
  return bad_value(shape, what, value, "a positive length of 1e-15 to 1e15 m");
}

Status check_half_length(const char* shape, double value) {
  if (value >= 0.0 && value <= kLongest) return Success{};
  return bad_value(shape, "half_length", value, "0 to 1e15 m");
}

Status check_shape(const PlaneShape&) {
  return Success{};
}
Status check_shape(const SphereShape& sphere) {
  return check_length("sphere", "radius", sphere.radius);
}
Status check_shape(const CapsuleShape& capsule) {
  if (Status status = check_length("capsule", "radius", capsule.radius); !status) return status;
  return check_half_length("capsule", capsule.half_length);
}
Status check_shape(const BoxShape& box) {
  for (const double half : box.half_extents)
    if (Status status = check_length("box", "a half extent", half); !status) return status;
  return Success{};
}
Status check_shape(const CylinderShape& cylinder) {
  if (Status status = check_length("cylinder", "radius", cylinder.radius); !status) return status;
  return check_length("cylinder", "half_length", cylinder.half_length);
}
Status check_shape(const GridShape& shape) {
  if (shape.grid != nullptr) return Success{};
  return content_error("grid collider: there is no grid");
}

// Newton's method on a convex function: the tangent lies below it, so the tangent's root is never
// behind the first root of the function. If the distance does not fall, it never will.
template <class Shape>
std::optional<double> hit_of(const Shape& shape, const Vector3d& from, const Vector3d& to,
                             double level) {
  const Vector3d way = to - from;
  const double reach = std::max(from.cwiseAbs().maxCoeff(), to.cwiseAbs().maxCoeff());
  const double rounding = 4.0 * std::numeric_limits<double>::epsilon() * (reach + std::abs(level));
  double at = 0.0;
  // Towards a line that is tangent to the shape, each step covers half of the remaining path.
  for (int step = 0; step < 100; ++step) {
    const CollisionDistance here = distance_of(shape, from + at * way);
    const double left = here.distance - level;
    if (left <= rounding) return at;
    const double slope = here.normal.dot(way);
    if (!(slope < 0.0)) return std::nullopt;
    const double next = at - left / slope;
    if (!(next <= 1.0)) {
      // The end itself may be at the level up to rounding.
      if (distance_of(shape, to).distance <= level) return 1.0;
      return std::nullopt;
    }
    if (next == at) return at;
    at = next;
  }
  return at;
}

// Returns the fraction between `free`, where the distance is above the level, and `hit`, where it
// is not.
double bisect(const DistanceGrid& grid, const Vector3d& from, const Vector3d& way, double level,
              double free, double hit) {
  const double fine = 1e-7 * grid.nodes().spacing / way.norm();
  while (hit - free > fine) {
    const double middle = 0.5 * (free + hit);
    if (middle <= free || middle >= hit) break;
    (grid.at(from + middle * way).distance > level ? free : hit) = middle;
  }
  return hit;
}

std::optional<double> hit_of(const GridShape& shape, const Vector3d& from, const Vector3d& to,
                             double level) {
  const DistanceGrid& grid = *shape.grid;
  const Vector3d way = to - from;
  const double length = way.stableNorm();
  if (grid.at(from).distance <= level) return 0.0;
  if (!(length > 0.0)) return std::nullopt;
  // Near kinks the interpolant is steeper than a distance, but by less than half.
  constexpr double kShare = 2.0 / 3.0;
  const double least = 0.125 * grid.nodes().spacing;
  double at = 0.0;
  double left = grid.at(from).distance - level;
  while (at < 1.0) {
    const double next = std::min(1.0, at + std::max(kShare * left, least) / length);
    if (!(next > at)) return at;
    left = grid.at(from + next * way).distance - level;
    if (left <= 0.0) return bisect(grid, from, way, level, at, next);
    at = next;
  }
  return std::nullopt;
}

}  // namespace

Result<Collider> load_collider(const std::string& path) {
  Result<ColliderFile> file = read_collider(path);
  if (!file) return file.error();
  return Collider(GridShape{std::make_shared<const DistanceGrid>(std::move(file->grid))});
}

const char* shape_name(const Collider& collider) {
  constexpr const char* kNames[] = {"plane", "sphere", "capsule", "box", "cylinder", "grid"};
  static_assert(std::size(kNames) == std::variant_size_v<Collider>);
  return kNames[collider.index()];
}

Status check(const Collider& collider) {
  return std::visit([](const auto& shape) { return check_shape(shape); }, collider);
}

CollisionDistance signed_distance(const Collider& collider, const Vector3d& x) {
  return std::visit([&x](const auto& shape) { return distance_of(shape, x); }, collider);
}

BoundingBox bounds(const Collider& collider) {
  return std::visit([](const auto& shape) { return bounds_of(shape); }, collider);
}

double largest_extent(const Collider& collider) {
  const BoundingBox box = bounds(collider);
  return (box.high - box.low).maxCoeff();
}

std::optional<double> first_hit(const Collider& collider, const Vector3d& from, const Vector3d& to,
                                double level) {
  return std::visit([&](const auto& shape) { return hit_of(shape, from, to, level); }, collider);
}

bool goes_through(const Collider& shape, const PassagePoint& from, const PassagePoint& to) {
  if (from.distance <= 0.0 || !(from.normal.dot(to.normal) < 0.0)) return false;
  const Eigen::Vector3d way = to.place - from.place;
  if (from.normal.dot(way) >= 0.0 || to.normal.dot(way) <= 0.0) return false;
  return to.distance <= 0.0 || first_hit(shape, from.place, to.place).has_value();
}

double least_passage(const Collider& shape) {
  struct Least {
    double operator()(const PlaneShape&) const { return std::numeric_limits<double>::infinity(); }
    double operator()(const SphereShape& sphere) const { return sphere.radius; }
    double operator()(const CapsuleShape& capsule) const { return capsule.radius; }
    double operator()(const BoxShape& box) const { return box.half_extents.minCoeff(); }
    double operator()(const CylinderShape& cylinder) const {
      return std::min(cylinder.radius, cylinder.half_length);
    }
    double operator()(const GridShape&) const { return 0.0; }
  };
  return std::visit(Least{}, shape);
}

}  // namespace tremolo
