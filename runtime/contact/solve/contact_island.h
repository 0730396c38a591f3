// One step of several bodies that touch each other: the equations of each (contact_step.h) and the
// forces between them, solved for together (docs/theory.md, section "Contact").
//
// A point of body A has from body B, whose shape at rest is a collider in B's mesh coordinates, the
// distance
//
//     d = D_B(X),   X + u_B(X) = Ro_B^T (x_A - c_B)
//
// where u_B is a smooth field through B's points. With the ends d0 and d1 of a step, contact_law.h
// gives the force F on A; B feels -F at the same place, about which its torque is taken, so that
// both momenta of the pair stay to rounding. By how much the place moves with either body is what
// F's work on it is counted by, and d1 - d0 is F's direction times the difference of the two,
// exactly: the pair's energy gives what both bodies get. What u_B changes by between the end of one
// step and the start of the next, where other points of B may be the nearest, is told as the
// account's surplus.
#pragma once

#include <span>
#include <vector>

#include "runtime/contact/solve/block_solver.h"
#include "runtime/contact/solve/contact_step.h"
#include "runtime/contact/solve/island_joint.h"
#include "runtime/contact/solve/pair_point.h"

namespace tremolo {

// A body of an island.
struct IslandMember {
  ContactStep* contact = nullptr;
  State* state = nullptr;
  const StepLoad* load = nullptr;
  FreeFrame* free = nullptr;
  std::size_t number = 0;  // of the body in its group
};

class ContactIsland {
 public:
  // One step of all members; points: of pairs of them, the first `count`, pair by pair, of each
  // those of the lower member first; points that were missed are added. joints: pair by pair as
  // well. whole: all means are tried, since the step is not cut. reports: one a member; where the
  // island does not converge, none does, and all states are as before. What it needs grows with the
  // largest island so far; see block_solver.h.
  void step(std::span<const IslandMember> members, std::vector<PairPoint>& points,
            std::size_t& count, std::span<IslandJoint> joints, double h, bool whole,
            std::span<StepReport> reports);

 private:
  // Two members, a < b, their points, from `first` on, and their joints. touches: a joint holds
  // them, or a point acted when last looked at. looked: it is evaluated.
  struct Coupling {
    std::size_t a = 0, b = 0;
    std::size_t first = 0, count = 0;
    std::size_t first_joint = 0, joints = 0;
    bool touches = false, looked = false;
    PairRate rate;
    PairBlocks blocks;
  };

  // In how many iterations members move by themselves first, and how often in each.
  struct Attempt {
    int relaxed = 0, alone = 0;
    bool hold = false;  // friction's limits, as a last resort: see renewal()
  };
  static const Attempt kAttempts[];
  static constexpr int kFirstAttempts = 2;  // before the step is cut

  enum class Outcome { kMoved, kDone, kFailed };

  void couple();
  Coupling& add_coupling(std::size_t low, std::size_t high);
  void list_couplings();
  std::span<const std::size_t> couplings_of(std::size_t member) const {
    return std::span(coupling_of_)
        .subspan(first_coupling_[member], first_coupling_[member + 1] - first_coupling_[member]);
  }
  void choose_none();
  void look(std::size_t member);
  void look_at_couplings(std::size_t member);
  void choose_all();
  void choose(std::span<const std::size_t> group);
  void choose_one(std::size_t member);
  void move_with(std::size_t member);
  std::size_t root(std::size_t i);
  bool is_converged(std::size_t i) const;
  bool find_groups();
  double measure();
  double farthest() const;
  Outcome move(int iteration, bool follow, double& heavier);
  void relax(std::span<const std::size_t> group, int iteration, int times);
  bool moves(std::size_t member) const { return place_[member] != kStill; }
  ContactStep& body(std::size_t member) const { return *members_[member].contact; }
  void push(const PairPoint& pair);
  void push(const IslandJoint& link);
  double evaluate(const ContactRenewal& renewal);
  void make_jacobian(double heavier, bool follows);
  void make_links(Coupling& coupling, bool follows);
  bool try_following(int iteration, double size);
  bool move_whole(int iteration);
  void keep_unknowns();
  bool add_missed(std::vector<PairPoint>& points, std::size_t& count);
  void remember();
  bool solve_for_move();
  bool solve(const Attempt& attempt, bool whole, int& iterations);
  void begin();
  void settle();

  static constexpr std::size_t kStill = static_cast<std::size_t>(-1);

  std::span<const IslandMember> members_;
  std::span<PairPoint> points_;
  std::span<IslandJoint> joints_;
  double h_ = 0.0;
  bool hold_ = false;  // friction's limits, as a last resort
  // Members that are not converged, and what they touch, in groups that are solved for one after
  // the other: group_ is a group's lowest member, or kStill; in by_group_ those of a group stand
  // next to each other. moving_: the group at hand; place_: each one's place in it, or kStill;
  // first_: of its unknowns, and the number of all. looked_: their residual may change; looked_at_,
  // seen_: these members, and the couplings of them.
  std::vector<std::size_t> parent_, group_, by_group_, moving_, place_;
  std::vector<Eigen::Index> first_;
  std::vector<char> looked_;
  std::vector<std::size_t> looked_at_, seen_;
  std::vector<double> enough_, heavier_;
  std::vector<double> sizes_;
  std::vector<double> bends_;  // how far the coordinates move a member's points in the step, m
  std::vector<Coupling> couplings_;
  std::size_t coupled_ = 0;  // used
  // The couplings of each member, one member after the other.
  std::vector<std::size_t> first_coupling_, coupling_of_;
  std::vector<ContactAccount> accounts_;
  PairScratch scratch_;
  std::vector<double> starts_;
  Eigen::VectorXd residual_, move_, z_before_, scale_;
  std::vector<const Eigen::MatrixXd*> diagonal_;
  std::vector<BlockLink> links_;
  BlockSolver solver_;
};

}  // namespace tremolo
