// The distance by which a body's collision shape extends beyond the body.
//
// The convex hulls of the two are compared by their support functions: the largest n.x of the shape
// less the largest n.x of the boundary's vertices, over many directions n. A shape may fill a
// hollow of the body, and it may be smaller than the body.
#pragma once

#include <string>

#include <Eigen/Core>

#include "common/result.h"
#include "runtime/contact/collider.h"
#include "runtime/model.h"

namespace tremolo {

// `tremolo run` warns of a shape that extends beyond the body by more than this fraction of the
// boundary's longest side: other bodies then rest on a surface where the body's own points feel
// nothing, so that it lies on the floor while they hover over it. Facets of a coarse mesh are
// inside the smooth surface by less than that: 2 % with 12 edges around a ball.
inline constexpr double kShapeBeyond = 0.05;
// Beyond this fraction the shape is refused: it is not this body's shape, or has other units.
inline constexpr double kShapeRefused = 1.0;

// Result of shape_beyond().
struct ShapeReach {
  // The largest distance, m. Negative: the shape lies inside. Infinite for a plane.
  double distance = 0.0;
  // Direction of that distance, of length one, in the mesh's coordinates.
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();
  double size = 0.0;  // the boundary's longest side, m
};
// The shape must have passed check(); the model must have a boundary.
ShapeReach shape_beyond(const Model& model, const Collider& shape);

// "the sphere extends 0.02 m beyond the body along [0, 0, 1], 20 % of the body's size".
std::string reach_text(const Collider& shape, const ShapeReach& reach);

// Error kContent: a shape beyond kShapeRefused.
Status check_reach(const Model& model, const Collider& shape);

// The radius of a ball about `centre` (m, the shape's frame) that holds the shape.
double radius_about(const Collider& shape, const Eigen::Vector3d& centre);

}  // namespace tremolo
