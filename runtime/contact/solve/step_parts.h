// A step with contact whose solve fails is taken in parts: twice half of it, each of which may be
// cut again. Bodies, colliders, hands and loads go through the same step as they would as a whole,
// and every part keeps the account of the law for its own length, so that the energy closes.
//
// Cut steps allocate.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "runtime/body.h"
#include "runtime/contact/joint.h"
#include "runtime/contact/solve/contact_island.h"

namespace tremolo {

// A body of the step: its begin_step() was made, and it has contact. number: in its group.
struct PartBody {
  Body* body = nullptr;
  std::size_t number = 0;
};

// Two bodies, by their places in the list of them, that may touch each other.
struct PartPair {
  std::size_t a = 0, b = 0;
};

class StepParts {
 public:
  // Makes the step of all bodies in parts. colliders: of the whole step. joints: their members are
  // places in the list. False: one of the bodies has a frame that moves as it is told, or a part
  // failed as well; then everything is as before. Otherwise the bodies have booked their parts but
  // for end_step(), and reports, one a body, are of the whole.
  bool step(std::span<const PartBody> bodies, std::span<const PlacedCollider> colliders,
            std::span<const PartPair> pairs, std::span<const IslandJoint> joints,
            std::span<StepReport> reports);
  // The points of pairs in all parts, with the force of each part times its share of the step.
  const std::vector<PairPoint>& points() const { return touched_; }

 private:
  // A body as it was before the first part.
  struct Whole {
    std::string bytes;  // all that it carries
    StepLoad load;
    Eigen::VectorXd q_before;
    std::vector<Eigen::Vector3d> from, to;  // of its hands, world, m
    std::vector<Grip> sums;                 // force, work and damped of the parts
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
