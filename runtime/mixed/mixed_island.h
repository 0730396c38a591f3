// One step of several bodies of any kinds in contact with each other, solved as one equation.
//
// The equation is the stack of the bodies' residuals with the forces of contact (pair_forces.h).
// Newton's matrix has a block for each body, which the body multiplies itself, and terms of rank
// three for each point in contact, which are never assembled. GMRES solves it, because friction is
// not symmetric; the preconditioner is each body's own solve with its own contacts. Moves along a
// correction, kept limits and normals are those of ContactStep.
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "runtime/mixed/gmres.h"
#include "runtime/mixed/pair_forces.h"
#include "runtime/mixed/step_body.h"

namespace tremolo {

// Report of an island's step.
struct MixedReport {
  bool converged = true;
  int iterations = 0;     // moves of Newton's method
  int linear = 0;         // iterations of GMRES
  double residual = 0.0;  // the largest of a body, in units of its small size
  int cut = 0;            // islands whose step was subdivided
  int parts = 0;          // the parts of those
};

class MixedIsland {
 public:
  // Takes one step of all bodies. Couplings connect two of them, by their indices. If the step
  // fails, no body moves.
  MixedReport step(std::span<StepBody* const> bodies, std::span<PairForces* const> couplings);

  // The size of the residual of member i where the last step ended, whether it was solved or not.
  double size_of(std::size_t i) const { return sizes_[i]; }

 private:
  // kApart: some members, which far_ notes, are to be solved by themselves.
  enum class Outcome { kMoved, kDone, kApart, kFailed };

  bool solve(double heavier, bool hold);
  void choose_all();
  void choose_group(std::size_t root);
  Outcome move(int iteration, bool hold, bool apart, double& heavier);
  bool find_farthest();
  void relax(int iteration, bool hold);
  double evaluate(const ContactRenewal& renewal);
  double measure();
  bool find_move(double heavier, bool follows);
  bool needs_factor(double heavier) const;
  double slope() const;
  double go(double length, const ContactRenewal& renewal);
  Outcome try_following(int iteration, double size, bool apart);
  double size_now() const;
  void multiply(StepBody::In x, StepBody::Out rows);
  void precondition(StepBody::In rows, StepBody::Out x);
  bool add_missed();
  void settle();

  // The part of member i.
  template <class Vector>
  auto part(Vector&& all, std::size_t i) const {
    return all.segment(first_[i], first_[i + 1] - first_[i]);
  }

  std::span<StepBody* const> bodies_;
  std::span<PairForces* const> couplings_;
  MixedReport report_;
  std::vector<char> moves_;          // the members that move; the others rest where they are
  std::vector<PairForces*> seen_;    // the couplings of those
  std::vector<char> far_;            // the members with the largest residuals
  std::vector<std::size_t> apart_;   // of those the first one in contact, directly or not
  std::vector<Eigen::Index> first_;  // index of each body's first unknown, and their number
  std::vector<double> sizes_, enough_;
  Eigen::VectorXd residual_, move_, scaled_, empty_;
  std::vector<ContactAccount> accounts_;
  std::vector<double> starts_;
  Gmres gmres_;
  double factored_ = -1.0;  // heavier of the last decomposition; below 0: there is none
  int first_linear_ = 0;    // iterations of GMRES right after it
  int unsolved_ = 0;        // corrections of the step that GMRES did not solve
  double before_ = -1.0;    // size at the last move; below 0: there is none
  double tolerance_ = 0.0;  // of GMRES
};

}  // namespace tremolo
