#include "runtime/contact/solve/island_joint.h"

namespace tremolo {

using Eigen::Vector3d;

// Forces and arms are along the straight means of the points, for which both momenta are conserved.
void evaluate_joint(IslandJoint& link, const ContactStep& first, const ContactStep& second,
                    double h) {
  const StepMotion &one = first.motion(), &two = second.motion();
  link.touch_a = first.straight_touch_at(link.joint->first);
  link.touch_b = second.straight_touch_at(link.joint->second);
  const Vector3d s0 = link.touch_a.x0 - link.touch_b.x0, s1 = link.touch_a.x1 - link.touch_b.x1;
  const Vector3d turn = 0.5 * (one.R0 * one.phi + two.R0 * two.phi);
  link.now = joint_force(*link.joint, s0, s1, turn, h);
}

void push_first(const IslandJoint& link, ContactStep& first) {
  const Vector3d& force = link.now.force;
  first.push(force, first.motion().straight_bend(force), link.touch_a,
             place_rows(link.joint->first));
  first.push_turn(link.now.torque);
}

void push_second(const IslandJoint& link, ContactStep& second) {
  const Vector3d& force = link.now.force;
  second.push(-force, -second.motion().straight_bend(force), link.touch_b,
              place_rows(link.joint->second));
  second.push_turn(link.now.torque);
}

void add_joint_slopes(const IslandJoint& link, ContactStep& first, ContactStep& second,
                      Eigen::MatrixXd& first_by_second, Eigen::MatrixXd& second_by_first) {
  const auto add = [&link](ContactStep& body, const VertexRows& place, const ContactTouch& touch,
                           const Vector3d& force) {
    const PlaceRows rows = place_rows(place);
    PlaceLever& lever = body.lever();
    lever.make(body.motion(), touch, rows);
    lever.add_tangent(link.now.slope, body.whole_block());
    lever.make_straight_swing(body.motion());
    body.add_geometry(force, body.motion().straight_bend(force), touch, rows);
  };
  add(first, link.joint->first, link.touch_a, link.now.force);
  add(second, link.joint->second, link.touch_b, -link.now.force);
  const PlaceLever &one = first.lever(), &two = second.lever();
  first_by_second.noalias() -= one.push() * link.now.slope * two.way();
  second_by_first.noalias() -= two.push() * link.now.slope * one.way();
}

void settle_joint(const IslandJoint& link, const ContactStep& first, const ContactStep& second,
                  ContactAccount& a, ContactAccount& b) {
  link.joint->force = link.now.force;
  link.joint->energy = link.now.energy;
  link.joint->damped += link.now.damped;
  const auto work = [&link](const ContactStep& body, const ContactTouch& touch,
                            const VertexRows& place, const Vector3d& force) {
    const StepMotion& motion = body.motion();
    const Vector3d bend = body.bend_under(place_rows(place));
    if (!body.turns()) return motion.straight_bend(force).dot(bend);
    return force.dot(touch.x1 - touch.x0) + link.now.torque.dot(motion.R0 * motion.phi);
  };
  a.joint_work += work(first, link.touch_a, link.joint->first, link.now.force);
  b.joint_work += work(second, link.touch_b, link.joint->second, -link.now.force);
}

}  // namespace tremolo
