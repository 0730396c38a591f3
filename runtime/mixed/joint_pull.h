// A joint between a contact point of a guest and a point of another body: the spring and damper of
// runtime/contact/joint.h between them, with opposite forces on the straight line between the means
// of the two points in the step.
//
// A guest has no rotation of its own. The damper of a joint with a given stiffness therefore acts
// along the line alone, so that both momenta are conserved. A joint as stiff as a pin has no length
// to speak of: its damper acts in all directions, and the torque of its force on the arm s~ between
// the points, which is of the order of h^3, is left out.
#pragma once

#include "common/state_stream.h"
#include "runtime/contact/joint.h"
#include "runtime/contact/solve/contact_equations.h"
#include "runtime/mixed/guest_step.h"
#include "runtime/mixed/pair_forces.h"
#include "runtime/mixed/reduced_step.h"

namespace tremolo {

// guest, point: as in GuestHand. other: another guest, held at other_point; or a body of the group,
// held at joint.second. joint.first is not used; joint.force is that on the guest's point. along:
// the damper acts along the joint alone.
struct GuestJoint {
  std::size_t guest = 0, point = 0;
  bool to_guest = false, along = false;
  std::size_t other = 0, other_point = 0;
  Joint joint;
};

class JointPull final : public PairForces {
 public:
  // The bodies are joined in a step, or a part of one between fractions of the step of h seconds.
  // joint: receives its force and energies. Of the other body one is given.
  void set(const GuestJoint& wanted, Joint& joint, GuestStep& guest, GuestStep* other,
           ReducedStep* body, double from, double to, double h);

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
  double work_on_body() const;

  Joint* joint_ = nullptr;
  GuestStep *guest_ = nullptr, *other_ = nullptr;
  ReducedStep* body_ = nullptr;  // instead of other_
  std::size_t point_ = 0, other_point_ = 0;
  bool along_ = false;
  SharedRate own_;                // nothing is added to it
  double h_ = 0.0;                // length of the part, s
  double from_ = 0.0, to_ = 1.0;  // its ends, fractions of the step
  SiteMotion motion_, other_motion_;
  ContactTouch touch_;  // of the body
  JointForce now_;
  Eigen::MatrixXd push_;  // of the body, n x 3
  Eigen::Matrix3Xd way_;  // 3 x n
};

}  // namespace tremolo
