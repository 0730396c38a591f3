// A hand that holds a guest: a spring and a damper from one of its contact points to a moving point
// p, as hands hold reduced bodies (runtime/contact/solve/contact_step.cpp). In a step from x0 to x1
// with p from p0 to p1
//   F = -k ((x0 - p0) + (x1 - p1))/2 - d ((x1 - p1) - (x0 - p0))/h,
// the spring's discrete gradient. The work F.(x1 - x0) on the body is therefore the work
// F.(p1 - p0) of the hand, minus the growth of the spring's energy k |x - p|^2/2, minus what the
// damper takes. F does not depend on other bodies: it is a coupling without a second body.
#pragma once

#include "common/state_stream.h"
#include "runtime/mixed/guest_step.h"
#include "runtime/mixed/pair_forces.h"

namespace tremolo {

// guest: its number in MixedGuests. point: a number of StepBody. start, end: p at both ends of the
// step, m, world. force: on the body in the last step, N; of a step in parts the mean.
struct GuestHand {
  std::size_t guest = 0, point = 0;
  double stiffness = 0.0;  // N/m
  double damping = 0.0;    // N s/m
  Eigen::Vector3d start = Eigen::Vector3d::Zero(), end = start, force = start;

  void carry(StateStream& stream) { stream(guest, point, stiffness, damping, start, end, force); }
};

class HandPull final : public PairForces {
 public:
  // The body is held in a step, or a part of one between fractions of the step of h seconds.
  void set(GuestStep& body, const GuestHand& hand, double from, double to, double h);
  const Eigen::Vector3d& force() const { return force_; }  // on the body, N
  // The mean over the parts of the step that were solved, from its start on, N.
  const Eigen::Vector3d& mean_force() const { return mean_; }

  void begin() override;
  void approach() override {}
  void press(const ContactRenewal& renewal) override;
  void make_slopes(bool follows) override;
  void add_growth(StepBody::In first_x, StepBody::In second_x) override;
  void multiply(StepBody::In first_x, StepBody::In second_x, StepBody::Out first_rows,
                StepBody::Out second_rows) const override;
  bool add_missed() override { return false; }
  void settle(ContactAccount& first_account, ContactAccount& second_account, double& first_start,
              double& second_start) const override;
  void remember() override;
  std::size_t acting() const override { return 1; }

 private:
  GuestStep* body_ = nullptr;
  SharedRate own_;                // nothing is added to it
  GuestHand hand_;                // start and end are those of the part
  double h_ = 0.0;                // length of the part, s
  double from_ = 0.0, to_ = 1.0;  // its ends, fractions of the step
  SiteMotion motion_;
  Eigen::Vector3d force_ = Eigen::Vector3d::Zero(), mean_ = force_;
};

}  // namespace tremolo
