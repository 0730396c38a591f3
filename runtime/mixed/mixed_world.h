// Reduced bodies (fixed, driven, free) and bodies of tetrahedra that are in contact with each other
// and with colliders, under one contact law (docs/theory.md, section "Contact").
//
// Bodies that may be in contact in a step form an island (mixed_island.h). A body that nothing is
// near takes its own step, with the same bits as without a world. Points of either kind feel the
// deformed shapes of reduced bodies and all colliders; bodies of tetrahedra are no obstacles to
// points of others.
#pragma once

#include <cstddef>
#include <deque>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/result.h"
#include "runtime/mixed/bent_contact.h"
#include "runtime/mixed/collider_contact.h"
#include "runtime/mixed/mixed_island.h"
#include "runtime/mixed/reduced_step.h"
#include "runtime/mixed/tet_step.h"

namespace tremolo {

class MixedWorld {
 public:
  // step: s, that of all bodies.
  explicit MixedWorld(double step) : step_(step) {}
  MixedWorld(MixedWorld&&) = default;
  MixedWorld& operator=(MixedWorld&&) = default;

  // Adds a body and returns its number; numbers are of both kinds together. Errors (kUsage), with
  // the name: another step; a reduced body without contact; a body of tetrahedra with a grab, or
  // contact options out of range.
  Result<std::size_t> add(std::string name, ContactBody body);
  Result<std::size_t> add(std::string name, TetBody body, const ContactOptions& contact = {});

  // The colliders of the next steps with their poses in the next one; they stay in memory.
  void set_colliders(std::span<const PlacedCollider> colliders) { colliders_ = colliders; }

  std::size_t size() const { return bodies_.size(); }
  const std::string& name(std::size_t i) const { return bodies_[i].name; }
  // The body of that number; null if it is of the other kind.
  ContactBody* reduced(std::size_t i) { return bodies_[i].reduced.get(); }
  TetBody* tets(std::size_t i) { return bodies_[i].tets.get(); }
  // Of contact in the last step.
  ContactAccount account(std::size_t i) const;
  double time() const { return static_cast<double>(steps_) * step_; }  // s

  // Takes one step of all bodies. Error (kSolver), with the names: an island was not solved. Its
  // bodies are as before the step; the others have moved.
  Status step();
  // Of the last step: iterations of all islands together, and the number of bodies in them.
  const MixedReport& report() const { return report_; }
  std::size_t in_islands() const { return in_islands_; }

 private:
  struct Member {
    std::string name;
    std::unique_ptr<ContactBody> reduced;
    std::unique_ptr<TetBody> tets;
    std::unique_ptr<ReducedStep> reduced_step;
    std::unique_ptr<TetStep> tet_step;
    bool started = false;

    StepBody* step() const {
      return tet_step ? static_cast<StepBody*>(tet_step.get()) : reduced_step.get();
    }
  };

  void find_contacts();
  BentContact& next_bent();
  ColliderContact& next_collider();
  SharedRate* rate_of(std::size_t a, std::size_t b);
  bool step_island(std::size_t root);

  double step_;
  std::int64_t steps_ = 0;
  std::vector<Member> bodies_;
  std::vector<std::pair<const TetModel*, std::shared_ptr<const TetPoints>>> points_;
  std::span<const PlacedCollider> colliders_;
  // Contacts of a step; the first ones are in use.
  std::deque<BentContact> bent_;
  std::deque<ColliderContact> on_colliders_;
  std::size_t bent_count_ = 0, collider_count_ = 0;
  std::deque<SharedRate> rates_;  // one a pair
  std::size_t rate_count_ = 0;
  std::vector<std::size_t> parent_, member_;
  std::vector<std::uint8_t> touched_;
  std::vector<StepBody*> island_;
  std::vector<std::pair<std::size_t, PairForces*>> couplings_;  // with their first body
  std::vector<PairForces*> island_couplings_;
  MixedIsland solver_;
  MixedReport report_;
  std::size_t in_islands_ = 0;
};

}  // namespace tremolo
