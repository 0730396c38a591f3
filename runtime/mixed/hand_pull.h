// A hand that holds a guest: a spring and a damper from one of its contact points to a moving point
// p, as hands hold reduced bodies (runtime/contact/solve/contact_step.cpp). In a step from x0 to x1
// with p from p0 to p1
//   F = -k ((x0 - p0) + (x1 - p1))/2 - d ((x1 - p1) - (x0 - p0))/h,
// the spring's discrete gradient. The work F.(x1 - x0) on the body is therefore the work
// F.(p1 - p0) of the hand, minus the growth of the spring's energy k |x - p|^2/2, minus what the
// damper takes. F does not depend on other bodies: it is a coupling without a second body.
//
// A joint between a contact point of a guest and a point of another body: the spring and damper of
// runtime/contact/joint.h between them, with opposite forces on the straight line between the means
// of the two points in the step.
//
// A guest has no rotation of its own. The damper of a joint with a given stiffness therefore acts
// along the line alone, so that both momenta are conserved. A joint as stiff as a pin has no length
// to speak of: its damper acts in all directions. The torque of its force on the arm s~ between the
// points acts on the other body if that is free; between two guests, where it is of the order of
// h^3, it is left out.
//
// Loads in time on a guest: given forces on its contact points. In a step, or a part of one, each
// is F times the exact average of the load's course over it, and constant: the sum of the impulses
// is F times the integral of the course, whatever the steps are. The work on the body is
// F.(x1 - x0). A force that is known does not change with the ends of the points, so that a load is
// a coupling without a second body and without a slope.
#pragma once

#include <memory>
#include <vector>

#include "common/load_signal.h"
#include "common/state_stream.h"
#include "runtime/contact/joint.h"
#include "runtime/contact/solve/contact_equations.h"
#include "runtime/contact/weld.h"
#include "runtime/mixed/guest_step.h"
#include "runtime/mixed/pair_forces.h"
#include "runtime/mixed/reduced_step.h"

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

// The common part of the springs of hands and joints: they act all the time, and there is no
// distance to find.
class SpringPull : public PairForces {
 public:
  void approach(const ContactRenewal& renewal) override { (void)renewal; }
  void add_growth(StepBody::In, StepBody::In) override {}
  bool add_missed() override { return false; }
  std::size_t acting() const override { return 1; }

 protected:
  // The spring acts in a part of a step of h seconds, between fractions of the step.
  void set_part(double from, double to, double h);
  // The mean of a value over the parts of the step that were solved, from its start on, with this
  // part's.
  Eigen::Vector3d mean_with(const Eigen::Vector3d& mean, const Eigen::Vector3d& now) const;

  SharedRate own_;                // nothing is added to it
  double h_ = 0.0;                // length of the part, s
  double from_ = 0.0, to_ = 1.0;  // its ends, fractions of the step
};

class HandPull final : public SpringPull {
 public:
  // The body is held in a step, or a part of one between fractions of the step of h seconds.
  void set(GuestStep& body, const GuestHand& hand, double from, double to, double h);
  const Eigen::Vector3d& force() const { return force_; }  // on the body, N
  // The mean over the parts of the step that were solved, from its start on, N.
  const Eigen::Vector3d& mean_force() const { return mean_; }

  void begin() override;
  void press(const ContactRenewal& renewal) override;
  void make_slopes(bool follows) override;
  void multiply(StepBody::In, StepBody::In, StepBody::Out, StepBody::Out) const override {}
  void settle(ContactAccount& first_account, ContactAccount& second_account, double& first_start,
              double& second_start) const override;
  void remember() override;

 private:
  GuestStep* body_ = nullptr;
  GuestHand hand_;  // start and end are those of the part
  SiteMotion motion_;
  Eigen::Vector3d force_ = Eigen::Vector3d::Zero(), mean_ = force_;
};

// A joint of a guest.
struct GuestJoint {
  std::size_t guest = 0, point = 0;  // as in GuestHand
  // other: another guest, held at other_point, or at the place if it has points; or a body of the
  // group, held at joint.second.
  bool to_guest = false;
  std::size_t other = 0, other_point = 0;
  WeldPlace place;
  bool along = false;    // the damper acts along the joint alone
  bool further = false;  // one of a weld, after its first
  Joint joint;           // joint.first is not used; joint.force is that on the guest's point
};

class JointPull final : public SpringPull {
 public:
  // The bodies are joined in a step, or a part of one between fractions of the step of h seconds.
  // joint: receives its force and energies. Of the other body one is given.
  void set(const GuestJoint& wanted, Joint& joint, GuestStep& guest, GuestStep* other,
           ReducedStep* body, double from, double to, double h);

  void begin() override;
  void press(const ContactRenewal& renewal) override;
  void make_slopes(bool follows) override;
  void multiply(StepBody::In first_x, StepBody::In second_x, StepBody::Out first_rows,
                StepBody::Out second_rows) const override;
  void settle(ContactAccount& first_account, ContactAccount& second_account, double& first_start,
              double& second_start) const override;
  void remember() override;

 private:
  void find_other();
  Eigen::Vector3d turn_of_body() const;
  const StepMotion& motion_of_place() const;
  double work_on_body() const;

  Joint* joint_ = nullptr;
  GuestStep *guest_ = nullptr, *other_ = nullptr;
  ReducedStep* body_ = nullptr;  // instead of other_
  std::size_t point_ = 0;
  WeldPlace place_;  // of other_
  bool along_ = false;
  SiteMotion motion_, other_motion_;
  ContactTouch touch_;  // of the body
  bool boned_ = false;  // the place on the body is on several bones
  StepMotion on_bones_;
  JointForce now_;
  Eigen::MatrixXd push_;  // of the body, n x 3
  Eigen::Matrix3Xd way_;  // 3 x n
};

// A force on a contact point of a guest.
struct PointPush {
  std::size_t point = 0;                            // a number of StepBody
  Eigen::Vector3d force = Eigen::Vector3d::Zero();  // N, world

  void carry(StateStream& stream) { stream(point, force); }
};

// A load on a guest. Its times are those of the guest, which is at 0 s when it is added.
struct GuestLoad {
  std::size_t guest = 0;  // its number in MixedGuests
  std::vector<PointPush> pushes;
  Signal signal;                                  // multiplies the forces
  std::shared_ptr<const SignalTable> table = {};  // of a signal of the kind kTable
  // Above 0: the forces are constant over so many more steps, and `signal` is not used.
  int steps = 0;
};

class LoadPush final : public PairForces {
 public:
  // The load acts in a step, or a part of one, with that average of its course. load: it stays in
  // memory until the step ends.
  void set(GuestStep& body, const GuestLoad& load, double average);

  void begin() override {}
  void approach(const ContactRenewal& renewal) override { (void)renewal; }
  void press(const ContactRenewal& renewal) override;
  void make_slopes(bool) override {}
  void add_growth(StepBody::In, StepBody::In) override {}
  void multiply(StepBody::In, StepBody::In, StepBody::Out, StepBody::Out) const override {}
  bool add_missed() override { return false; }
  void settle(ContactAccount& first_account, ContactAccount& second_account, double& first_start,
              double& second_start) const override;
  void remember() override {}
  std::size_t acting() const override { return 1; }

 private:
  SharedRate own_;  // nothing is added to it
  GuestStep* body_ = nullptr;
  const GuestLoad* load_ = nullptr;
  double average_ = 0.0;
};

}  // namespace tremolo
