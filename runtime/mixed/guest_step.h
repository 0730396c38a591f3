// A guest of a group (runtime/contact/islands/island_guests.h) in a step of an island of bodies of
// any kind: what bodies of tetrahedra and cloths have in common.
#pragma once

#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "common/result.h"
#include "runtime/contact/contact_record.h"
#include "runtime/math/sparse/quick_factor.h"
#include "runtime/mixed/step_body.h"

namespace tremolo {

// A residual below this fraction of the forces in a step is small.
inline constexpr double kGuestTolerance = 1e-10;

// The first row of a control point or particle.
inline Eigen::Index row_of(std::size_t point) {
  return static_cast<Eigen::Index>(3 * point);
}

// Room for a decomposition of matrices of that pattern; empty if it would take more than 1 GiB.
std::optional<QuickFactor> make_guest_factor(const BlockPatternPointer& pattern);

class GuestStep : public StepBody {
 public:
  // Prepares the body for its next step and finds its ball at the start.
  void start();
  // Takes the step without contact, with the same bits as outside a world. False: it failed; the
  // state is that before the step.
  virtual bool step_alone() = 0;

  // A step that failed, in parts (runtime/contact/islands/step_parts.h): start_parts() stores the
  // body; start_part() begins a part, whose ends are fractions of the step, and end_part() adds
  // one that was solved to the sums. end_parts(): made: the sums are those of the step, which
  // counts as one; otherwise the body is as before the first part.
  void start_parts();
  void start_part(double from, double to);
  void end_part();
  void end_parts(bool made);

  // Saves or restores the state between steps, to the bit: the body and its memories of contact.
  void carry(StateStream& stream);

  // Puts the body at rest in its equilibrium under gravity and constant forces on its points, N, 3
  // points(). Call it before the first step. Errors: those of TetBody::settle() and
  // ClothBody::settle().
  virtual Status settle(const Eigen::VectorXd& forces) = 0;

  // True if the point does not move, or moves as its pin does, whatever force acts on it.
  virtual bool is_fixed(std::size_t point) const = 0;
  // Hands and joints may move a point by this much more in the next step, m.
  void set_pull(double way) { pull_ = way; }
  // Tells that the force of a hand or joint falls by this with the end of its point, N/m: the
  // rounding error of positions, which it turns into a force, is part of enough(). Call it after
  // begin().
  void hold_at(double slope) { held_slope_ += slope; }
  // The mass that moves with a point at first, kg.
  virtual double mass_at(std::size_t point) const = 0;

  // Sleep (runtime/contact/islands/island_guests.h). A driven body does not sleep: its own pins or
  // wind move it. stop() sets the velocities to zero; rest_a_step() counts a step without motion.
  virtual bool is_driven() const = 0;
  virtual double mass() const = 0;                      // kg
  virtual double kinetic_energy() const = 0;            // J
  virtual Eigen::Vector3d gravity_to_come() const = 0;  // of the next step, m/s^2
  virtual double slow() const = 0;                      // speed of a body at rest, m/s
  virtual void stop() = 0;
  virtual void rest_a_step() = 0;

  // Of contact in the last step.
  const ContactAccount& account() const { return account_; }
  std::span<const ContactedPoint> contacted() const { return contacted_; }

  StepBall ball() const override { return ball_; }
  const ContactMemory* memory(std::size_t obstacle, std::size_t point) const override;
  double reach_of_sides(std::size_t obstacle) const override;
  void remember(const ContactMemory& memory) override { memories_.push_back(memory); }
  void note(const ContactedPoint& point) override { contacted_.push_back(point); }

 protected:
  // The present step or part of a step, as fractions of the step.
  struct Part {
    double from = 0.0, to = 1.0;
    bool whole = true;
  };

  virtual void prepare() {}          // the body itself, for its next step
  virtual StepBall find_ball() = 0;  // at the start of the present part
  virtual void keep_whole() = 0;     // stores the body
  virtual void begin_part() = 0;     // after part() has changed
  virtual void carry_body(StateStream& stream) = 0;
  virtual void end_whole(int parts) = 0;  // counts the step; 0: it failed, and the body is put back

  const Part& part() const { return part_; }
  void clear_holds() { held_slope_ = 0.0; }  // in begin()
  // Of the forces of hands and joints at positions up to `far` from the world's origin, N.
  double held_rounding(double far) const {
    return 4.0 * std::numeric_limits<double>::epsilon() * held_slope_ * far;
  }
  double length(double step) const { return step * (part_.to - part_.from); }  // of the part, s
  // Ends a step without contact.
  void forget_contact();
  // Sets the account as for finish(), and clears memories and points for those of this step.
  void take_account(const ContactAccount& account, double start, bool jumped);
  // Call it once all contacts are remembered.
  void sort_memories();

 private:
  // Contact of the body before the first part.
  struct Before {
    std::vector<ContactMemory> memories;
    std::vector<ContactedPoint> contacted;
    ContactAccount account;
  };

  StepBall ball_;
  double pull_ = 0.0;        // m
  double held_slope_ = 0.0;  // N/m
  Part part_;
  Before before_;
  ContactRecord sum_;  // of the parts
  int parts_ = 0;
  std::vector<ContactMemory> memories_;  // by obstacle and point
  std::vector<ContactedPoint> contacted_;
  ContactAccount account_;
};

}  // namespace tremolo
