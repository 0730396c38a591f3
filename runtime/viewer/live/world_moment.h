// A world at one moment, as much of it as a picture needs.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "runtime/frames/pose.h"
#include "runtime/scene/scene_world.h"

namespace tremolo {

// A body's coordinates, kg^1/2 m, and where its mesh's frame is. positions, normals: only of a
// body on bones, x y z ..., in the world, whose pose is then the world's.
struct BodyMoment {
  Eigen::VectorXd q;
  Pose pose;
  std::vector<float> positions, normals;
};

// A hand that holds: where what it holds is, and where it is itself, m, world.
struct HandMoment {
  bool holds = false;
  Eigen::Vector3d held = Eigen::Vector3d::Zero(), point = Eigen::Vector3d::Zero();
};

struct WorldMoment {
  double time = 0.0;  // s
  std::vector<BodyMoment> bodies;
  std::vector<Pose> colliders;
  std::vector<HandMoment> hands;  // the scene's, then the user's
};

// Writes over `moment` where the world's bodies and colliders are; hands are the caller's. Nothing
// is allocated from the second call on. Errors of Body::surface.
Status look_at_world(const SceneWorld& world, WorldMoment& moment);

// share: 0 is `a`, 1 is `b`, which have the same bodies. Coordinates and places go straight, turns
// along the shorter arc at even speed.
void between(const WorldMoment& a, const WorldMoment& b, double share, WorldMoment& out);

}  // namespace tremolo
