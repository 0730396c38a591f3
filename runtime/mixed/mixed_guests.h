// Bodies of tetrahedra and cloths in the islands of a BodyGroup, under one contact law with its
// bodies and colliders (docs/theory.md, section "Contact").
//
// Bodies that may be in contact in a step form an island. An island with guests is solved by
// MixedIsland. A guest that nothing is near takes its own step, with the same bits as without a
// group. Cloths pass through each other and themselves.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/result.h"
#include "runtime/contact/islands/island_guests.h"
#include "runtime/contact/islands/step_parts.h"
#include "runtime/contact/rest_time.h"
#include "runtime/contact/springs.h"
#include "runtime/contact_body.h"
#include "runtime/mixed/bent_contact.h"
#include "runtime/mixed/cloth_step.h"
#include "runtime/mixed/collider_contact.h"
#include "runtime/mixed/guest_step.h"
#include "runtime/mixed/hand_pull.h"
#include "runtime/mixed/hull_contact.h"
#include "runtime/mixed/mixed_island.h"
#include "runtime/mixed/reduced_pair.h"
#include "runtime/mixed/reduced_step.h"
#include "runtime/mixed/tet_step.h"

namespace tremolo {

class MixedGuests final : public IslandGuests {
 public:
  // step: s, that of all bodies.
  explicit MixedGuests(double step) : step_(step) {}

  // Add a body and return its number. Errors (kUsage), with the name: another step; a grab; contact
  // options out of range; a cloth without thickness, or with a method that has no equation for
  // contact (cloth_step.h).
  // hull: with which points of other bodies collide; null, or without distances: they pass through.
  Result<std::size_t> add(std::string name, TetBody body, const ContactOptions& contact = {},
                          TetHullPointer hull = nullptr);
  // contact: stiffness or modulus alone; the cloth itself has the rest.
  Result<std::size_t> add(ClothBody body, const ContactOptions& contact = {});

  // Puts a guest at rest in its equilibrium under gravity and its loads at t = 0, before its first
  // step. Errors, with the name: those of GuestStep::settle().
  Status settle(std::size_t i);

  // Removes a guest with its hands and joints. Its number is that of a body that is added after
  // the next step; until then no function but removed() may be called with it.
  void remove(std::size_t i);
  bool removed(std::size_t i) const { return guests_[i]->removed; }
  // Removes a guest that add() has just added. count: size() before. The numbers of the guests that
  // follow are those that they would have without it.
  void take_back(std::size_t i, std::size_t count);
  void replay_step();  // as SceneWorld::replay_step()
  // As BodyGroup::set_filter().
  void set_filter(PairFilter filter) { filter_ = std::move(filter); }

  const std::string& name(std::size_t i) const { return guests_[i]->name; }
  // Null: the guest is of the other kind.
  TetStep* tets(std::size_t i) { return guests_[i]->tets; }
  const TetStep* tets(std::size_t i) const { return guests_[i]->tets; }
  ClothStep* cloth(std::size_t i) { return guests_[i]->cloth; }
  const ClothStep* cloth(std::size_t i) const { return guests_[i]->cloth; }
  // Of the last step.
  const ContactAccount& account(std::size_t i) const { return guests_[i]->step->account(); }
  // The points with a force in the last step.
  std::span<const ContactedPoint> contacted(std::size_t i) const {
    return guests_[i]->step->contacted();
  }
  // Sums since the start.
  const ContactSums& sums(std::size_t i) const { return guests_[i]->sums; }
  std::int64_t contacts(std::size_t i) const { return guests_[i]->contacts; }  // that began
  double penetration_max(std::size_t i) const { return guests_[i]->deepest; }  // m
  double slip_max(std::size_t i) const { return guests_[i]->slip; }  // ContactAccount::slip, m
  // Holds a contact point of a guest with a hand that is at the point, and stays there until it is
  // moved. Returns the hand's number, the lowest that is free. Errors (kUsage): a point that does
  // not exist or is fixed; a stiffness or damping that is negative or not finite.
  Result<std::size_t> hold(std::size_t i, std::size_t point, const HandSpring& spring);
  // place: of the hand at the end of the next step, m; it gets there at constant velocity. Errors
  // (kUsage): there is no such hand; a place that is not finite.
  Status move_hand(std::size_t hand, const Eigen::Vector3d& place);
  void let_go(std::size_t hand);  // releases the point
  // Null: there is no such hand. Its work is part of sums(): ContactSums::hand.
  const GuestHand* hand(std::size_t hand) const;
  Eigen::Vector3d hands_force(std::size_t i) const;  // of all hands in the last step, N

  // Adds a load in time. Its work is part of load_work(). Errors: kUsage: a point that does not
  // exist; a force that is not finite, or so large that numbers overflow; kContent: all its points
  // are fixed.
  Status add_load(GuestLoad load);
  // Adds a force on a contact point, constant over the next `steps` steps, N. Errors as for
  // add_load(), but all kUsage; also less than one step.
  Status apply_force(std::size_t i, std::size_t point, const Eigen::Vector3d& force, int steps);
  bool has_load(std::size_t i) const;  // in time, over or not, or a force that still acts
  double load_work(std::size_t i) const { return guests_[i]->load_work; }  // since the start, J

