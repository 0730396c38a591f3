// Sums over the steps of a body of tetrahedra in a run.
#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "common/state_stream.h"
#include "runtime/bodies/tets/motion/tet_body.h"

namespace tremolo {

class TetSums {
 public:
  // Takes the body at its start.
  explicit TetSums(const TetBody& body);

  // Adds a step that succeeded, at whose end the body is.
  void add(const TetBody& body, const TetStepReport& step);

  std::int64_t iterations() const { return iterations_; }  // of Newton's method
  std::int64_t switched() const { return switched_; }      // changes of an edge's degree
  // Steps by their kind, as in TetStepReport.
  std::int64_t in_parts() const { return in_parts_; }
  std::int64_t linearised() const { return linearised_; }
  std::int64_t unsolved() const { return unsolved_; }
  std::int64_t guarded() const { return guarded_; }
  double energy_of_switches() const { return energy_of_switches_; }  // taken from the body, J
  double jump() const { return jump_; }                              // the largest
  // Of quadratic edges, the mean over the start and all steps.
  double share() const { return share_ / static_cast<double>(count_); }
  // Of a vertex from its position at the start, the largest after any step, m.
  double displacement() const { return displacement_; }

  // Saves or restores the sums, not the start.
  void carry(StateStream& stream);

 private:
  Eigen::VectorXd first_;  // positions at the start, m
  std::int64_t count_ = 1, iterations_ = 0, switched_ = 0, in_parts_ = 0, linearised_ = 0,
               unsolved_ = 0, guarded_ = 0;
  double energy_of_switches_ = 0.0, jump_ = 0.0, share_ = 0.0, displacement_ = 0.0;
};

}  // namespace tremolo
