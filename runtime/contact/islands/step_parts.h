// A step with contact whose solve fails is taken in parts: two halves, each of which may be divided
// again. So is one with a hard impact of rigid bodies (runtime/contact/impact.h), before it is
// tried: only the parts in which bodies are in contact are short. Bodies, colliders, grabs and
// loads follow the same path as in the whole step. Every part has the energy balance of the law for
// its own length, so that the energy closes.
//
// Divided steps allocate.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "runtime/contact/contact_record.h"
#include "runtime/contact/islands/contact_island.h"
#include "runtime/contact/islands/island_guests.h"
#include "runtime/contact/joint.h"
#include "runtime/contact_body.h"

namespace tremolo {

// A body of the step. Its begin_step() has succeeded, and it has contact.
struct PartBody {
  ContactBody* body = nullptr;
  std::size_t number = 0;  // in its group
};

// Two bodies, by their indices in the list, that may be in contact with each other.
struct PartPair {
  std::size_t a = 0, b = 0;
};

// Finds out whether the step of an island must be divided for its impacts.
class ImpactSearch {
 public:
  // True if the hard impacts of rigid members need a shorter step than h, s. points: of pairs of
  // the members, which have gathered. inside: see longest_for_impacts().
  bool divides(std::span<const IslandMember> members, std::span<const PairPoint> points, double h,
               bool inside);

 private:
  std::vector<ImpactBody> bodies_;
  std::vector<ImpactPoint> points_;
};

// The reason for which a step is taken in parts: its solve has failed, or bodies hit hard.
enum class PartReason { kFailure, kImpact };

// Bodies whose step is taken in parts, and what acts on them.
struct PartIsland {
  std::span<const PartBody> bodies;
  std::span<const PlacedCollider> colliders;  // of the whole step
  std::span<const PartPair> pairs;
  std::span<const IslandJoint> joints;  // their members are indices in `bodies`
  IslandGuests* guests = nullptr;       // whose step of the island has failed; null: none
};

class StepParts {
 public:
  // Takes the step of h, s, of all bodies and guests in parts. reports: one for each body, of the
  // whole step. False, with everything unchanged: a part failed as well. Otherwise the energy of
  // all parts has been added to the bodies, and only end_step() is left; nothing is left for
  // guests. After an impact that could not be resolved the bodies must gather again.
  bool step(const PartIsland& island, double h, std::span<StepReport> reports, PartReason reason);
  // The points of pairs in all parts; each force is multiplied by the part's fraction of the step.
  const std::vector<PairPoint>& points() const { return touched_; }

 private:
  // A body before the first part.
  struct Whole {
    std::string bytes;  // its complete state
    StepLoad load;
    Eigen::VectorXd q_before;
    std::vector<Eigen::Vector3d> from, to;  // path of its grabs, m, world
    std::vector<Grip> sums;                 // force, work and damped of the parts
    ContactRecord record;                   // sums of the parts
  };

  bool halves(double from, double to, int depth);
  bool part(double from, double to, int depth);
  void begin_part(double from, double to);
  bool take_part(double from, double to, bool last);
  bool solve_part(double from, double to, bool last);
  bool hits_hard(double h);
  void keep(std::size_t i);
  void finish(std::size_t i, bool made);
  void begin(std::size_t i, double from, double to);
  void find_points();
  void book(std::size_t i, const StepReport& report, double share);
  void put_back();

  PartIsland of_;
  double step_ = 0.0;  // s
  PartReason reason_ = PartReason::kFailure;
  int made_ = 0;  // parts so far
  std::span<StepReport> reports_;
  std::vector<Whole> wholes_;
  std::vector<Joint> joints_before_;
  std::vector<Eigen::Vector3d> joint_forces_;  // means over the parts so far, N
  std::vector<PlacedCollider> colliders_;
  std::vector<IslandJoint> part_joints_;
  std::vector<IslandMember> members_;
  std::vector<StepReport> part_reports_;
  std::vector<PairPoint> points_, touched_;
  std::size_t used_ = 0;
  ContactIsland island_;
  ImpactSearch impacts_;
};

}  // namespace tremolo
