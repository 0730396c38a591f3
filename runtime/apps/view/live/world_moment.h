// The state of a world at one time, as far as a picture needs it.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "runtime/math/pose.h"
#include "runtime/world/scene_world.h"

namespace tremolo {

// Coordinates, kg^1/2 m, and pose of a body's mesh frame. positions, normals: only for a body on
// bones and for a guest of the world, x y z ..., in the world; the pose is then the identity.
// degrees: of the vertices of a body of tetrahedra, the fraction of its element's edges that are
// quadratic.
struct BodyMoment {
  Eigen::VectorXd q;
  Pose pose;
  std::vector<float> positions, normals, degrees;
};

// A hand that holds a vertex: positions of the vertex and of the hand, m, world.
struct HandMoment {
  bool holds = false;
  Eigen::Vector3d held = Eigen::Vector3d::Zero(), point = Eigen::Vector3d::Zero();
};

struct WorldMoment {
  double time = 0.0;               // s
  std::vector<BodyMoment> bodies;  // those of the world, then its guests
  std::vector<Pose> colliders;
  std::vector<HandMoment> hands;  // the scene's, then the user's
};

class LiveGuests;

// Overwrites `moment` with the states of the world's bodies, guests and colliders; the caller sets
// the hands. Allocates nothing from the second call on. Errors of Body::surface.
Status look_at_world(const SceneWorld& world, const LiveGuests& guests, WorldMoment& moment);

// share: 0 is `a`, 1 is `b`, which have the same bodies. Coordinates and positions are interpolated
// linearly, rotations along the shorter arc at constant speed.
void between(const WorldMoment& a, const WorldMoment& b, double share, WorldMoment& out);

}  // namespace tremolo
