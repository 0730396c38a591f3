// Bodies of tetrahedra in contact with each other and with fixed obstacles: neighbours, islands,
// sleep.
//
// Bodies whose boxes, extended by the path of a step, overlap form an island and take a step
// together (tet_island.h). Bodies in contact, directly or through others, fall asleep when all of
// them have been slower than `sleep_speed` for `sleep_time`. Their velocities become zero, the
// energy taken is reported, and they cost only a check of their box. They wake together when a
// moving body touches one of them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "runtime/bodies/tets/motion/tet_island.h"
#include "runtime/energy_bound.h"

namespace tremolo {

// Options of a group.
struct TetGroupOptions {
  double sleep_speed = 0.005;  // root of the mean square over a body's mass, m/s; 0: no body sleeps
  double sleep_time = 0.5;     // s
  unsigned threads = 1;        // at least 1
};
// Errors (kContent) name the value.
Status check(const TetGroupOptions& options);

class TetGroup {
 public:
  // One contact and one friction per body; all bodies have the same step. Throws std::system_error
  // if the system provides no threads.
  TetGroup(std::vector<TetBody> bodies, std::vector<TetContact> contacts,
           std::vector<double> frictions, const TetGroupOptions& options);

  std::size_t size() const { return bodies_.size(); }
  TetBody& body(std::size_t i) { return bodies_[i]; }
  const TetBody& body(std::size_t i) const { return bodies_[i]; }
  const TetContact& contact(std::size_t i) const { return contacts_[i]; }
  bool asleep(std::size_t i) const { return asleep_[i] != 0; }
  std::size_t sleeping() const;
  // True if a point of the body had a contact force in the last step, or a point on the body had
  // one.
  bool touched(std::size_t i) const;
  // Energy taken by falling asleep so far, J.
  double energy_of_sleep() const { return energy_of_sleep_; }

  // Same as TetBody::set_state of a body. It wakes with its sleeping island; where its positions
  // change, its friction and that on it are forgotten.
  Status set_state(std::size_t i, const Eigen::VectorXd& x, const Eigen::VectorXd& v);
  // Same as TetBody::set_hand of a body. The body wakes with its sleeping island, and stays awake
  // as long as the grab lasts.
  Status set_hand(std::size_t i, const std::optional<TetHand>& hand);

  // Takes one step of all bodies; one report per body. False: a body's step failed. The bodies of
  // its island are then as before; the others have moved.
  bool step(std::span<TetStepReport> reports);
  // Finds contacts of the present positions, for contact(i).look(): before the first step.
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

  std::vector<TetBody> bodies_;
  std::vector<TetContact> contacts_;
  std::vector<double> frictions_;
  TetGroupOptions options_;
  std::unique_ptr<ThreadPool> pool_;
  TetIsland island_;
  std::vector<TetTree::Box> boxes_;      // extended by the path of a step
  std::vector<Pair> pairs_;              // near each other, ascending
  std::vector<std::uint32_t> by_place_;  // all bodies, by the low x of their boxes
  std::vector<std::uint32_t> roots_, order_, starts_, naps_, local_;
  std::vector<std::uint8_t> asleep_, wide_awake_;
  std::vector<double> still_, speeds_;  // s, m/s
  std::vector<TetMember> members_;
  std::vector<TetStepReport> island_reports_;
  double energy_of_sleep_ = 0.0;
};

// Checks that the energy of bodies of tetrahedra is compatible with the energy put in
// (runtime/energy_bound.h).
//
// The energy of deformation and motion of all bodies together, plus that of contact, is compared
// with the energy at the start and the work of gravity since. Bodies do work on each other, so that
// only the sum is bounded.
class TetBound {
 public:
  // Checks the present energy: at the start, then after every step. False: it is above kEnergyBound
  // times the energy put in, or not a number. Not for bodies with a grab.
  bool look(TetGroup& group);
  double energy() const { return energy_; }  // J, at the last check

 private:
  EnergyBound bound_;
  bool started_ = false;
  double energy_ = 0.0, gravity_ = 0.0;
};

}  // namespace tremolo
