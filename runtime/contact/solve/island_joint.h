// A joint in a step of its two bodies (contact_island.h): its force, and the effect of the force on
// the equations of the two.
#pragma once

#include <Eigen/Core>

#include "runtime/contact/contact_values.h"
#include "runtime/contact/joint.h"
#include "runtime/contact/solve/contact_step.h"

namespace tremolo {

// A joint of the members a and b in a step.
struct IslandJoint {
  Joint* joint = nullptr;
  std::size_t a = 0, b = 0;
  ContactTouch touch_a = {}, touch_b = {};
  JointForce now = {};
};

// Computes the joint's force at the present positions of the two bodies. h: the step, s.
void evaluate_joint(IslandJoint& link, const ContactStep& first, const ContactStep& second,
                    double h);

// Apply the force to the first and to the second body, between evaluate() and close() of that body.
void push_first(const IslandJoint& link, ContactStep& first);
void push_second(const IslandJoint& link, ContactStep& second);

// Same as add_pair_slopes(), without the rotation of the damper's force.
void add_joint_slopes(const IslandJoint& link, ContactStep& first, ContactStep& second,
                      Eigen::MatrixXd& first_by_second, Eigen::MatrixXd& second_by_first);

// Adds the work and loss of the joint to the joint and to the accounts of its bodies; for a driven
// body relative to its frame.
void settle_joint(const IslandJoint& link, const ContactStep& first, const ContactStep& second,
                  ContactAccount& a, ContactAccount& b);

}  // namespace tremolo
