#include "runtime/mixed/hand_pull.h"

namespace tremolo {

using Eigen::Vector3d;

void HandPull::set(GuestStep& body, const GuestHand& hand, double from, double to, double h) {
  body_ = &body;
  shared = &own_;
  hand_ = hand;
  const Vector3d way = hand.end - hand.start;
  hand_.start = hand.start + from * way;
  hand_.end = to == 1.0 ? hand.end : Vector3d(hand.start + to * way);
  h_ = h * (to - from);
  from_ = from;
  to_ = to;
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

void HandPull::add_growth(StepBody::In first_x, StepBody::In second_x) {
  (void)first_x;
  (void)second_x;
}

void HandPull::multiply(StepBody::In first_x, StepBody::In second_x, StepBody::Out first_rows,
                        StepBody::Out second_rows) const {
  (void)first_x;
  (void)second_x;
  (void)first_rows;
  (void)second_rows;
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
  const double share = to_ - from_;
  mean_ = from_ == 0.0 ? Vector3d(share * force_) : Vector3d(mean_ + share * force_);
}

}  // namespace tremolo
