#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "runtime/contact/contact_values.h"
#include "runtime/contact/islands/body_group.h"
#include "runtime/contact/islands/contact_island.h"
#include "runtime/math/dense/decompositions.h"

namespace tremolo {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Of a joint's load the mass for which its spring is made. A weight at rest extends it by g h^2/9.
constexpr double kLoadShare = 0.01;

Status set_springs(Joint& joint, const ContactBody& first, const ContactBody& second,
                   const JointOptions& options) {
  joint.length = options.length;
  joint.touch = options.touch;
  for (const double value : {options.stiffness.value_or(0.0), options.damping, joint.length})
    if (!std::isfinite(value) || value < 0.0)
      return usage_error("a joint's stiffness, damping and length are finite and not negative");
  const double h = first.options().step;
  const double lightness = 1.0 / first.mass_at(joint.first) + 1.0 / second.mass_at(joint.second);
  if (!options.stiffness && !(lightness > 0.0))
    return usage_error("neither place moves: there is nothing to join");
  HandSpring most = stiffest_spring(std::max(1.0 / lightness, kLoadShare * options.load), h);
  // The damper of the points' masses would let the load bounce.
  if (kLoadShare * options.load > 1.0 / lightness) most.damping = 0.5 * h * most.stiffness;
  joint.stiffness = options.stiffness.value_or(most.stiffness);
  joint.damping = options.stiffness ? options.damping : most.damping;
  limit_spring(most, h, joint.stiffness, joint.damping);
  return Success{};
}

Status check_bodies(const ContactBody& first, const ContactBody& second) {
  if (&first == &second) return usage_error("a joint needs two bodies");
  for (const ContactBody* body : {&first, &second})
    if (Status s = check_joinable(*body); !s) return s;
  if (first.options().step != second.options().step)
    return usage_error("bodies that are joined have one step size");
  return Success{};
}

}  // namespace

Status check_joinable(const ContactBody& body) {
  if (body.contact() == nullptr)
    return usage_error("joints need set_contact() of both bodies first");
  return Success{};
}

Result<JointPlace> vertex_place(const ContactBody& body, VertexId vertex) {
  JointPlace place;
  if (Status s = take<VertexRows>(place, body.model().vertex(vertex)); !s) return s.error();
  if (body.bones() < 2) return place;
  const Result<std::span<const double>> weights = body.weights_of(vertex);
  if (!weights) return weights.error();
  place.bones.assign(weights->begin(), weights->end());
  return place;
}

Vector3d place_now(const ContactBody& body, const JointPlace& place) {
  const Vector3d y = place.rest + place.rows * body.state().q;
  if (place.bones.empty()) return body.pose() * y;
  const BoneMap map = blended(place.bones, body.bone_maps());
  return map.leftCols<3>() * y + map.col(3);
}

void bring_to(const ContactBody& body, const Vector3d& where, JointPlace& place) {
  const Vector3d way = where - place_now(body, place);
  if (place.bones.empty()) {
    place.rest += body.pose().rotation.conjugate() * way;
    return;
  }
  const Eigen::Matrix3d turn = blended(place.bones, body.bone_maps()).leftCols<3>();
  place.rest += solve_shortest(turn, way);
}

JointPlace vertex_near(const ContactBody& body, const Vector3d& where) {
  double nearest = std::numeric_limits<double>::infinity();
  JointPlace found;
  for (const VertexId vertex : body.model().surface().vertex_ids) {
    Result<JointPlace> place = vertex_place(body, vertex);
    if (!place) continue;
    const double far = (place_now(body, *place) - where).squaredNorm();
    if (far >= nearest) continue;
    nearest = far;
    found = std::move(*place);
  }
  return found;
}

double joint_distance(const Joint& joint, const ContactBody& first, const ContactBody& second) {
  return (place_now(first, joint.first) - place_now(second, joint.second)).norm();
}

JointPlace place_at(const ContactBody& body, const Vector3d& where) {
  if (body.bones() > 1) {
    JointPlace found = vertex_near(body, where);
    bring_to(body, where, found);
    return found;
  }
  const Pose pose = body.pose();
  const Vector3d place = pose.rotation.conjugate() * (where - pose.position);
  const Eigen::VectorXd& q = body.state().q;
  double nearest = std::numeric_limits<double>::infinity();
  const VertexBlock& boundary = body.model().surface();
  JointPlace found;
  for (std::size_t i = 0; i < boundary.rest.size(); ++i) {
    const auto rows = boundary.rows.middleRows(3 * i, 3);
    const Vector3d there = boundary.rest[i] + rows * q;
    if ((there - place).squaredNorm() >= nearest) continue;
    nearest = (there - place).squaredNorm();
    found = {{boundary.rest[i] + (place - there), rows}, {}};
  }
  return found;
}

Result<Joint> make_joint(const ContactBody& first, VertexId at, const ContactBody& second,
                         VertexId to, const JointOptions& options) {
  if (Status s = check_bodies(first, second); !s) return s.error();
  Result<JointPlace> place = vertex_place(second, to);
  if (!place) return place.error();
  return make_joint(first, at, second, std::move(*place), options);
}

