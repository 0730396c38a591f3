// A guest of a group (runtime/contact/solve/island_guests.h) in a step of an island of bodies of
// any kind: what bodies of tetrahedra and cloths have in common.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "runtime/math/sparse/block_cholesky.h"
#include "runtime/mixed/step_body.h"

namespace tremolo {

// A residual below this fraction of the forces in a step is small.
inline constexpr double kGuestTolerance = 1e-10;

// The first row of a control point or particle.
inline Eigen::Index row_of(std::size_t point) {
  return static_cast<Eigen::Index>(3 * point);
}

// Room for a decomposition of matrices of that pattern; empty if it would take more than 1 GiB.
std::optional<BlockCholesky> make_guest_factor(const BlockPatternPointer& pattern);

class GuestStep : public StepBody {
 public:
  // Finds the body's ball at the start of the step.
  virtual void start() = 0;
  // Takes the step without contact, with the same bits as outside a world. False: it failed; the
  // state is that before the step.
  virtual bool step_alone() = 0;

  // Of contact in the last step.
  const ContactAccount& account() const { return account_; }
  std::span<const ContactedPoint> contacted() const { return contacted_; }

  StepBall ball() const override { return ball_; }
  const ContactMemory* memory(std::size_t obstacle, std::size_t point) const override;
  void remember(const ContactMemory& memory) override { memories_.push_back(memory); }
  void note(const ContactedPoint& point) override { contacted_.push_back(point); }

 protected:
  // Ends a step without contact.
  void forget_contact();
  // Sets the account as for finish(), and clears memories and points for those of this step.
  void take_account(const ContactAccount& account, double start);
  // Call it once all contacts are remembered.
  void sort_memories();

  StepBall ball_;

 private:
  std::vector<ContactMemory> memories_;  // by obstacle and point
  std::vector<ContactedPoint> contacted_;
  ContactAccount account_;
};

}  // namespace tremolo
