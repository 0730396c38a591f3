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

#include <Eigen/LU>
#include <Eigen/SparseLU>

#include "runtime/contact/solve/contact_step.h"

namespace tremolo {

// A body of an island.
struct IslandMember {
  ContactStep* contact = nullptr;
  State* state = nullptr;
  const StepLoad* load = nullptr;
  FreeFrame* free = nullptr;
};

// A point of the member a near the shape of the member b at the start of the step, and what it
// feels in it. rows: of U of b nearby, transposed, r x 3. start: X there, m; d0, m; energy e0, J.
struct PairPoint {
  std::size_t a = 0, b = 0, point = 0;
  ContactLaw law;
  Eigen::MatrixX3d rows, near;  // near: for the making of rows
  double distance = 0.0, energy = 0.0;
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero(), place_at_start = gradient;  // y
  ContactHeld held;   // along the world's axes
  bool fresh = true;  // nothing is held yet
  ContactForce now;
  ContactTouch touch_a, touch_b;
  Eigen::Vector3d way_b = Eigen::Vector3d::Zero();
  Eigen::Vector3d place = way_b, slope = way_b;  // y at the end; the gradient of d there, world
  std::size_t coupling = 0;
};

// The points of a (its body is `first`) that may touch b in the step are added to `points`, whose
// first `count` entries are used; the number of them then. Both must have gathered.
std::size_t add_pair_points(const ContactStep& first, const ContactStep& second, std::size_t a,
                            std::size_t b, std::vector<PairPoint>& points, std::size_t count);

class ContactIsland {
 public:
  // One step of all members; points: of pairs of them. reports: one a member; where the island
  // does not converge, none does, and all states are as before. What it needs grows with the
  // largest island so far; an island of more than kDense unknowns allocates in each step.
  void step(std::span<const IslandMember> members, std::span<PairPoint> points, double h,
            std::span<StepReport> reports);

 private:
  static constexpr Eigen::Index kDense = 320;

  // How the residuals of two members, a < b, change with each other's unknowns.
  struct Coupling {
    std::size_t a = 0, b = 0;
    Eigen::MatrixXd ab, ba;
  };

  void couple(std::span<PairPoint> points);
  double evaluate(double renew);
  void make_jacobian(double heavier);
  void add_pair(const PairPoint& pair);
  void find_changes(const PairPoint& pair);
  bool find_move_dense();
  bool find_move_sparse();
  bool solve(int& iterations);
  void settle();

  std::span<const IslandMember> members_;
  std::span<PairPoint> points_;
  double h_ = 0.0;
  std::vector<Eigen::Index> first_;  // of each member's unknowns, and the number of all
  std::vector<double> enough_;
  std::vector<double> sizes_;
  std::vector<double> bends_;  // how far the coordinates move a member's points in the step, m
  std::vector<Coupling> couplings_;
  std::size_t coupled_ = 0;  // used
  std::vector<ContactAccount> accounts_;
  // How a pair's force falls with the unknowns of its bodies, 3 x n each.
  Eigen::Matrix3Xd change_a_, change_b_;
  Eigen::VectorXd by_q_;
  Eigen::MatrixX3d near_first_, near_second_;
  std::vector<double> starts_;
  Eigen::VectorXd residual_, move_, z_before_;
  Eigen::MatrixXd jacobian_;
  Eigen::PartialPivLU<Eigen::MatrixXd> factor_;
  Eigen::SparseMatrix<double> sparse_;
  Eigen::SparseLU<Eigen::SparseMatrix<double>> sparse_factor_;
  std::vector<Eigen::Triplet<double>> triplets_;
};

}  // namespace tremolo
