// Hands, which hold bodies of a scene from outside, and joints between bodies.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "common/result.h"
#include "common/state_stream.h"
#include "runtime/contact/islands/body_group.h"
#include "runtime/contact/joint.h"
#include "runtime/contact_body.h"
#include "runtime/math/motion.h"
#include "runtime/scene/scene.h"

namespace tremolo {

// The common part of the hands of a scene, for bodies of any kind: their times and their motions.
class HandCourse {
 public:
  VertexId vertex() const { return vertex_; }
  bool holds() const { return number_.has_value(); }
  // The spring and damper in use while it holds, or last used; nullopt before it has held.
  const std::optional<HandSpring>& spring() const { return spring_; }

 protected:
  // The change that is due before a step.
  enum class Act { kNothing, kGrab, kMove, kRelease };

  HandCourse(MotionPath path, VertexId vertex) : path_(std::move(path)), vertex_(vertex) {}
  // Before the k-th step.
  Act act(const SceneHand& wanted, std::int64_t k, double step);
  // The hand begins in the k-th step at the vertex's position, m, world.
  void begin_at(const SceneHand& wanted, const Eigen::Vector3d& vertex, std::int64_t k,
                double step);
  // The hand's position at the end of the k-th step, m, world.
  Eigen::Vector3d place_after(std::int64_t k, double step) const;

  MotionPath path_;
  VertexId vertex_;
  Eigen::Vector3d base_ = Eigen::Vector3d::Zero();  // of the point without its motion, m
  std::optional<std::size_t> number_;
  std::optional<HandSpring> spring_;
  bool over_ = false;
};

// The hands of a scene: each grabs a vertex, moves it, and releases it.
class MovingHand : public HandCourse {
 public:
  // Errors: those of selectors; kContent for a selector of no vertex or of several, and for a
  // vertex that does not move.
  static Result<MovingHand> create(const SceneHand& wanted, const ContactBody& body);

  // Call it before the body's k-th step, counted from 0: grabs the vertex, sets the hand's position
  // at the end of the step, or releases the vertex. Allocates nothing if the body has room for the
  // hand (Body::reserve_contact). False if the body refuses the hand.
  bool before_step(const SceneHand& wanted, std::int64_t k, double step, ContactBody& body);

  // Saves or restores the state between steps. body: the held one, restored before.
  void carry(StateStream& stream, const ContactBody& body);

  // On the body in the last step, N, world; zero while it does not hold.
  Eigen::Vector3d force(const ContactBody& body) const {
    return number_ ? body.hand_force(*number_) : Eigen::Vector3d::Zero();
  }

 private:
  MovingHand(MotionPath path, VertexId vertex, VertexRows place)
      : HandCourse(std::move(path), vertex), place_(std::move(place)) {}

  VertexRows place_;  // the body's while it is held
};

// The vertex that a joint's `at` or `to-at` names: the key, for errors, and its text. kContent: a
// selector that is not one vertex.
Result<VertexId> joint_vertex(const char* key, const std::string& text, const ContactBody& body);

// The vertices that a weld's `at` or `to-at` names. kContent: none, or not a selector.
Result<std::vector<VertexId>> weld_vertices(const char* key, const std::string& text,
                                            const ContactBody& body);

// The joints of a scene: each holds two bodies together until its time is over.
class HeldJoint {
 public:
  // kContent: a selector that is not one vertex, or points that are apart at the start although the
  // joint is stiff and has no length; else as for make_joint. Of a weld: a selector of no vertex;
  // else as for make_weld. second: of a joint to the world make_world_anchor().
  static Result<HeldJoint> create(const SceneJoint& wanted, const ContactBody& first,
                                  const ContactBody& second);

  // Joins the bodies a and b of the group; releases them when the joint's time is over at t, s.
  void begin(BodyGroup& group, std::size_t a, std::size_t b);
  void before_step(const SceneJoint& wanted, double t, double step, BodyGroup& group);

  // Null: it is over. Of a weld the sums of its joints, valid until the next call.
  const Joint* find(const BodyGroup& group) const;
  std::size_t points() const { return made_.size(); }  // number of its joints: 1 without a weld

  // carry() saves or restores whether the joint holds; when restoring, call let_go() for all joints
  // first, then carry() for each, in their order.
  void let_go(BodyGroup& group);
  void carry(StateStream& stream, BodyGroup& group, std::size_t a, std::size_t b);

 private:
  explicit HeldJoint(std::vector<Joint> joints) : made_(std::move(joints)) {}

  std::vector<Joint> made_;
  std::vector<std::size_t> numbers_;  // of each in the group; empty: it is over
  mutable Joint sums_;
};

// Hands and joints of a scene on its bodies of other kinds, and joints between those and its other
// bodies (runtime/world/guest_links.h). Numbers i are those of all hands or joints in the scene.
class GuestLinks {
 public:
  virtual ~GuestLinks() = default;

  // Call it before the k-th step of all bodies, counted from 0.
  virtual void before_step(std::int64_t k) = 0;
  // Saves or restores the state between steps; the bodies are restored before.
  virtual void carry(StateStream& stream) = 0;
  // Null: it holds another kind of body.
  virtual const HandCourse* hand(std::size_t i) const = 0;
  virtual Eigen::Vector3d hand_force(std::size_t i) const = 0;  // as MovingHand::force()
  // The position of the vertex that it holds, or will hold, m, world.
  virtual Eigen::Vector3d hand_vertex(std::size_t i) const = 0;
  // Null: its time is over, or it is between other bodies.
  virtual const Joint* joint(std::size_t i) const = 0;
  virtual std::size_t joint_points(std::size_t i) const = 0;  // as HeldJoint::points()

  // Makes joint i of the world's scene, its last one. Errors as for HeldJoint::create().
  virtual Status join(const class SceneWorld& world, std::size_t i) = 0;
  virtual void end_joint(std::size_t i) = 0;
  // Ends the joints with a body of the group.
  virtual void part_from(std::size_t body) = 0;
  // Ends the hands and joints on a guest that was removed.
  virtual void forget(std::size_t guest) = 0;
};

}  // namespace tremolo
