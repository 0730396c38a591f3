// What bodies bump into: shapes in frames of their own, and how far a point is from them.
//
// Each shape is a solid with its centre at the origin and its axis along z. The signed distance d
// of a point is positive outside; where it is smooth its gradient has length 1 and is the direction
// of the shortest way out. All lengths are in metres.
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

// A triangle mesh, as its distances on a grid; copies share them.
struct GridShape {
  std::shared_ptr<const DistanceGrid> grid;
};

using Collider =
    std::variant<PlaneShape, SphereShape, CapsuleShape, BoxShape, CylinderShape, GridShape>;

// A collider file (docs/collider-format.md) as a GridShape. Errors as of read_collider().
Result<Collider> load_collider(const std::string& path);

// "plane", "sphere", "capsule", "box", "cylinder" or "grid".
const char* shape_name(const Collider& collider);

// Errors (kContent) name the shape and the value: a radius or half extent that is not positive, a
// half_length that is negative, what is not finite or above 1e15 or (but for a half_length) below
// 1e-15, a grid that is not there. The functions below are for colliders that passed.
Status check(const Collider& collider);

// distance: negative inside. normal: the gradient of `distance`. Of all shapes but a grid it has
// length 1; where the gradient does not exist (centres, axes, edges inside) it is one of the ways
// out that are equally short. Of a grid it is the gradient of the grid's interpolant exactly, so
// that forces along it have a potential: its length is 1 up to the grid's error, and may be
// anything down to 0 on the middle surface inside.
struct CollisionDistance {
  double distance = 0;
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
};

// x: in the shape's frame, finite. Never NaN. Allocates nothing; safe from several threads.
CollisionDistance signed_distance(const Collider& collider, const Eigen::Vector3d& x);

// The smallest axis-aligned box in the shape's frame that contains the solid; that of a grid is
// wider by two cells at most, that of a plane is infinite in x, y and downwards.
BoundingBox bounds(const Collider& collider);

// The longest side of bounds(); infinite for a plane.
double largest_extent(const Collider& collider);

// Where a point that moves on a straight line first comes as near as `level`: the smallest fraction
// in [0, 1] at which the distance is at most `level`, 0 if it is from the start, nullopt if it
// never is. Both ends in the shape's frame, finite.
//
// All shapes but a grid are convex, so that the distance along the line is a convex function, for
// which Newton's method goes from below to its first root without passing it, and the answer is
// good to rounding: nothing is tunnelled, however thin or fast. Along a grid the steps are two
// thirds of the distance and at least an eighth of a cell: a dip of the distance that is shorter
// than this may be passed over. At the fraction returned, the distance of a grid is at most
// `level`, and by less than a millionth of a cell.
std::optional<double> first_hit(const Collider& collider, const Eigen::Vector3d& from,
                                const Eigen::Vector3d& to, double level = 0.0);

}  // namespace tremolo
