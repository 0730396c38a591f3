// Bodies of another kind that can be members of the islands of a BodyGroup, such as bodies of
// tetrahedra (runtime/mixed/tet_guests.h). The group finds islands; the guests take the steps of
// those islands that have a guest, and their own steps.
#pragma once

#include <cstddef>
#include <functional>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "common/state_stream.h"
#include "runtime/contact/islands/contact_island.h"

namespace tremolo {

// Contact knows the bodies of a group by their numbers there, its guests by their numbers from
// kFirstGuest on, and guests know colliders from kFirstCollider on. In pages numbers have 32 bits.
inline constexpr int kGuestBit = std::numeric_limits<std::size_t>::digits > 39 ? 39 : 29;
inline constexpr std::size_t kFirstGuest = std::size_t{1} << kGuestBit;
inline constexpr std::size_t kFirstCollider = 2 * kFirstGuest;

// True if two bodies, by these numbers, may touch each other.
using PairFilter = std::function<bool(std::size_t, std::size_t)>;

// A part of a step that is taken in parts (step_parts.h): its ends, as fractions of the step, and
// the colliders' motions in it.
struct GuestPart {
  double from = 0.0, to = 1.0;
  std::span<const PlacedCollider> colliders;
};

// An island of a group's bodies for its guests: as the arguments of ContactIsland::step().
struct HostIsland {
  std::span<const IslandMember> members;
  std::vector<PairPoint>& points;
  std::size_t& count;  // of points
  std::span<IslandJoint> joints;
  std::span<StepReport> reports;
};

class IslandGuests {
 public:
  virtual ~IslandGuests() = default;

  // Number of guests.
  virtual std::size_t size() const = 0;
  // Gravity that changes in time, in the next step, m/s^2.
  virtual void set_gravity(const Eigen::Vector3d& gravity) = 0;
  // Starts a step among colliders, which stay in memory until it ends.
  virtual void start(std::span<const PlacedCollider> colliders) = 0;
  // Finds all contacts of guests with each other, with colliders and with bodies of the group, of
  // which contacts[i] belongs to body i; null entries are skipped. awake[i] is not 0 if body i
  // takes the step. Of a guest that sleeps only contacts with something awake are found.
  virtual void find_contacts(std::span<ContactStep* const> contacts,
                             std::span<const char> awake) = 0;
  // The pairs found: numbers of bodies, or number of bodies plus number of a guest; the first is a
  // guest's.
  virtual std::span<const std::pair<std::size_t, std::size_t>> links() const = 0;
  // Takes the step of an island with guests, those whose entry in `roots` is the number of its
  // first member. If the step fails, no member moves.
  virtual void step_island(std::span<const std::size_t> roots, const HostIsland& island) = 0;
  // Takes the steps of the guests without bodies: those whose root is a guest.
  virtual void step_others(std::span<const std::size_t> roots) = 0;

  // After the last step_island() failed, the same step in parts: start_parts() stores the guests;
  // step_part() takes each part, in which the island's bodies have gathered. False: it failed, and
  // no member moved. end_parts() ends the step; made: false: the guests are put back to its start.
  virtual void start_parts() = 0;
  virtual bool step_part(const GuestPart& part, const HostIsland& island) = 0;
  virtual void end_parts(bool made) = 0;

  // A guest that sleeps takes no step. start() wakes those that a hand, a load, gravity or a moving
  // collider moves; wake() prepares the guest for the step that has started.
  virtual bool asleep(std::size_t guest) const = 0;
  virtual void wake(std::size_t guest) = 0;
  virtual void wake_all() = 0;  // between two steps
  // True if the guest, in contact, has been at rest long enough to sleep (rest_time.h), and nothing
  // would wake it. Call it once after each step of an awake guest.
  virtual bool note_rest(std::size_t guest) = 0;
  // Removes the guest's motion; contact takes its energy.
  virtual void fall_asleep(std::size_t guest) = 0;
  // True if a joint connects a guest with body i of the group.
  virtual bool holds_body(std::size_t i) const = 0;

  // Saves or restores the guests' state between steps, to the bit. bodies: number of those of the
  // group.
  virtual void carry(StateStream& stream, std::size_t bodies) = 0;
};

}  // namespace tremolo
