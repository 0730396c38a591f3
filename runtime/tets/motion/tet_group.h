// Bodies of tetrahedra that touch each other and what stands still: who is near whom, islands of
// those, sleep.
//
// Bodies whose boxes, with the way of a step, overlap are an island and take a step together
// (tet_island.h). Bodies that touch each other, directly or through others, and all of which have
// been slower than `sleep_speed` for `sleep_time` fall asleep: their velocities become zero, what
// is taken from the energy is told, and they cost nothing but a look at their box. They wake
// together when one that moves touches one of them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "runtime/tets/motion/tet_island.h"

namespace tremolo {

// sleep_speed: root of the mean square over a body's mass, m/s; 0: nothing sleeps. sleep_time: s.
// threads: at least 1.
struct TetGroupOptions {
  double sleep_speed = 0.005;
  double sleep_time = 0.5;
  unsigned threads = 1;
};
// Errors (kContent) name the value.
Status check(const TetGroupOptions& options);

class TetGroup {
 public:
  // One contact and one friction a body; all bodies have the same step. Throws std::system_error
  // where the system gives no threads.
  TetGroup(std::vector<TetBody> bodies, std::vector<TetContact> contacts,
           std::vector<double> frictions, const TetGroupOptions& options);

  std::size_t size() const { return bodies_.size(); }
  TetBody& body(std::size_t i) { return bodies_[i]; }
  const TetBody& body(std::size_t i) const { return bodies_[i]; }
  const TetContact& contact(std::size_t i) const { return contacts_[i]; }
  bool asleep(std::size_t i) const { return asleep_[i] != 0; }
  std::size_t sleeping() const;
  // Whether a point of the body pressed on something in the last step, or something on it.
  bool touched(std::size_t i) const;
  // J, what falling asleep has taken so far.
  double energy_of_sleep() const { return energy_of_sleep_; }

  // As TetBody::set_hand of a body, which wakes with all that sleep with it and stays awake as long
  // as it is held.
  Status set_hand(std::size_t i, const std::optional<TetHand>& hand);

  // Takes all bodies one step further; one report a body. False where a body's step could not be
  // made: the bodies of its island are then as before, the others have moved.
  bool step(std::span<TetStepReport> reports);
  // Finds what touches as the bodies are now, for contact(i).look(): before the first step.
  void find_touches();
  std::size_t bytes() const;
  ThreadPool& pool() { return *pool_; }

 private:
  using Pair = std::pair<std::uint32_t, std::uint32_t>;
  void find_boxes();
  void find_pairs();
  bool touches(std::uint32_t a, std::uint32_t b);
  void wake();
  void end_nap(std::uint32_t nap);
  void join_islands();
  void take_island(std::span<const std::uint32_t> island, std::span<TetStepReport> reports);
  void fall_asleep();
  std::uint32_t root(std::uint32_t i);

  std::vector<TetBody> bodies_;
  std::vector<TetContact> contacts_;
  std::vector<double> frictions_;
  TetGroupOptions options_;
  std::unique_ptr<ThreadPool> pool_;
  TetIsland island_;
  std::vector<TetTree::Box> boxes_;      // with the way of a step
  std::vector<Pair> pairs_;              // near each other, ascending
  std::vector<std::uint32_t> by_place_;  // all bodies, by the low x of their boxes
  std::vector<std::uint32_t> roots_, order_, starts_, naps_, local_;
  std::vector<std::uint8_t> asleep_, wide_awake_;
  std::vector<double> still_, speeds_;  // s, m/s
  std::vector<TetMember> members_;
  std::vector<TetStepReport> island_reports_;
  double energy_of_sleep_ = 0.0;
};

}  // namespace tremolo
