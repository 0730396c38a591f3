// A scene: everything that moves, and what moves it, as plain values. Units are SI; vectors are
// along the world's axes. SceneWorld (runtime/scene/scene_world.h) makes it go.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "common/load_signal.h"
#include "common/result.h"
#include "runtime/body.h"
#include "runtime/scene/motion.h"

namespace tremolo {

// A force on vertices, times a course in time. at: a vertex's id or a selector on the boundary; the
// force, N, is shared by its vertices. Empty: the model's default load, and no force. scale:
// multiplies either. table: of a signal of the kind kTable.
struct SceneLoad {
  Signal signal;
  std::shared_ptr<const SignalTable> table;
  std::string at;
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  double scale = 1.0;
};

// What a run writes of one body: vertices or selectors whose displacement is recorded, and
// coordinates ("3", "0-5", "all"); velocities: of these too.
struct SceneColumns {
  std::vector<std::string> probes;
  std::vector<std::string> coordinates;
  bool velocities = false;
};

// name: each body's own. model: path of the basis file; made_by: the command that makes it, told
// where it is missing. options.step is not read: a scene has one step. pose: at t = 0; a motion
// moves the frame from there. velocity, m/s, of the centre of mass, and spin, rad/s: of a free body
// at t = 0. settled: it begins in the shape in which gravity and its loads at t = 0 hold it at rest
// in its frame; not for a free body. acceleration_limit, m/s^2: no point of the body may be
// accelerated more by its frame. A fixed body at a pose of its own is driven by a motion that
// stands still.
struct SceneBody {
  std::string name;
  std::string model;
  std::string made_by;
  ModelOptions model_options;
  FrameKind kind = FrameKind::kFixed;
  std::string integrator{kDefaultIntegrator};
  IntegratorOptions options;
  Pose pose;
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  Eigen::Vector3d spin = Eigen::Vector3d::Zero();
  bool settled = false;
  std::vector<SceneLoad> loads;
  Motion motion;
  double acceleration_limit = 1e4;
  SceneColumns columns;
};

// Gravity, m/s^2: values at moments (s, ascending), straight lines between; one value is constant.
// Before the first and after the last moment it stays. Empty: none.
struct SceneGravity {
  std::vector<double> times;
  std::vector<Eigen::Vector3d> values;

  Eigen::Vector3d at(double t) const;
};

// Reserved: what bodies touch. SceneWorld refuses a scene that has any.
enum class ColliderShape { kPlane, kSphere, kCapsule, kBox, kCylinder, kMesh };
struct SceneCollider {
  std::string name;
  ColliderShape shape = ColliderShape::kPlane;
  Eigen::Vector3d size = Eigen::Vector3d::Zero();  // m: radius, radius and length, or half edges
  std::string file;                                // of kMesh
  Pose pose;
  Motion motion;
  double friction = 0.0;
  double restitution = 1.0;
};

// Reserved: a spring from a vertex of a body to a point that moves. SceneWorld refuses them.
struct SceneHand {
  std::string body;
  std::string at;
  double stiffness = 0.0;  // N/m
  Motion motion;
};

struct Scene {
  double step = 3e-3;      // s, of all bodies
  double duration = 30.0;  // s
  SceneGravity gravity;
  std::vector<SceneBody> bodies;
  std::vector<SceneCollider> colliders;
  std::vector<SceneHand> hands;
};

// Errors, kContent, each with the body or key it is about: no body, names that are
// empty or stand twice, a step or duration that is not positive and finite, a pose, velocity,
// gravity, force or motion that is not finite or out of range, a motion of a body that is not
// driven, velocities of one that is not free, colliders and hands.
Status check_scene(const Scene& scene);

}  // namespace tremolo
