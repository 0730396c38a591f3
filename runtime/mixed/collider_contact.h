// Points of a body of any kind on a collider, under the law of contact_law.h. Reduced bodies find
// their colliders themselves (runtime/contact/solve/contact_step.h).
#pragma once

#include <vector>

#include "runtime/mixed/pair_forces.h"

namespace tremolo {

class ColliderContact final : public PairForces {
 public:
  // Finds the points that may be in contact in the step. The collider stays in memory until it
  // ends. obstacle: its number for memories. h: the step, s. False: there are none.
  bool gather(StepBody& points, const PlacedCollider& collider, std::size_t obstacle, double h);

  void begin() override;
  void approach(const ContactRenewal& renewal) override;
  void press(const ContactRenewal& renewal) override;
  void make_slopes(bool follows) override;
  void add_growth(StepBody::In first_x, StepBody::In second_x) override;
  void multiply(StepBody::In first_x, StepBody::In second_x, StepBody::Out first_rows,
                StepBody::Out second_rows) const override;
  bool add_missed() override;
  void settle(ContactAccount& first_account, ContactAccount& second_account, double& first_start,
              double& second_start) const override;
  void remember() override;
  std::size_t acting() const override;

 private:
  struct Touch {
    std::size_t point = 0;
    ContactLaw law;
    ContactMemory memory;
    ContactStart start;
    ContactEnd end;
    ContactHeld held;
    ContactForce now;
    SiteMotion motion;
    PlacedSlope slope;
  };

  void add(std::size_t point);
  void set_levels(std::size_t from);
  void begin(Touch& touch) const;
  ContactTime time() const { return {h_, shared->rate}; }

  StepBody* points_ = nullptr;
  const PlacedCollider* collider_ = nullptr;
  std::size_t obstacle_ = 0;
  double h_ = 0.0;
  ColliderTurns turns_;
  std::vector<Touch> touches_;
  std::vector<std::uint8_t> listed_;  // points that are among them; scratch
};

}  // namespace tremolo