Result<Joint> make_joint(const ContactBody& first, VertexId at, const ContactBody& second,
                         JointPlace to, const JointOptions& options) {
  if (Status s = check_bodies(first, second); !s) return s.error();
  Joint joint;
  joint.second = std::move(to);
  if (Status s = take(joint.first, vertex_place(first, at)); !s) return s.error();
  if (Status s = set_springs(joint, first, second, options); !s) return s.error();
  return joint;
}

Result<Joint> make_joint(const ContactBody& first, VertexId at, const ContactBody& second,
                         const JointOptions& options) {
  if (Status s = check_bodies(first, second); !s) return s.error();
  Joint joint;
  if (Status s = take(joint.first, vertex_place(first, at)); !s) return s.error();
  joint.second = place_at(second, place_now(first, joint.first));
  if (Status s = set_springs(joint, first, second, options); !s) return s.error();
  return joint;
}

void begin_joint(IslandJoint& link, const ContactEquations& first, const ContactEquations& second) {
  link.boned_a = first.follow_bones(link.joint->first, link.on_bones_a);
  link.boned_b = second.follow_bones(link.joint->second, link.on_bones_b);
}

namespace {

const StepMotion& motion_a(const IslandJoint& link, const ContactEquations& first) {
  return link.boned_a ? link.on_bones_a : first.motion;
}

const StepMotion& motion_b(const IslandJoint& link, const ContactEquations& second) {
  return link.boned_b ? link.on_bones_b : second.motion;
}

}  // namespace

// Forces and arms are along the straight means of the points, for which both momenta are conserved.
void evaluate_joint(IslandJoint& link, const ContactEquations& first,
                    const ContactEquations& second, double h) {
  const StepMotion &one = motion_a(link, first), &two = motion_b(link, second);
  link.touch_a = first.straight_touch_at(one, link.joint->first);
  link.touch_b = second.straight_touch_at(two, link.joint->second);
  const Vector3d s0 = link.touch_a.x0 - link.touch_b.x0, s1 = link.touch_a.x1 - link.touch_b.x1;
  const Vector3d turn = 0.5 * (one.turn_in_step() + two.turn_in_step());
  link.now = joint_force(*link.joint, s0, s1, turn, h);
}

void push_first(const IslandJoint& link, ContactEquations& first) {
  const Vector3d& force = link.now.force;
  const StepMotion& at = motion_a(link, first);
  first.push(at, force, at.straight_bend(force), link.touch_a, place_rows(link.joint->first));
  first.push_turn(link.now.torque);
}

void push_second(const IslandJoint& link, ContactEquations& second) {
  const Vector3d& force = link.now.force;
  const StepMotion& at = motion_b(link, second);
  second.push(at, -force, -at.straight_bend(force), link.touch_b, place_rows(link.joint->second));
  second.push_turn(link.now.torque);
}

void add_joint_slopes(const IslandJoint& link, ContactEquations& first, ContactEquations& second,
                      Eigen::MatrixXd& first_by_second, Eigen::MatrixXd& second_by_first) {
  const auto add = [&link](ContactEquations& body, const StepMotion& at, const VertexRows& place,
                           const ContactTouch& touch, const Vector3d& force) {
    const PlaceRows rows = place_rows(place);
    PlaceLever& lever = body.lever;
    lever.make(at, touch, rows);
    lever.add_tangent(link.now.slope, body.jacobian);
    lever.make_straight_swing(at);
    body.add_geometry(force, at.straight_bend(force), touch, rows);
  };
  add(first, motion_a(link, first), link.joint->first, link.touch_a, link.now.force);
  add(second, motion_b(link, second), link.joint->second, link.touch_b, -link.now.force);
  const PlaceLever &one = first.lever, &two = second.lever;
  first_by_second.noalias() -= one.push() * link.now.slope * two.way();
  second_by_first.noalias() -= two.push() * link.now.slope * one.way();
}

void settle_joint(const IslandJoint& link, const ContactEquations& first,
                  const ContactEquations& second, ContactAccount& a, ContactAccount& b) {
  link.joint->force = link.now.force;
  link.joint->energy = link.now.energy;
  link.joint->damped += link.now.damped;
  const auto work = [&link](const ContactEquations& body, const StepMotion& motion,
                            const ContactTouch& touch, const VertexRows& place,
                            const Vector3d& force) {
    const Vector3d bend = body.bend_under(motion, place_rows(place));
    if (!body.turns()) return motion.straight_bend(force).dot(bend);
    return force.dot(touch.x1 - touch.x0) + link.now.torque.dot(motion.R0 * motion.phi);
  };
  a.joint_work +=
      work(first, motion_a(link, first), link.touch_a, link.joint->first, link.now.force);
  b.joint_work +=
      work(second, motion_b(link, second), link.touch_b, link.joint->second, -link.now.force);
}

}  // namespace tremolo
