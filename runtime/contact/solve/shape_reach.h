// How far the shape that other bodies bump into extends beyond the body.
//
// Compared are the convex hulls of the two, by their support functions: the largest n.x of the
// shape less the largest n.x of the boundary's vertices, over many directions n. A shape may fill a
// hollow of the body, and it may be smaller than the body.
#pragma once

#include <string>

#include <Eigen/Core>

#include "common/result.h"
#include "runtime/contact/collider.h"
#include "runtime/model.h"

namespace tremolo {

// A shape that extends farther beyond the body than this fraction of the boundary's longest side is
// warned of by `tremolo run`: other bodies rest on a surface where the body's own points feel
// nothing, so that it lies on the floor and they hover over it. Facets of a coarse mesh are inside
// of the smooth surface that they stand for, less than that: 2 % with 12 edges around a ball.
inline constexpr double kShapeBeyond = 0.05;
// Beyond this fraction it is refused: it is not this body's shape, or has other units.
inline constexpr double kShapeRefused = 1.0;

// distance: the largest, m, along `direction` (of length one, in the mesh's coordinates). Negative:
// the shape lies inside. Infinite for a plane. size: the boundary's longest side, m.
struct ShapeReach {
  double distance = 0.0;
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();
  double size = 0.0;
};
// The shape must have passed check(), the model have a boundary.
ShapeReach shape_beyond(const Model& model, const Collider& shape);

// "the sphere extends 0.02 m beyond the body along [0, 0, 1], 20 % of the body's size".
std::string reach_text(const Collider& shape, const ShapeReach& reach);

// kContent for a shape beyond kShapeRefused.
Status check_reach(const Model& model, const Collider& shape);

// The radius of a ball about `centre` (m, the shape's frame) that holds the shape.
double radius_about(const Collider& shape, const Eigen::Vector3d& centre);

}  // namespace tremolo
