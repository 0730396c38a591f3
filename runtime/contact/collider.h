// Shapes with which bodies collide, in frames of their own, and the distance of a point from them.
//
// Each shape is a solid with its centre at the origin and its axis along z. The signed distance d
// of a point is positive outside. Where d is smooth, its gradient has length 1 and points along the
// shortest path out of the shape. All lengths are in metres.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <variant>

#include <Eigen/Core>

#include "common/distance/distance_grid.h"
#include "common/result.h"

namespace tremolo {

// All of z <= 0.
struct PlaneShape {};

struct SphereShape {
  double radius = 1;
};

// All points within `radius` of the segment from z = -half_length to half_length; a half_length of
// 0 is a sphere.
struct CapsuleShape {
  double radius = 1;
  double half_length = 1;
};

struct BoxShape {
  Eigen::Vector3d half_extents = Eigen::Vector3d::Ones();
};

struct CylinderShape {
  double radius = 1;
  double half_length = 1;
};

// A triangle mesh, given as its distances on a grid; copies share the grid.
struct GridShape {
  std::shared_ptr<const DistanceGrid> grid;
};

using Collider =
    std::variant<PlaneShape, SphereShape, CapsuleShape, BoxShape, CylinderShape, GridShape>;

// Loads a collider file (docs/collider-format.md) as a GridShape. Errors: same as for
// read_collider().
Result<Collider> load_collider(const std::string& path);

// "plane", "sphere", "capsule", "box", "cylinder" or "grid".
const char* shape_name(const Collider& collider);

// Errors (kContent) name the shape and the value: a radius or half extent that is not positive, a
// negative half_length, a value that is not finite, above 1e15 or (except a half_length) below
// 1e-15, or a missing grid. The functions below are for colliders that passed.
Status check(const Collider& collider);

// Distance of a point from a shape, and its gradient.
struct CollisionDistance {
  double distance = 0;  // negative inside, m
  // Gradient of `distance`. Except for a grid it has length 1; where the gradient does not exist
  // (centres, axes, edges inside) it is one of the equally short directions out.
  //
  // For a grid it is the exact gradient of the grid's interpolant, so that forces along it have a
  // potential: its length is 1 up to the grid's error, and any smaller value on the middle surface
  // inside.
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
};

// x: in the shape's frame, finite. Never NaN. Allocates nothing; safe from several threads.
CollisionDistance signed_distance(const Collider& collider, const Eigen::Vector3d& x);

// The smallest axis-aligned box in the shape's frame that contains the solid. For a grid it is
// wider by at most two cells; for a plane it is infinite in x, y and downwards.
BoundingBox bounds(const Collider& collider);

// The longest side of bounds(); infinite for a plane.
double largest_extent(const Collider& collider);

// The first point of a straight path at a distance of at most `level`, as a fraction of the path in
// [0, 1]: 0 if that is the start, nullopt if there is none. from, to: in the shape's frame, finite.
//
// All shapes except a grid are convex. The distance along the line is then a convex function, for
// which Newton's method reaches the first root from below without passing it. The result is exact
// to rounding: no thin or fast obstacle is tunnelled through.
//
// Along a grid the steps are two thirds of the distance and at least an eighth of a cell, so that a
// dip of the distance shorter than this may be missed. At the fraction returned the distance of a
// grid is at most `level`, by less than a millionth of a cell.
std::optional<double> first_hit(const Collider& collider, const Eigen::Vector3d& from,
                                const Eigen::Vector3d& to, double level = 0.0);

// Points that pass through obstacles. Contact evaluates a distance at both ends of a step. A point
// that has left on the other side by then, or is past the middle, was never pushed back. Such
// points are counted, so that a run can report them.

// A position in a shape's frame, and its distance from the shape.
struct PassagePoint {
  Eigen::Vector3d place = Eigen::Vector3d::Zero();    // m
  double distance = 0.0;                              // m
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  // gradient of the distance
};

// True if a point that came from outside has passed through the shape to another side: the normals
// of its ends are more than a right angle apart, and it is inside at the end or was on its straight
// path. Along a grid same as for first_hit().
bool goes_through(const Collider& shape, const PassagePoint& from, const PassagePoint& to);

// The length of the shortest path from outside through the shape, m: the deepest point inside has
// this distance from the surface. Infinite for a plane, which has no other side; 0 for a grid,
// whose thinnest part is not known.
double least_passage(const Collider& shape);

}  // namespace tremolo
