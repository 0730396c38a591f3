// A joint in a step of the two bodies that it holds (contact_island.h): its force, and what that
// does to the equations of the two.
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

// Finds the joint's force where the two bodies are now. h: the step, s.
void evaluate_joint(IslandJoint& link, const ContactStep& first, const ContactStep& second,
                    double h);

// What it does to its first and to its second body, between evaluate() and close() of that one.
void push_first(const IslandJoint& link, ContactStep& first);
void push_second(const IslandJoint& link, ContactStep& second);

// As add_pair_slopes(), without what turns the damper's force.
void add_joint_slopes(const IslandJoint& link, ContactStep& first, ContactStep& second,
                      Eigen::MatrixXd& first_by_second, Eigen::MatrixXd& second_by_first);

// Books what the joint did in itself and in the accounts of its bodies, of a driven one relative to
// its frame.
void settle_joint(const IslandJoint& link, const ContactStep& first, const ContactStep& second,
                  ContactAccount& a, ContactAccount& b);

}  // namespace tremolo
