// The joints of a scene: each holds two bodies together until its time is over.
#pragma once

#include <cstddef>
#include <optional>

#include "common/result.h"
#include "common/state_stream.h"
#include "runtime/contact/joint.h"
#include "runtime/contact/solve/body_group.h"
#include "runtime/contact_body.h"
#include "runtime/scene/scene.h"

namespace tremolo {

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
