// Bodies of another kind that can be members of the islands of a BodyGroup, such as bodies of
// tetrahedra (runtime/mixed/tet_guests.h). The group finds islands; the guests take the steps of
// those islands that have a guest, and their own steps.
#pragma once

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "runtime/contact/solve/contact_island.h"

namespace tremolo {

class IslandGuests {
 public:
  virtual ~IslandGuests() = default;

  // Number of guests.
  virtual std::size_t size() const = 0;
  // Starts a step among colliders, which stay in memory until it ends.
  virtual void start(std::span<const PlacedCollider> colliders) = 0;
  // Finds all contacts of guests with each other, with colliders and with bodies of the group, of
  // which contacts[i] belongs to body i; null entries are skipped.
  virtual void find_contacts(std::span<ContactStep* const> contacts) = 0;
  // The pairs found: numbers of bodies, or number of bodies plus number of a guest; the first is a
  // guest's.
  virtual std::span<const std::pair<std::size_t, std::size_t>> links() const = 0;
  // Takes the step of an island with guests, those whose entry in `roots` is the number of its
  // first member. The other arguments are those of ContactIsland::step(). If the step fails, no
  // member moves.
  virtual void step_island(std::span<const std::size_t> roots,
                           std::span<const IslandMember> members, std::vector<PairPoint>& points,
                           std::size_t& count, std::span<IslandJoint> joints,
                           std::span<StepReport> reports) = 0;
  // Takes the steps of the guests without bodies: those whose root is a guest.
  virtual void step_others(std::span<const std::size_t> roots) = 0;
};

}  // namespace tremolo
