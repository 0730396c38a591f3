// A step with contact whose solve fails is taken in parts: two halves, each of which may be divided
// again. Bodies, colliders, grabs and loads follow the same path as in the whole step. Every part
// has the energy balance of the law for its own length, so that the energy closes.
//
// Divided steps allocate.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "runtime/contact/contact_record.h"
#include "runtime/contact/joint.h"
#include "runtime/contact/solve/contact_island.h"
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

class StepParts {
 public:
  // Takes the step of all bodies in parts. colliders: of the whole step. joints: their members are
  // indices in the list. reports: one for each body, of the whole step. False, with everything
  // unchanged: one of the bodies has a prescribed frame, or a part failed as well. Otherwise the
  // energy of all parts has been added to the bodies, and only end_step() is left.
  bool step(std::span<const PartBody> bodies, std::span<const PlacedCollider> colliders,
            std::span<const PartPair> pairs, std::span<const IslandJoint> joints,
            std::span<StepReport> reports);
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
    double step = 0.0;                      // s
  };

  bool halves(double from, double to, int depth);
  bool part(double from, double to, bool last);
  void begin(std::size_t i, double from, double to);
  void find_points();
  void book(std::size_t i, const StepReport& report, double share);
  void put_back();

  std::span<const PartBody> bodies_;
  std::span<const PlacedCollider> all_colliders_;
  std::span<const PartPair> pairs_;
  std::span<const IslandJoint> joints_;
  std::span<StepReport> reports_;
  std::vector<Whole> wholes_;
  std::vector<Joint> joints_before_;
  std::vector<PlacedCollider> colliders_;
  std::vector<IslandJoint> part_joints_;
  std::vector<IslandMember> members_;
  std::vector<StepReport> part_reports_;
  std::vector<PairPoint> points_, touched_;
  std::size_t used_ = 0;
  ContactIsland island_;
};

}  // namespace tremolo
