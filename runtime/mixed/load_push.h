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
#include "runtime/mixed/guest_step.h"
#include "runtime/mixed/pair_forces.h"

namespace tremolo {

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
  void approach() override {}
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
