#include "runtime/scene/scene_joints.h"

#include <string>
#include <utility>
#include <vector>

#include "common/number_text.h"
#include "runtime/contact/solve/contact_step.h"
#include "runtime/contact/solve/make_joint.h"
#include "runtime/scene/selection.h"

namespace tremolo {
namespace {

Result<VertexId> one_vertex(const char* key, const std::string& text, const ContactBody& body) {
  const Result<std::vector<VertexId>> vertices = vertices_of(text, body.model());
  const std::string what = std::string(key) + " = \"" + text + "\"";
  if (!vertices) return content_error(what + ": " + vertices.error().message);
  if (vertices->size() != 1)
    return content_error(what + " is " + std::to_string(vertices->size()) +
                         " vertices, a joint holds one: near:X,Y,Z takes the nearest");
  return vertices->front();
}

}  // namespace

Result<HeldJoint> HeldJoint::create(const SceneJoint& wanted, const ContactBody& first,
                                    const ContactBody& second) {
  const Result<VertexId> at = one_vertex("at", wanted.at, first);
  if (!at) return at.error();
  if (wanted.to_at.empty()) {
    Result<Joint> joint = make_joint(first, *at, second, wanted.options);
    if (!joint) return content_error(joint.error().message);
    return HeldJoint(std::move(*joint));
  }
  const Result<VertexId> to = one_vertex("to-at", wanted.to_at, second);
  if (!to) return to.error();
  Result<Joint> joint = make_joint(first, *at, second, *to, wanted.options);
  if (!joint) return content_error(joint.error().message);
  // A stiff joint would pull them together suddenly.
  const double apart = joint_distance(*joint, first, second);
  const double limit = first.contact()->law().margin;
  if (!wanted.options.stiffness && std::abs(apart - joint->length) > limit)
    return content_error("its places are " + number_text(apart) + " m apart at the start, not " +
                         number_text(joint->length) + " m: say `length`, a `stiffness`, put a " +
                         "body elsewhere, or leave `to-at` out to join them where they are");
  return HeldJoint(std::move(*joint));
}

void HeldJoint::begin(BodyGroup& group, std::size_t a, std::size_t b) {
  number_ = group.join(a, b, made_);
}

void HeldJoint::let_go(BodyGroup& group) {
  if (number_) group.separate(*number_);
  number_.reset();
}

void HeldJoint::before_step(const SceneJoint& wanted, double t, double step, BodyGroup& group) {
  if (number_ && t + kSameTime * step >= wanted.until) let_go(group);
}

void HeldJoint::carry(StateStream& stream, BodyGroup& group, std::size_t a, std::size_t b) {
  bool holds = number_.has_value();
  stream(holds);
  if (stream.reads() && stream.good() && holds) begin(group, a, b);
}

}  // namespace tremolo
