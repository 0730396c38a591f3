#include "runtime/scene/scene_links.h"

#include <algorithm>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "common/text.h"
#include "runtime/contact/islands/body_group.h"
#include "runtime/contact/solve/contact_step.h"
#include "runtime/scene/selection.h"
#include "runtime/scene/welds.h"
#include "runtime/scene/world_anchor.h"

namespace tremolo {

using Eigen::Vector3d;

Result<MovingHand> MovingHand::create(const SceneHand& wanted, const ContactBody& body) {
  const Result<std::vector<VertexId>> vertices = vertices_of(wanted.at, body.model());
  if (!vertices) return Error{vertices.error().kind, "at: " + vertices.error().message};
  if (vertices->size() != 1)
    return content_error("at = \"" + wanted.at + "\" is " + std::to_string(vertices->size()) +
                         " vertices, a hand holds one: near:X,Y,Z takes the nearest");
  Result<VertexRows> place = body.model().vertex(vertices->front());
  if (!place) return content_error("at: " + place.error().message);
  if (body.frame() != FrameKind::kFree && place->rows.isZero(0.0))
    return content_error("at = \"" + wanted.at + "\": the vertex does not move, it is fixed");
  Result<MotionPath> path = MotionPath::create(wanted.motion);
  if (!path) return path.error();
  return MovingHand(std::move(*path), vertices->front(), std::move(*place));
}

HandCourse::Act HandCourse::act(const SceneHand& wanted, std::int64_t k, double step) {
  const double now = static_cast<double>(k) * step + kSameTime * step;
  if (over_ || now < wanted.from) return Act::kNothing;
  if (now < wanted.until) return number_ ? Act::kMove : Act::kGrab;
  over_ = true;
  return number_ ? Act::kRelease : Act::kNothing;
}

void HandCourse::begin_at(const SceneHand& wanted, const Vector3d& vertex, std::int64_t k,
                          double step) {
  const double t = static_cast<double>(k) * step;
  const Pose begun = path_.pose_in(path_.piece(t + 0.5 * step), t);
  base_ = wanted.position.value_or(begun.rotation.conjugate() * (vertex - begun.position));
}

Vector3d HandCourse::place_after(std::int64_t k, double step) const {
  const std::size_t piece = path_.piece(static_cast<double>(k) * step + 0.5 * step);
  return path_.pose_in(piece, static_cast<double>(k + 1) * step) * base_;
}

bool MovingHand::before_step(const SceneHand& wanted, std::int64_t k, double step,
                             ContactBody& body) {
  const Act next = act(wanted, k, step);
  if (next == Act::kNothing) return true;
  if (next == Act::kRelease) {
    (void)body.release(*number_);
    number_.reset();
    return true;
  }
  if (next == Act::kGrab) {
    begin_at(wanted, body.place_now(vertex_, place_), k, step);
    const Result<std::size_t> number =
        wanted.pin ? body.pin(vertex_, std::move(place_))
                   : body.grab(vertex_, std::move(place_), wanted.stiffness, wanted.damping);
    over_ = !number;
    if (!number) return false;
    number_ = *number;
  }
  spring_ = body.hand_spring(*number_);
  return bool(body.move_hand(*number_, place_after(k, step)));
}

void MovingHand::carry(StateStream& stream, const ContactBody& body) {
  stream(number_, over_, base_);
  if (stream.reads() && number_) spring_ = body.hand_spring(*number_);
  // The body has the vertex's rows of a hand that holds.
  if (!stream.reads() || number_ || over_ || place_.rows.cols() > 0) return;
  Result<VertexRows> place = body.model().vertex(vertex_);
  stream.require(bool(place));
  if (place) place_ = std::move(*place);
}

Result<VertexId> joint_vertex(const char* key, const std::string& text, const ContactBody& body) {
  const Result<std::vector<VertexId>> vertices = vertices_of(text, body.model());
  const std::string what = std::string(key) + " = \"" + text + "\"";
  if (!vertices) return content_error(what + ": " + vertices.error().message);
  if (vertices->size() != 1)
    return content_error(what + " is " + std::to_string(vertices->size()) +
                         " vertices, a joint holds one: near:X,Y,Z takes the nearest");
  return vertices->front();
}

Result<std::vector<VertexId>> weld_vertices(const char* key, const std::string& text,
                                            const ContactBody& body) {
  Result<std::vector<VertexId>> vertices = vertices_of(text, body.model());
  const std::string what = std::string(key) + " = \"" + text + "\"";
  if (!vertices) return content_error(what + ": " + vertices.error().message);
  if (vertices->empty()) return content_error(what + " is no vertex: a weld needs some");
  return vertices;
}

namespace {

Result<std::vector<Joint>> weld_of(const SceneJoint& wanted, const ContactBody& first,
                                   const ContactBody& second) {
  const Result<std::vector<VertexId>> at = weld_vertices("at", wanted.at, first);
  if (!at) return at.error();
  std::vector<VertexId> to;
  if (!wanted.to_at.empty())
    if (Status s = take(to, weld_vertices("to-at", wanted.to_at, second)); !s) return s.error();
  // The world has no surface.
  const double gap = wanted.to.empty() ? std::numeric_limits<double>::infinity()
                                       : wanted.gap.value_or(first.contact()->surface().law.margin);
  Result<std::vector<Joint>> joints = make_weld(first, *at, second, to, wanted.options, gap);
  if (!joints) return content_error(joints.error().message);
  return joints;
}

}  // namespace

Result<HeldJoint> HeldJoint::create(const SceneJoint& wanted, const ContactBody& first,
                                    const ContactBody& second) {
  if (wanted.weld) {
    Result<std::vector<Joint>> joints = weld_of(wanted, first, second);
    if (!joints) return joints.error();
    return HeldJoint(std::move(*joints));
  }
  const Result<VertexId> at = joint_vertex("at", wanted.at, first);
  if (!at) return at.error();
  const bool nearest = wanted.to_at.empty() && !wanted.point;
  if (nearest && wanted.options.length == 0.0) {
    Result<Joint> joint = make_joint(first, *at, second, wanted.options);
    if (!joint) return content_error(joint.error().message);
    return HeldJoint({std::move(*joint)});
  }
  JointPlace there = wanted.point ? world_place(*wanted.point, second) : JointPlace{};
  if (nearest) {
    // The point that is there now has no distance, which a string or rod needs.
    JointPlace held;
    if (Status s = take(held, vertex_place(first, *at)); !s)
      return content_error(s.error().message);
    there = vertex_near(second, place_now(first, held));
  } else if (!wanted.point) {
    const Result<VertexId> to = joint_vertex("to-at", wanted.to_at, second);
    if (!to) return to.error();
    if (Status s = take(there, vertex_place(second, *to)); !s)
      return content_error(s.error().message);
  }
  Result<Joint> joint = make_joint(first, *at, second, std::move(there), wanted.options);
  if (!joint) return content_error(joint.error().message);
  // A stiff joint would pull them together suddenly.
  const double apart = joint_distance(*joint, first, second);
  double limit = first.contact()->surface().law.margin;
  if (second.contact() != nullptr) limit = std::min(limit, second.contact()->surface().law.margin);
  if (!wanted.options.stiffness && std::abs(apart - joint->length) > limit)
    return content_error(
        "its places are " + number_text(apart) + " m apart at the start, not " +
        number_text(joint->length) + " m: say `length`, a `stiffness`, put a " +
        "body elsewhere, or leave `to-at` or `point` out to join them where they are");
  return HeldJoint({std::move(*joint)});
}

void HeldJoint::begin(BodyGroup& group, std::size_t a, std::size_t b) {
  for (const Joint& joint : made_) numbers_.push_back(group.join(a, b, joint));
}

void HeldJoint::let_go(BodyGroup& group) {
  for (const std::size_t number : numbers_) group.separate(number);
  numbers_.clear();
}

const Joint* HeldJoint::find(const BodyGroup& group) const {
  if (numbers_.empty()) return nullptr;
  if (numbers_.size() == 1) return group.joint(numbers_.front());
  sums_ = {};
  for (const std::size_t number : numbers_) add_joint(sums_, *group.joint(number));
  return &sums_;
}

void HeldJoint::before_step(const SceneJoint& wanted, double t, double step, BodyGroup& group) {
  if (!numbers_.empty() && t + kSameTime * step >= wanted.until) let_go(group);
}

void HeldJoint::carry(StateStream& stream, BodyGroup& group, std::size_t a, std::size_t b) {
  bool holds = !numbers_.empty();
  stream(holds);
  if (stream.reads() && stream.good() && holds) begin(group, a, b);
}

}  // namespace tremolo
