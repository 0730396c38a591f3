// Two reduced bodies of an island of bodies of any kind: their points on each other's shapes and
// their joints, as in runtime/contact/islands/contact_island.h.
#pragma once

#include <span>
#include <vector>

#include "runtime/contact/islands/contact_island.h"
#include "runtime/contact/solve/pair_point.h"
#include "runtime/mixed/pair_forces.h"

namespace tremolo {

class ReducedPair final : public PairForces {
 public:
  // a, b: the bodies. joints: between the two; they stay in memory until the step ends.
  void set(const IslandMember& a, const IslandMember& b, double h);
  // Takes a point of one of them on the other's shape; `on_first` is true if it is a point of a.
  void take(PairPoint& pair, bool on_first);
  void take(const IslandJoint& joint, bool on_first);
  // Moves the points, with the numbers a and b of the members, to `points` from index `count` on.
  void give_back(std::size_t a, std::size_t b, std::vector<PairPoint>& points, std::size_t& count);

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
  std::span<PairPoint> used() { return std::span(points_).first(count_); }
  std::span<const PairPoint> used() const { return std::span(points_).first(count_); }
  ContactEquations& equations(std::size_t side) const { return sides_[side].contact->equations(); }
  PairBodies bodies_of(const PairPoint& pair) const {
    return {equations(pair.a), equations(pair.b)};
  }

  IslandMember sides_[2];  // points and joints know the bodies as 0 and 1
  double h_ = 0.0;
  std::vector<PairPoint> points_;  // the first count_ are in use
  std::size_t count_ = 0;
  std::vector<IslandJoint> joints_;
  PairRate rate_;
  PairBlocks blocks_;
  PairScratch scratch_;
  mutable Eigen::VectorXd rows_[2];
};

}  // namespace tremolo