  // True if contact, a hand or a joint acted on the guest in the last step, or it has loads.
  bool is_pushed(std::size_t i) const;

  // Joins a contact point of a guest to a point of another body and returns the joint's number,
  // which is not used again. Its work is part of sums(): ContactSums::joint. joint(): null: there
  // is none. other: as in GuestJoint; a body's number in the group.
  std::size_t join(GuestJoint joint);
  void separate(std::size_t joint);
  const GuestJoint* joint(std::size_t joint) const;
  // The spring and damper of a pin at the point.
  HandSpring stiffest_hand(std::size_t i, std::size_t point) const {
    return stiffest_spring(mass_at(i, point), step_);
  }
  double mass_at(std::size_t i, std::size_t point) const {  // kg; infinite: it is fixed
    const GuestStep& step = *guests_[i]->step;
    return step.is_fixed(point) ? std::numeric_limits<double>::infinity() : step.mass_at(point);
  }
  // The contact point that is a vertex of the mesh, or of the cloth's file or grid. Errors
  // (kContent): there is no such vertex, or it is inside a body of tetrahedra.
  Result<std::size_t> point_of_vertex(std::size_t i, VertexId vertex) const;
  // A vertex of the mesh, or the particle, that is the point or next to it.
  VertexId number_of(std::size_t i, std::size_t point) const {
    return guests_[i]->step->number_of(point);
  }

  // Contact points: their number, the one nearest to a place, and the place of one, m.
  std::size_t points(std::size_t i) const { return guests_[i]->step->points(); }
  std::size_t point_near(std::size_t i, const Eigen::Vector3d& place) const;
  Eigen::Vector3d point_at(std::size_t i, std::size_t point) const {
    return guests_[i]->step->start_of(point);
  }

  // A body whose step failed is as before it and is not stepped again.
  bool failed(std::size_t i) const { return guests_[i]->failed; }
  // The deepest contact point inside one of the colliders now, and the margin, m.
  double deepest_in(std::size_t i, std::span<const PlacedCollider> colliders) const;
  // The same in the shape of a body at `place`.
  double deepest_in(std::size_t i, const Collider& shape, const PresentPlace& place) const;
  double margin(std::size_t i) const { return guests_[i]->step->area_law().margin; }
  // Of the last step: sums over all islands, and the number of bodies in them.
  const MixedReport& mixed_report() const { return report_; }
  std::size_t in_islands() const { return in_islands_; }

  double step_size() const { return step_; }  // s
  std::size_t size() const override { return guests_.size(); }
  void set_gravity(const Eigen::Vector3d& gravity) override;
  void start(std::span<const PlacedCollider> colliders) override;
  void find_contacts(std::span<ContactStep* const> contacts, std::span<const char> awake) override;
  std::span<const std::pair<std::size_t, std::size_t>> links() const override { return links_; }
  void step_island(std::span<const std::size_t> roots, const HostIsland& island) override;
  void step_others(std::span<const std::size_t> roots) override;
  void start_parts() override;
  bool step_part(const GuestPart& part, const HostIsland& island) override;
  void end_parts(bool made) override;
  bool asleep(std::size_t i) const override { return guests_[i]->rest.asleep; }
  void wake(std::size_t i) override;
  void wake_all() override;
  // Wakes the guest between two steps, before its state is set.
  void put_awake(std::size_t i) { guests_[i]->rest = {}; }
  bool note_rest(std::size_t i) override;
  void fall_asleep(std::size_t i) override;
  bool holds_body(std::size_t i) const override;
  void carry(StateStream& stream, std::size_t bodies) override;

 private:
  struct Rest {
    RestTime time;
    bool asleep = false;
    Eigen::Vector3d gravity = Eigen::Vector3d::Zero();

    void carry(StateStream& stream) { stream(time, asleep, gravity); }
  };
  struct Guest {
    std::string name;
    // One of these has a value. They do not move, because their steps have their addresses.
    std::optional<TetBody> tet_body = {};
    std::optional<ClothBody> cloth_body = {};
    std::unique_ptr<GuestStep> step = {};
    TetStep* tets = nullptr;     // the step of tetrahedra, or null
    ClothStep* cloth = nullptr;  // that of a cloth, or null
    ContactSums sums = {};
    std::int64_t contacts = 0;
    double deepest = 0.0, slip = 0.0, load_work = 0.0;
    bool failed = false, touched = false;
    bool removed = false, old = false;  // old: before the last step
    Rest rest = {};
    bool started = false;  // start() of a sleeping guest, whose place it keeps
  };
  // A hand or a joint; those that are not in use have been released.
  struct Hand {
    bool used = false;
    GuestHand hand = {};
    HandPull pull = {};

