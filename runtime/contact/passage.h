// Points that go through what they should bump into. Contact knows a distance at both ends of a
// step; a point that is out again on the other side by then, or past the middle, was never pushed
// back. These are counted, so that a run can say so.
#pragma once

#include <Eigen/Core>

#include "runtime/contact/collider.h"

namespace tremolo {

// A place in a shape's frame, m, and how far and which way it is from the shape.
struct PassagePoint {
  Eigen::Vector3d place = Eigen::Vector3d::Zero();
  double distance = 0.0;
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
};

// Whether a point that came from outside has gone to another side of the shape, through it: the
// normals of its ends are more than a right angle apart, and it is inside at the end or was on its
// straight way. Along a grid as first_hit().
bool goes_through(const Collider& shape, const PassagePoint& from, const PassagePoint& to);

// A way that is shorter leads no point from outside through the shape, m: what lies deepest in it
// is as far from its surface. Infinite for a plane, which has no other side; 0 for a grid, whose
// thinnest part is not known.
double least_passage(const Collider& shape);

}  // namespace tremolo
