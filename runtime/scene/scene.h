// A scene: everything that moves, and what moves it, as plain values. Units are SI; vectors are
// along the world's axes. SceneWorld (runtime/scene/scene_world.h) makes it go.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "common/load_signal.h"
#include "common/result.h"
#include "runtime/contact/collider.h"
#include "runtime/contact/joint.h"
#include "runtime/contact_body.h"
#include "runtime/scene/motion.h"
#include "runtime/skeleton/bone_weights.h"

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

// A bone of a body. name: its own among the body's bones. parent: the name of one before it, which
// takes it along; empty: the body's frame does. head, tail: its ends at rest, m, in the mesh's
// coordinates; by its distance to them the body hangs on it, unless there are weights. motion: its
// own, relative to the parent, about its head: the parts' positions and axes are along the mesh's
// axes, from the head.
struct SceneBone {
  std::string name;
  std::string parent;
  Eigen::Vector3d head = Eigen::Vector3d::Zero();
  Eigen::Vector3d tail = Eigen::Vector3d::Zero();
  Motion motion;
};

// A value that holds from a moment on, s.
struct ValueFrom {
  double time = 0.0;
  double value = 0.0;
};

// name: each body's own. model: path of the basis file; made_by: the command that makes it, told
// where it is missing. options.step is not read: a scene has one step. alphas, betas: Rayleigh's,
// in the order of time, in the place of options.alpha and beta from the first step on that begins
// then. pose: at t = 0; a motion moves the frame from there. velocity, m/s, of the centre of mass,
// and spin, rad/s: of a free body at t = 0. settled: it begins in the shape in which gravity and
// its loads at t = 0 hold it at rest in its frame; not for a free body. acceleration_limit, m/s^2:
// no point of the body may be accelerated more by its frame. A fixed body at a pose of its own is
// driven by a motion that stands still. feels_contact: it touches the scene's colliders, as contact
// says; a driven, free or turned body then needs avf, ep2 or ep4. Hands hold it either way.
// contact.shape: what other bodies bump into; without one they pass through. shape_file: of a
// mesh's distances, in its place; shape_made_by: the command that makes it, told where it is
// missing. rig: bones, their weights and their motions are those of the model's render surface;
// clip: the name of the motion, empty for the first one. bones: of a driven body that hangs on
// several frames and touches nothing; bone_weights: a row a drawn vertex, a column a bone; none: by
// distance, with bone_blend, m (runtime/bones.h; 0: the usual one).
struct SceneBody {
  std::string name;
  std::string model;
  std::string made_by;
  ModelOptions model_options;
  FrameKind kind = FrameKind::kFixed;
  std::string integrator{kDefaultIntegrator};
  IntegratorOptions options;
  std::vector<ValueFrom> alphas, betas;
  Pose pose;
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  Eigen::Vector3d spin = Eigen::Vector3d::Zero();
  bool settled = false;
  std::vector<SceneLoad> loads;
  Motion motion;
  std::vector<SceneBone> bones;
  BoneWeights bone_weights;
  double bone_blend = 0.0;
  bool rig = false;
  std::string clip;
  double acceleration_limit = 1e4;
  bool feels_contact = true;
  ContactOptions contact;
  std::string shape_file;
  std::string shape_made_by;
  SceneColumns columns;
};

// That of the body in a world: a fixed one at a pose of its own is driven.
FrameKind frame_kind(const SceneBody& body);

// Gravity, m/s^2: values at moments (s, ascending), straight lines between; one value is constant.
// Before the first and after the last moment it stays. Empty: none.
struct SceneGravity {
  std::vector<double> times;
  std::vector<Eigen::Vector3d> values;

  Eigen::Vector3d at(double t) const;
};

// What bodies touch. name: each collider's own. file: of a mesh's distances (tremolo-precompute
// collider); `shape` is then not read; made_by: the command that makes it, told where it is
// missing. pose: of the shape's frame at t = 0; a motion moves it from there. friction: mu,
// restitution: the share of the speed that comes back, 0 to 1; of the pair with whatever touches
// it.
struct SceneCollider {
  std::string name;
  Collider shape;
  std::string file;
  std::string made_by;
  Pose pose;
  Motion motion;
  double friction = 0.3;
  double restitution = 0.5;
};

// A spring and a damper from a vertex of a body to a point that moves. body: its name. at: a
// vertex's id, or a selector of one vertex. It holds from the step that begins at `from`, s, to
// `until`. position: of the point without any motion, m; without one the point is where the vertex
// is when it is taken hold of, and goes on from there as the motion does. What moves the point is
// on the whole way at the end of each step; in its first step it comes from the vertex.
struct SceneHand {
  std::string body;
  std::string at;
  bool pin = false;        // Body::pin: stiffness and damping are not read
  double stiffness = 0.0;  // N/m, above 0
  double damping = 0.0;    // N s/m
  std::optional<Eigen::Vector3d> position;
  Motion motion;
  double from = 0.0;
  double until = kForEver;
};

// A joint between a vertex of a body and one of another (runtime/contact/joint.h). body, to: their
// names. at, to_at: a vertex's id, or a selector of one vertex; without to_at the second place is
// where the first is at t = 0. It holds until `until`, s.
struct SceneJoint {
  std::string body, at;
  std::string to, to_at;
  JointOptions options;
  double until = kForEver;
};

struct Scene {
  double step = 3e-3;      // s, of all bodies
  double duration = 30.0;  // s
  SceneGravity gravity;
  std::vector<SceneBody> bodies;
  std::vector<SceneCollider> colliders;
  std::vector<SceneHand> hands;
  std::vector<SceneJoint> joints;
};

// Whether bodies of the scene may touch each other.
bool bodies_touch(const Scene& scene);

// Whether the body needs Body::set_contact(): colliders or bodies that it feels, a hand or a joint
// on it.
bool needs_contact(const Scene& scene, const SceneBody& body);

// The same for each body of a scene of many, which must outlive it.
class ContactNeeds {
 public:
  explicit ContactNeeds(const Scene& scene);
  bool of(const SceneBody& body) const;

 private:
  bool felt_;
  std::set<std::string_view> held_;  // bodies on hands and joints
};

// Errors, kContent, each with the body, collider, hand or key that it is about: no body, names that
// are empty or stand twice, a step or duration that is not positive and finite, a pose, velocity,
// gravity, force or motion that is not finite or out of range, a motion of a body that is not
// driven, velocities of one that is not free, a method that contact does not go with, sizes,
// friction or restitution out of range, a hand or a joint on a body that is not there.
Status check_scene(const Scene& scene);

}  // namespace tremolo
