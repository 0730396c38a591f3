// Points of a body of any kind on the deformed shape of a reduced body: the law and the geometry of
// runtime/contact/solve/pair_point.h.
#pragma once

#include <vector>

#include "runtime/contact/solve/pair_point.h"
#include "runtime/mixed/pair_forces.h"

namespace tremolo {

class BentContact final : public PairForces {
 public:
  // Finds the points of `points` that may be in contact with `shape` in the step. obstacle: the
  // number of the second body, for memories. Both bodies have started their steps. False: there are
  // none.
  bool gather(StepBody& points, ContactStep& shape, std::size_t obstacle);

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
  std::span<PairPoint> used() { return std::span(pairs_).first(count_); }
  std::span<const PairPoint> used() const { return std::span(pairs_).first(count_); }
  void add(std::size_t point, const Eigen::Vector3d& y, double distance);
  ContactTime time() const { return {shape_->equations().motion.h, shared->rate}; }
  Eigen::Vector3d place_at_start(std::size_t point) const;

  StepBody* points_ = nullptr;
  ContactStep* shape_ = nullptr;
  std::size_t obstacle_ = 0;
  std::vector<PairPoint> pairs_;  // the first count_ are in use
  std::size_t count_ = 0;
  PairScratch scratch_;
  std::vector<SiteMotion> motions_;   // of used()
  std::vector<SiteSlopes> slopes_;    // of used(), for those that act
  Eigen::VectorXd link_, growth_;     // of the second body by the pair's rate
  std::vector<std::uint8_t> listed_;  // points that are in use; scratch
  mutable Eigen::VectorXd rows_;      // scratch
};

}  // namespace tremolo
