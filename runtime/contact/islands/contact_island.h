// One step of several bodies in contact with each other. The equations of each body
// (contact_step.h) and the forces between them are solved together (docs/theory.md, section
// "Contact").
//
// The shape of body B at rest is a collider in B's mesh coordinates. A point of body A has the
// distance from B
//
//     d = D_B(X),   X + u_B(X) = Ro_B^T (x_A - c_B)
//
// where u_B is a smooth field through B's points. With the distances d0 and d1 at the ends of a
// step, contact_law.h gives the force F on A. B receives -F at the same position, about which the
// torque is taken, so that both momenta of the pair are constant to rounding.
//
// The work of F on either body is its product with the displacement of the position with that body.
// d1 - d0 is the direction of F times the difference of the two displacements, exactly: the pair's
// energy supplies the work on both bodies. u_B can change between the end of one step and the start
// of the next, where other points of B may be the nearest; the account reports this as surplus.
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "runtime/contact/contact_values.h"
#include "runtime/contact/islands/block_solver.h"
#include "runtime/contact/joint.h"
#include "runtime/contact/solve/contact_step.h"
#include "runtime/contact/solve/pair_point.h"

namespace tremolo {

// A joint of the members a and b in a step: its force, and the effect of the force on the equations
// of the two.
struct IslandJoint {
  Joint* joint = nullptr;
  std::size_t a = 0, b = 0;
  ContactTouch touch_a = {}, touch_b = {};
  JointForce now = {};
  // The motions of places on several bones, if `boned`.
  bool boned_a = false, boned_b = false;
  StepMotion on_bones_a = {}, on_bones_b = {};
};

// Sets the joint's motions on bones, at the beginning of a step.
void begin_joint(IslandJoint& link, const ContactEquations& first, const ContactEquations& second);

// Computes the joint's force at the present positions of the two bodies. h: the step, s.
void evaluate_joint(IslandJoint& link, const ContactEquations& first,
                    const ContactEquations& second, double h);

// Apply the force to the first and to the second body, between evaluate() and close() of that body.
void push_first(const IslandJoint& link, ContactEquations& first);
void push_second(const IslandJoint& link, ContactEquations& second);

// Same as add_pair_slopes(), without the rotation of the damper's force.
void add_joint_slopes(const IslandJoint& link, ContactEquations& first, ContactEquations& second,
                      Eigen::MatrixXd& first_by_second, Eigen::MatrixXd& second_by_first);

// Adds the work and loss of the joint to the joint and to the accounts of its bodies; for a driven
// body relative to its frame.
void settle_joint(const IslandJoint& link, const ContactEquations& first,
                  const ContactEquations& second, ContactAccount& a, ContactAccount& b);

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
  // One step of all members. points: of pairs of members, the first `count` entries, pair by pair,
  // in each pair first the points of the lower member; missed points are added. joints: also pair
  // by pair. whole: tries all means, because the step will not be subdivided. reports: one for each
  // member. If the island does not converge, no member does, and all states are unchanged. Memory
  // grows with the largest island so far; see block_solver.h.
  void step(std::span<const IslandMember> members, std::vector<PairPoint>& points,
            std::size_t& count, std::span<IslandJoint> joints, double h, bool whole,
            std::span<StepReport> reports);

 private:
  // Two members, a < b, their points from index `first` on, and their joints.
  struct Coupling {
    // Members.
    std::size_t a = 0, b = 0;
    // Their points.
    std::size_t first = 0, count = 0;
    std::size_t first_joint = 0, joints = 0;
    // touches: a joint connects them, or a point acted in the last evaluation. looked: it is
    // evaluated.
    bool touches = false, looked = false;
    PairRate rate;
    PairBlocks blocks;
  };

  // relaxed: number of first iterations in which members also move one by one. alone: moves of
  // each.
  struct Attempt {
    int relaxed = 0, alone = 0;
    bool hold = false;  // keeps friction limits as a last resort: see renewal()
  };
  static const Attempt kAttempts[];
  static constexpr int kFirstAttempts = 2;  // before the step is subdivided

  // Fraction of the small size below which a residual is converged, as after the last move of
  // Newton's method.
  static constexpr double kConverged = 0.1;

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
  bool is_renewed(const ContactRenewal& renewal) const;
  void relax_farthest(std::span<const std::size_t> group, int iteration, int times);
  void make_jacobian(double heavier, bool follows);
  void make_links(Coupling& coupling, bool follows);
  bool try_following(int iteration, double size);
  bool move_whole(int iteration);
  void keep_unknowns();
  bool add_missed(std::vector<PairPoint>& points, std::size_t& count);
  void remember();
  bool solve_for_move(double size);
  bool solve(const Attempt& attempt, bool whole, int& iterations);
  void begin();
  void settle();

  static constexpr std::size_t kStill = static_cast<std::size_t>(-1);

  std::span<const IslandMember> members_;
  std::span<PairPoint> points_;
  std::span<IslandJoint> joints_;
  double h_ = 0.0;
  bool hold_ = false;  // keeps friction limits, as a last resort
  // Members that are not converged, with those in contact with them, form groups, which are solved
  // one after the other. group_: lowest member of a member's group, or kStill. by_group_: members
  // sorted by group. moving_: the present group. place_: index of each member in it, or kStill.
  std::vector<std::size_t> parent_, group_, by_group_, moving_, place_;
  // Index of each one's first unknown; the last entry is their number.
  std::vector<Eigen::Index> first_;
  // Members whose residual may change.
  std::vector<char> looked_;
  // looked_at_: those members. seen_: the couplings of them.
  std::vector<std::size_t> looked_at_, seen_;
  std::vector<std::size_t> farthest_;  // of relax_farthest()
  std::vector<double> enough_, heavier_;
  std::vector<double> sizes_;
  // Bounds of a member's motion in the step.
  std::vector<StepWay> ways_;
  // 1: the last evaluation renewed the member's limits wholly and kept its normals.
  std::vector<char> followed_;
  std::vector<Coupling> couplings_;
  std::size_t coupled_ = 0;  // number of entries in use
  // The couplings of each member, member by member.
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