    void carry(StateStream& stream) { stream(used, hand); }
  };
  struct Loaded {
    bool used = false;
    GuestLoad load = {};
    LoadPush push = {};

    // Of a force that acts for some steps.
    void carry(StateStream& stream) {
      stream(used, load.guest, load.steps);
      stream.sized(load.pushes);
    }
  };
  struct Link {
    bool used = false;
    GuestJoint joint = {};
    JointPull pull = {};
    Joint before = {};  // a step that is taken in parts
  };
  // Contact of the points of `first` with `second`: members by their numbers in links(), of which
  // one is that of a guest; kNobody: a collider.
  struct Met {
    std::size_t first = 0, second = 0;
    PairForces* forces = nullptr;
  };
  // Numbers of contacts.
  struct Counts {
    std::size_t bent = 0, hulls = 0, colliders = 0, rates = 0, met = 0, links = 0;
  };

  std::size_t keep(std::unique_ptr<Guest> guest);
  void meet(std::span<const std::size_t> guests, std::span<ContactStep* const> contacts);
  bool has_to_wake(std::size_t guest) const;
  void start(std::size_t guest);
  bool is_joined(std::size_t guest) const;
  bool load_to_come(std::size_t guest) const;
  std::int64_t steps_of(std::size_t guest) const;  // since the start
  double pull_of(std::size_t guest) const;
  void meet_hands(std::size_t guest);
  Status check_load(const GuestLoad& load, ErrorKind of_fixed) const;
  double average_of(const GuestLoad& load) const;
  template <class Visit>
  void for_loads_of(std::size_t guest, const Visit& visit);
  void meet_loads(std::size_t guest);
  void prepare_loads(std::size_t guest);
  void age_forces(std::size_t guest);
  void forget_loads(std::size_t guest);
  void carry_loads(StateStream& stream);
  void meet_joints(std::size_t guest);
  bool may_touch(std::size_t guest, bool to_guest, std::size_t other) const;
  void meet_colliders(std::size_t guest);
  void meet_bodies(std::size_t guest, std::span<ContactStep* const> contacts);
  void meet_guests(std::size_t guest, std::span<const std::size_t> others);
  bool meet_hull(StepBody& points, std::size_t number, std::size_t guest, SharedRate* shared);
  void couple(std::size_t from, std::span<const IslandMember> members);
  SharedRate* next_rate();
  void forget_contacts(const Counts& known);
  void choose_guests(std::span<const std::size_t> roots, std::size_t root);
  void add_members(std::span<const IslandMember> members);
  void pair_bodies(std::span<const IslandMember> members, std::span<PairPoint> points,
                   std::span<IslandJoint> joints);
  MixedReport solve(const HostIsland& island, std::size_t from);
  bool solve_island(const HostIsland& island);
  void add_report(const MixedReport& report);
  void book(std::size_t guest);
  void carry_guest(StateStream& stream, std::size_t bodies, Guest& guest);
  void carry_links(StateStream& stream);

  double step_;
  double length_ = 0.0;           // of the present part of the step, s
  double from_ = 0.0, to_ = 1.0;  // its ends, fractions of the step
  std::vector<std::unique_ptr<Guest>> guests_;
  std::vector<Hand> hands_;
  std::vector<Link> joined_;
  std::vector<Loaded> loads_;    // in time
  std::vector<Loaded> applied_;  // for some steps; those that are not in use are over
  std::vector<std::pair<const TetModel*, std::shared_ptr<const TetPoints>>> points_;
  std::span<const PlacedCollider> colliders_;
  std::size_t bodies_ = 0;       // of the group
  std::span<const char> awake_;  // which of them take the step
  PairFilter filter_;
  // Contacts of a step; the first ones are in use.
  std::deque<BentContact> bent_;
  std::deque<HullContact> hulls_;
  std::deque<ColliderContact> on_colliders_;
  std::deque<ReducedPair> pairs_;
  std::deque<SharedRate> rates_;
  Counts counts_;  // those in use, without met and links
  std::size_t pair_count_ = 0;
  std::vector<Met> met_;
  std::vector<std::pair<std::size_t, std::size_t>> links_;
  // Of the present island.
  std::deque<ReducedStep> reduced_;  // of the group's bodies, by their numbers
  std::vector<std::size_t> who_;     // its guests
  std::vector<std::size_t> member_;  // the member's index of each guest; kNobody: of no other
  std::vector<StepBody*> island_;
  std::vector<PairForces*> couplings_;
  MixedIsland solver_;
  MixedReport report_;
  std::size_t in_islands_ = 0;
  // Of an island whose step is taken in parts.
  StepParts parts_;
  Counts whole_counts_;  // contacts of the whole step
  std::span<const PlacedCollider> whole_colliders_;
  MixedReport other_report_, part_report_;   // of the islands before it; sums of its parts
  std::vector<ContactStep*> part_contacts_;  // as find_contacts() has them
};

}  // namespace tremolo
