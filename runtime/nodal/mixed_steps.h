// A better step out of the last ones, for iterations x <- x + p(x) whose steps p shrink slowly: by
// Anderson's mixing (1965), which on a linear problem is GMRES preconditioned by the iteration.
//
// With the differences dX and dP of the last places and steps, the combination g for which |p - dP
// g| is least says how much of p the last steps could have saved: the step is p - (dX + dP) g.
#pragma once

#include <Eigen/Core>

namespace tremolo {

class MixedSteps {
 public:
  // size: of x. All memory is taken here: 2 kept() + 2 vectors.
  explicit MixedSteps(Eigen::Index size);

  static constexpr Eigen::Index kept() { return kKept; }

  // Forgets all steps.
  void clear() { count_ = total_ = 0; }

  // Told the step p at x; mixed: the better one. False where there is none: at first, and where
  // the differences say nothing. Nothing is allocated.
  bool mix(const Eigen::VectorXd& x, const Eigen::VectorXd& p, Eigen::VectorXd& mixed);

 private:
  static constexpr Eigen::Index kKept = 8;
  using Small = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kKept, kKept>;

  Eigen::MatrixXd dx_, dp_;                       // a column a difference, the oldest overwritten
  Eigen::VectorXd x_, p_;                         // the last ones
  Eigen::Matrix<double, kKept, kKept> products_;  // dP^T dP
  Eigen::Index count_ = 0;                        // columns that are filled
  Eigen::Index total_ = 0;                        // steps since clear()
};

}  // namespace tremolo
