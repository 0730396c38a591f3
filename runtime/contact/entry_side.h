// The side of an obstacle from which a point came.
//
// The nearest surface of a point that is past the middle of a plate is the far one, whose normal
// would push it out there. Contact therefore keeps the plane of the side where the point came in:
// from the middle on d = n.x + c counts, in the obstacle's coordinates at rest, with the normal n
// and the distance d that the point had at the start of that step. On a flat plate both agree at
// the middle, so that d and its gradient are continuous; d is one of a half-space, and a plate
// stops what a thick wall stops. The plane counts while the surface is where it says, a distance
// |d| back along n; a point that is then beside the obstacle is released.
//
// The same plane counts at an edge, where the nearest surface may be that of the face beside the
// one on which the point came in: on the edge itself its depth is zero, and its normal would push
// the point sideways. Which face a point on an edge has met follows from where its body is: cubes
// whose sides are flush meet with their faces, and those side by side slide along theirs. That is
// for rigid bodies: the edges of deformable ones bulge past each other. That plane continues
// beyond the edge, for four times the depth of the point: a body that slides as it rebounds takes
// its point over the edge before the point is out, and the energy in the contact would be lost.
#pragma once

#include <Eigen/Core>

#include "common/state_stream.h"
#include "runtime/contact/collider.h"

namespace tremolo {

struct EntrySide {
  Eigen::Vector3d normal =
      Eigen::Vector3d::Zero();  // n, length 1; zero: the nearest surface counts
  double offset = 0.0;          // c, m
  double beyond = 0.0;          // its length beyond an edge, m; zero: past the middle

  bool counts() const { return normal.squaredNorm() > 0.0; }
  // d of a position in the obstacle's coordinates at rest, m.
  double at(const Eigen::Vector3d& x) const { return normal.dot(x) + offset; }

  void carry(StateStream& stream) { stream(normal, offset, beyond); }
};

// Distance and normal at x by the side, or by the nearest surface.
CollisionDistance distance_by(const Collider& shape, const EntrySide& side,
                              const Eigen::Vector3d& x);

// True if the surface is where the side's plane says, seen from x.
bool is_behind(const Collider& shape, const EntrySide& side, const Eigen::Vector3d& x);

// True if a point at this distance may be on an edge.
bool is_at_surface(const Collider& shape, double distance);

// The side of a point that begins at x, whose nearest surface is `found`: on an edge that of the
// face on which its body is, else none. inward: the direction from the point to the middle of its
// body, along the obstacle's axes at rest, of length 1; zero if one of the two deforms.
EntrySide side_on_edge(const Collider& shape, const Eigen::Vector3d& x,
                       const CollisionDistance& found, const Eigen::Vector3d& inward);

// The side that counts for a point at `to`, whose nearest surface is `found`. before, from: the
// side and the point at the start of the step. inward: as above. begins: the distance at which
// contact begins, m.
EntrySide side_at(const Collider& shape, const EntrySide& before, const PassagePoint& from,
                  const Eigen::Vector3d& to, const CollisionDistance& found,
                  const Eigen::Vector3d& inward, double begins);

// True if a point at x that its side no longer holds has come out opposite to where it came in.
bool is_through(const Collider& shape, const EntrySide& side, const Eigen::Vector3d& x);

}  // namespace tremolo
