// The side of an obstacle from which a point came.
//
// The nearest surface of a point that is past the middle of a plate is the far one, whose normal
// would push it out there. Contact therefore keeps the plane of the side where the point came in:
// from the middle on d = n.x + c counts, in the obstacle's coordinates at rest, with the normal n
// and the distance d that the point had at the start of that step. On a flat plate both agree at
// the middle, so that d and its gradient are continuous; d is one of a half-space, and a plate
// stops what a thick wall stops. The plane counts while the surface is where it says, a distance
// |d| back along n; a point that is then beside the obstacle is released.
#pragma once

#include <Eigen/Core>

#include "common/state_stream.h"
#include "runtime/contact/collider.h"

namespace tremolo {

struct EntrySide {
  Eigen::Vector3d normal =
      Eigen::Vector3d::Zero();  // n, length 1; zero: the nearest surface counts
  double offset = 0.0;          // c, m

  bool counts() const { return normal.squaredNorm() > 0.0; }
  // d of a position in the obstacle's coordinates at rest, m.
  double at(const Eigen::Vector3d& x) const { return normal.dot(x) + offset; }

  void carry(StateStream& stream) { stream(normal, offset); }
};

// Distance and normal at x by the side, or by the nearest surface.
CollisionDistance distance_by(const Collider& shape, const EntrySide& side,
                              const Eigen::Vector3d& x);

// True if the surface is where the side's plane says, seen from x.
bool is_behind(const Collider& shape, const EntrySide& side, const Eigen::Vector3d& x);

// The side that counts for a point at `to`, whose nearest surface is `found`. before, from: the
// side and the point at the start of the step.
EntrySide side_at(const Collider& shape, const EntrySide& before, const PassagePoint& from,
                  const Eigen::Vector3d& to, const CollisionDistance& found);

}  // namespace tremolo
