// A scene as plain values: everything that moves, and what moves it. Units are SI; vectors are
// along the world's axes. SceneWorld (runtime/world/scene_world.h) steps it.
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
#include "runtime/bodies/reduced/bones/bone_weights.h"
#include "runtime/bodies/reduced/rigid/rigid_solid.h"
#include "runtime/contact/collider.h"
#include "runtime/contact/joint.h"
#include "runtime/contact_body.h"
#include "runtime/math/motion.h"

namespace tremolo {

// A force on vertices, times a course in time.
struct SceneLoad {
  Signal signal;
  std::shared_ptr<const SignalTable> table;  // of a signal of the kind kTable
  // A vertex's id or a selector on the boundary. Empty: the model's default load, without `force`.
  std::string at;
  Eigen::Vector3d force = Eigen::Vector3d::Zero();  // N, distributed over the vertices
  double scale = 1.0;                               // multiplies the force or the default load
};

// Columns of the CSV that a run writes of one body.
struct SceneColumns {
  std::vector<std::string> probes;       // vertices or selectors whose displacement is recorded
  std::vector<std::string> coordinates;  // "3", "0-5", "all"
  bool velocities = false;               // of probes and coordinates, too
};

// A bone of a body.
struct SceneBone {
  std::string name;    // unique among the body's bones
  std::string parent;  // an earlier bone, which moves this one; empty: the body's frame
  // Ends at rest, m, in the mesh's coordinates. The distance to them gives the weights of vertices
  // unless the body has bone_weights.
  Eigen::Vector3d head = Eigen::Vector3d::Zero();
  Eigen::Vector3d tail = Eigen::Vector3d::Zero();
  // Relative to the parent, about the head: positions and axes are along the mesh's axes, from the
  // head.
  Motion motion;
};

// A value that applies from a time on, s.
struct ValueFrom {
  double time = 0.0;
  double value = 0.0;
};

// A body of a scene.
struct SceneBody {
  std::string name;     // unique among the bodies
  std::string model;    // path of the basis file
  std::string made_by;  // the command that makes the file, for the error if it is missing
  ModelOptions model_options;
  // A rigid body: its kind is kFree, it has no file, and its shape is the one with which other
  // bodies collide (of a mesh: contact.shape or shape_file).
  std::optional<RigidSolid> rigid;
  FrameKind kind = FrameKind::kFixed;
  std::string integrator{kDefaultIntegrator};
  IntegratorOptions options;  // options.step is ignored: a scene has one step
  // Rayleigh damping, 1/s and s, ascending in time: from the first step that begins at or after a
  // value's time on, the value replaces options.alpha or options.beta.
  std::vector<ValueFrom> alphas, betas;
  // At t = 0; `motion` moves the frame from there. A fixed body with a pose is driven, at rest.
  Pose pose;
  // Of a free body at t = 0: of the centre of mass, m/s, and about it, rad/s.
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  Eigen::Vector3d spin = Eigen::Vector3d::Zero();
  // The body starts in its equilibrium under gravity and its loads at t = 0. Not for a free body.
  bool settled = false;
  std::vector<SceneLoad> loads;
  Motion motion;
  std::vector<SceneBone> bones;  // of a driven body with several frames
  BoneWeights bone_weights;      // a row per drawn vertex, a column per bone; empty: by distance
  double bone_blend = 0.0;       // m, for weights by distance (runtime/bones.h); 0: the default
  bool rig = false;  // bones, weights and motions are those of the model's render surface
  std::string clip;  // name of the rig's motion; empty: the first one
  double acceleration_limit = 1e4;  // m/s^2, of any point of the body by its frame
  // The body is in contact with the scene's colliders, by `contact`; a driven, free or rotated body
  // then needs avf, ep2 or ep4. Hands can hold the body either way.
  bool feels_contact = true;
  ContactOptions contact;     // without contact.shape other bodies pass through this one
  std::string shape_file;     // of a mesh's distances, instead of contact.shape
  std::string shape_made_by;  // the command that makes it, for the error if it is missing
  SceneColumns columns;
};

// True if other bodies' points collide with the body's shape.
inline bool has_shape(const SceneBody& body) {
  return body.contact.shape || !body.shape_file.empty() || (body.rigid && body.rigid->shape);
}

// The kind of the body in a world: a fixed one with a pose is driven.
FrameKind frame_kind(const SceneBody& body);

// Gravity, m/s^2: values at ascending times, s, interpolated linearly; constant before the first
// and after the last. Empty: none.
struct SceneGravity {
  std::vector<double> times;
  std::vector<Eigen::Vector3d> values;

