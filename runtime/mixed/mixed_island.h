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

 private:
  bool solve(double heavier, bool hold);
  double evaluate(const ContactRenewal& renewal);
  double measure();
  bool find_move(double heavier, bool follows);
  bool needs_factor(double heavier) const;
  double slope() const;
  double go(double length, const ContactRenewal& renewal);
  bool try_following(int iteration, double size);
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
  std::vector<Eigen::Index> first_;  // index of each body's first unknown, and their number
  std::vector<double> sizes_, enough_;
  Eigen::VectorXd residual_, move_, scaled_, empty_;
  std::vector<ContactAccount> accounts_;
  std::vector<double> starts_;
  Gmres gmres_;
  double factored_ = -1.0;  // heavier of the last decomposition; below 0: there is none
  int first_linear_ = 0;    // iterations of GMRES right after it
};

}  // namespace tremolo
