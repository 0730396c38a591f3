#include "runtime/mixed/hand_pull.h"

namespace tremolo {

using Eigen::Vector3d;

void SpringPull::set_part(double from, double to, double h) {
  shared = &own_;
  h_ = h * (to - from);
  from_ = from;
  to_ = to;
}

Vector3d SpringPull::mean_with(const Vector3d& mean, const Vector3d& now) const {
  const double share = to_ - from_;
  return from_ == 0.0 ? Vector3d(share * now) : Vector3d(mean + share * now);
}

void HandPull::set(GuestStep& body, const GuestHand& hand, double from, double to, double h) {
  set_part(from, to, h);
  body_ = &body;
  hand_ = hand;
  const Vector3d way = hand.end - hand.start;
  hand_.start = hand.start + from * way;
  hand_.end = to == 1.0 ? hand.end : Vector3d(hand.start + to * way);
}

void HandPull::begin() {
  body_->hold_at(0.5 * hand_.stiffness + hand_.damping / h_);
}

void HandPull::press(const ContactRenewal& renewal) {
  (void)renewal;
  motion_ = body_->motion(hand_.point);
  const Vector3d from = motion_.start - hand_.start, to = motion_.end - hand_.end;
  force_ = (-0.5 * hand_.stiffness) * (from + to) - (hand_.damping / h_) * (to - from);
  body_->add_force(hand_.point, force_);
}

void HandPull::make_slopes(bool follows) {
  (void)follows;
  const double slope = 0.5 * hand_.stiffness + hand_.damping / h_;
  body_->add_slope(hand_.point, slope * Eigen::Matrix3d::Identity(), force_);
}

void HandPull::settle(ContactAccount& first_account, ContactAccount& second_account,
                      double& first_start, double& second_start) const {
  (void)second_account;
  (void)first_start;
  (void)second_start;
  const Vector3d way = motion_.end - motion_.start - (hand_.end - hand_.start);
  first_account.hand_work += force_.dot(motion_.end - motion_.start);
  first_account.hand_damped += hand_.damping / h_ * way.squaredNorm();
}

void HandPull::remember() {
  mean_ = mean_with(mean_, force_);
}

void JointPull::set(const GuestJoint& wanted, Joint& joint, GuestStep& guest, GuestStep* other,
                    ReducedStep* body, double from, double to, double h) {
  set_part(from, to, h);
  joint_ = &joint;
  guest_ = &guest;
  other_ = other;
  body_ = body;
  point_ = wanted.point;
  place_ = wanted.place;
  if (place_.count == 0) {
    place_.count = 1;
    place_.points[0] = {wanted.other_point, 1.0};
  }
  along_ = wanted.along;
}

void JointPull::begin() {
  const double slope = 0.5 * joint_->stiffness + joint_->damping / h_;
  guest_->hold_at(slope);
  if (other_ != nullptr)
    other_->hold_at(slope);
  else
    body_->contact().hold_at(joint_->second, 2.0 * slope);
  boned_ = body_ != nullptr && body_->equations().follow_bones(joint_->second, on_bones_);
}

const StepMotion& JointPull::motion_of_place() const {
  return boned_ ? on_bones_ : body_->equations().motion;
}

// The rotation of a free body: the damper's torque on both acts on it alone, as a guest has none.
Vector3d JointPull::turn_of_body() const {
  if (body_ == nullptr || !body_->equations().turns()) return Vector3d::Zero();
  return body_->equations().motion.turn_in_step();
}

// The motion of the place on the other body.
void JointPull::find_other() {
  if (other_ == nullptr) {
    touch_ = body_->equations().straight_touch_at(motion_of_place(), joint_->second);
    other_motion_.start = touch_.x0;
    other_motion_.end = touch_.x1;
    return;
  }
  other_motion_.start = other_motion_.end = Vector3d::Zero();
  for (const WeldPlace::Point& one : place_.used()) {
    const SiteMotion motion = other_->motion(one.number);
    other_motion_.start += one.weight * motion.start;
    other_motion_.end += one.weight * motion.end;
  }
}

void JointPull::press(const ContactRenewal& renewal) {
  (void)renewal;
  motion_ = guest_->motion(point_);
  find_other();
  now_ = along_ ? joint_force_along(*joint_, motion_.start - other_motion_.start,
                                    motion_.end - other_motion_.end, h_)
                : joint_force(*joint_, motion_.start - other_motion_.start,
                              motion_.end - other_motion_.end, turn_of_body(), h_);
  const Vector3d& force = now_.force;
  guest_->add_force(point_, force);
  if (other_ != nullptr) {
    for (const WeldPlace::Point& one : place_.used())
      other_->add_force(one.number, -one.weight * force);
    return;
  }
  ContactEquations& eq = body_->equations();
  const StepMotion& at = motion_of_place();
  eq.push(at, -force, -at.straight_bend(force), touch_, place_rows(joint_->second));
  eq.push_turn(2.0 * now_.torque);
}

void JointPull::make_slopes(bool follows) {
  (void)follows;
  guest_->add_slope(point_, now_.slope, now_.force);
  if (other_ != nullptr) {
    for (const WeldPlace::Point& one : place_.used())
      other_->add_slope(one.number, (one.weight * one.weight) * now_.slope,
                        -one.weight * now_.force);
    return;
  }
  ContactEquations& eq = body_->equations();
  const PlaceRows rows = place_rows(joint_->second);
  const StepMotion& at = motion_of_place();
  eq.lever.make(at, touch_, rows);
  eq.lever.add_tangent(now_.slope, eq.jacobian);
  eq.lever.make_straight_swing(at);
  const Vector3d force = -now_.force;
  eq.add_geometry(force, at.straight_bend(force), touch_, rows);
  push_ = eq.lever.push();
  way_ = eq.lever.way();
}

// The force on either point rises with the end of the other one, and that on one of a place with
// those of the others.
void JointPull::multiply(StepBody::In first_x, StepBody::In second_x, StepBody::Out first_rows,
                         StepBody::Out second_rows) const {
  const Vector3d change = guest_->change_at(point_, first_x);
  if (other_ != nullptr) {
    Vector3d there = Vector3d::Zero();
    for (const WeldPlace::Point& one : place_.used())
      there += one.weight * other_->change_at(one.number, second_x);
    guest_->add_image(point_, -(now_.slope * there), first_rows);
    for (const WeldPlace::Point& one : place_.used()) {
      Vector3d fall = -now_.slope * change;
      if (place_.count > 1)
        fall += now_.slope * (there - one.weight * other_->change_at(one.number, second_x));
      other_->add_image(one.number, one.weight * fall, second_rows);
    }
    return;
  }
  guest_->add_image(point_, -(now_.slope * (way_ * second_x)), first_rows);
  body_->add_scaled(push_, -now_.slope * change, second_rows);
}

// As settle_joint(): of a driven body on its motion relative to its frame.
double JointPull::work_on_body() const {
  const ContactEquations& eq = body_->equations();
  const Vector3d force = -now_.force;
  if (eq.turns()) return force.dot(touch_.x1 - touch_.x0) + 2.0 * now_.torque.dot(turn_of_body());
  const StepMotion& at = motion_of_place();
  return at.straight_bend(force).dot(eq.bend_under(at, place_rows(joint_->second)));
}

void JointPull::settle(ContactAccount& first_account, ContactAccount& second_account,
                       double& first_start, double& second_start) const {
  (void)first_start;
  (void)second_start;
  first_account.joint_work += now_.force.dot(motion_.end - motion_.start);
  second_account.joint_work +=
      other_ != nullptr ? -now_.force.dot(other_motion_.end - other_motion_.start) : work_on_body();
}

void JointPull::remember() {
  joint_->force = mean_with(joint_->force, now_.force);
  joint_->energy = now_.energy;
  joint_->damped += now_.damped;
}

void LoadPush::set(GuestStep& body, const GuestLoad& load, double average) {
  shared = &own_;
  body_ = &body;
  load_ = &load;
  average_ = average;
}

void LoadPush::press(const ContactRenewal& renewal) {
  (void)renewal;
  for (const PointPush& push : load_->pushes) body_->add_force(push.point, average_ * push.force);
}

void LoadPush::settle(ContactAccount& first_account, ContactAccount& second_account,
                      double& first_start, double& second_start) const {
  (void)second_account;
  (void)first_start;
  (void)second_start;
  for (const PointPush& push : load_->pushes) {
    const SiteMotion motion = body_->motion(push.point);
    first_account.load_work += average_ * push.force.dot(motion.end - motion.start);
  }
}

}  // namespace tremolo