  Eigen::Vector3d at(double t) const;
};

// A rigid obstacle for bodies.
struct SceneCollider {
  std::string name;     // unique among the colliders
  Collider shape;       // ignored if there is a file
  std::string file;     // of a mesh's distances (tremolo-precompute collider)
  std::string made_by;  // the command that makes the file, for the error if it is missing
  Pose pose;            // of the shape's frame at t = 0; `motion` moves it from there
  Motion motion;
  double friction = 0.3;     // coefficient mu, for all pairs with this collider
  double restitution = 0.5;  // ratio of the normal speeds after and before, 0 to 1, for all pairs
};

// A spring and a damper between a vertex of a body and a point that moves. At the end of each step
// the point is where its motion puts it; in the first step it starts at the vertex.
struct SceneHand {
  std::string body;        // its name
  std::string at;          // a vertex's id, or a selector of one vertex
  bool pin = false;        // Body::pin: stiffness and damping are not read
  double stiffness = 0.0;  // N/m, above 0
  double damping = 0.0;    // N s/m
  // Of the point without any motion, m. Empty: the vertex's position when it is grabbed.
  std::optional<Eigen::Vector3d> position;
  Motion motion;
  double from = 0.0;        // s; it holds from the step that begins then
  double until = kForEver;  // s
  int line = 0;             // of a scene file, for errors; 0: none
};

// A joint between vertices of two bodies (runtime/contact/joint.h), or a weld of selections of them
// (runtime/scene/welds.h).
struct SceneJoint {
  bool weld = false;
  std::string body, at;  // name; a vertex's id, or a selector of one vertex, of a weld of several
  std::string to;        // name of the other body; empty: the world, which does not move
  std::string to_at;     // its vertex; empty: the point of it at the first vertex at t = 0
  JointOptions options;  // of a weld: stiffness and damping of all its joints together; no length
  // m, of a joint to the world: its end there. Empty: where the vertex is at t = 0.
  std::optional<Eigen::Vector3d> point;
  // m, of a weld: the longest offset between the two. Empty: the contact margin of the first body.
  std::optional<double> gap;
  double until = kForEver;  // s; it holds until then
  int line = 0;             // of a scene file, for errors; 0: none
};

// The name of the world as the other body of a joint.
inline constexpr const char* kWorldName = "world";

// An error with what a scene lists: "line 12: hand 1: ...". i: from 0.
template <class Listed>
Error error_of_listed(const char* what, std::size_t i, const Listed& one, const Error& error) {
  const std::string line = one.line > 0 ? "line " + std::to_string(one.line) + ": " : "";
  return {error.kind, line + what + " " + std::to_string(i + 1) + ": " + error.message};
}

struct Scene {
  double step = 3e-3;      // s, of all bodies
  double duration = 30.0;  // s
  bool sleep = true;       // bodies that come to rest take no steps until something wakes them
  SceneGravity gravity;
  std::vector<SceneBody> bodies;
  std::vector<SceneCollider> colliders;
  std::vector<SceneHand> hands;
  std::vector<SceneJoint> joints;
  // Names of the world's bodies of other kinds, which are not in the list: that may be empty.
  std::set<std::string> guests;
};

// The check of a joint of check_scene(). bodies: the names of those that there are.
Status check_joint(const SceneJoint& joint, const std::set<std::string>& bodies);

// True if bodies of the scene may be in contact with each other.
bool bodies_touch(const Scene& scene);

// True if the body needs Body::set_contact(): it can be in contact with colliders or bodies, or a
// hand or a joint holds it.
bool needs_contact(const Scene& scene, const SceneBody& body);

// The same query for many bodies of a scene, which must outlive this object.
class ContactNeeds {
 public:
  explicit ContactNeeds(const Scene& scene);
  bool of(const SceneBody& body) const;

 private:
  bool felt_;
  std::set<std::string_view> held_;  // bodies on hands and joints
};

// Errors (kContent), each with its body, collider, hand or key: no body; names that are empty or
// not unique; a step or duration that is not positive and finite; a pose, velocity, gravity, force
// or motion that is not finite or out of range; a motion of a body that is not driven; velocities
// of one that is not free; a method that does not support contact; sizes, friction or restitution
// out of range; a hand or a joint on a body that does not exist.
Status check_scene(const Scene& scene);

}  // namespace tremolo
