// Computes a better step from the last ones, for iterations x <- x + p(x) whose steps p shrink
// slowly. This is Anderson's mixing (1965); on a linear problem it is GMRES preconditioned by the
// iteration.
//
// Let dX and dP be the differences of the last positions and steps, and g the combination that
// minimizes |p - dP g|. It shows how much of p the last steps could have saved: the step is p - (dX
// + dP) g.
#pragma once

#include <Eigen/Core>

namespace tremolo {

class MixedSteps {
 public:
  // size: of x. All memory is allocated here: 2 kept() + 2 vectors.
  explicit MixedSteps(Eigen::Index size);

  static constexpr Eigen::Index kept() { return kKept; }

  // Forgets all steps.
  void clear() { count_ = total_ = 0; }

  // Adds the step p at x and computes the better step `mixed`. False if there is none: at first,
  // and where the differences are not informative. Nothing is allocated.
  bool mix(const Eigen::VectorXd& x, const Eigen::VectorXd& p, Eigen::VectorXd& mixed);

 private:
  static constexpr Eigen::Index kKept = 8;
  using Small = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kKept, kKept>;

  Eigen::MatrixXd dx_, dp_;  // one column per difference; the oldest is overwritten
  Eigen::VectorXd x_, p_;    // the last position and step
  Eigen::Matrix<double, kKept, kKept> products_;  // dP^T dP
  Eigen::Index count_ = 0;                        // number of filled columns
  Eigen::Index total_ = 0;                        // steps since clear()
};

}  // namespace tremolo
