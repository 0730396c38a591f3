// Points that pass through obstacles. Contact evaluates a distance at both ends of a step. A point
// that has left on the other side by then, or is past the middle, was never pushed back. Such
// points are counted, so that a run can report them.
#pragma once

#include <Eigen/Core>

#include "runtime/contact/collider.h"

namespace tremolo {

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
