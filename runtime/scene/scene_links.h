// Hands, which hold bodies of a scene from outside, and joints between bodies.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include <Eigen/Core>

#include "common/result.h"
#include "common/state_stream.h"
#include "runtime/contact/joint.h"
#include "runtime/contact/solve/body_group.h"
#include "runtime/contact_body.h"
#include "runtime/math/motion.h"
#include "runtime/scene/scene.h"

namespace tremolo {

// The hands of a scene: each grabs a vertex, moves it, and releases it.
class MovingHand {
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

  VertexId vertex() const { return vertex_; }
  bool holds() const { return number_.has_value(); }
  // The spring and damper in use while it holds, or last used; nullopt before it has held.
  const std::optional<HandSpring>& spring() const { return spring_; }
  // On the body in the last step, N, world; zero while it does not hold.
  Eigen::Vector3d force(const ContactBody& body) const {
    return number_ ? body.hand_force(*number_) : Eigen::Vector3d::Zero();
  }

 private:
  MovingHand(MotionPath path, VertexId vertex, VertexRows place)
      : path_(std::move(path)), vertex_(vertex), place_(std::move(place)) {}

  MotionPath path_;
  VertexId vertex_;
  VertexRows place_;                                // the body's while it is held
  Eigen::Vector3d base_ = Eigen::Vector3d::Zero();  // of the point without its motion, m
  std::optional<std::size_t> number_;
  std::optional<HandSpring> spring_;
  bool over_ = false;
};

// The joints of a scene: each holds two bodies together until its time is over.
class HeldJoint {
 public:
  // kContent: a selector that is not one vertex, or points that are apart at the start although the
  // joint is stiff and has no length; else as for make_joint.
  static Result<HeldJoint> create(const SceneJoint& wanted, const ContactBody& first,
                                  const ContactBody& second);

  // Joins the bodies a and b of the group; releases them when the joint's time is over at t, s.
  void begin(BodyGroup& group, std::size_t a, std::size_t b);
  void before_step(const SceneJoint& wanted, double t, double step, BodyGroup& group);

  // Null: it is over.
  const Joint* find(const BodyGroup& group) const {
    return number_ ? group.joint(*number_) : nullptr;
  }

  // carry() saves or restores whether the joint holds; when restoring, call let_go() for all joints
  // first, then carry() for each, in their order.
  void let_go(BodyGroup& group);
  void carry(StateStream& stream, BodyGroup& group, std::size_t a, std::size_t b);

 private:
  explicit HeldJoint(Joint joint) : made_(std::move(joint)) {}

  Joint made_;
  std::optional<std::size_t> number_;
};

}  // namespace tremolo
