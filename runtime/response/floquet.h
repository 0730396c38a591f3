// Stability of a periodic motion by its Floquet multipliers.
//
// A small deviation obeys d'' + (D + beta M(q)) d' + (K(q) + beta d(M q')/dq) d = 0 with the
// motion's own period. Its monodromy, 2r x 2r, is found with the Gauss method of three stages
// (order six), which is symplectic without damping and stable for stiff coordinates at any step.
// The multipliers are its eigenvalues: the motion is stable if all are inside the unit circle.
#pragma once

#include <complex>
#include <vector>

#include <Eigen/Core>

#include "runtime/math/dense/dense_lu.h"
#include "runtime/response/equations/fourier_series.h"
#include "runtime/response/equations/vibrating_system.h"

namespace tremolo {

// The usual number of steps a period for a motion with so many harmonics.
int floquet_steps(Eigen::Index harmonics);

// The multipliers of motions of one system. K and R along a motion are trigonometric polynomials of
// degree 2H, so that 4H + 2 samples give them at all stages.
class Floquet {
 public:
  // The system must outlive the object.
  explicit Floquet(const VibratingSystem& system);

  // Of the deviation (d, d'/omega) over one period from t = 0, 2r x 2r.
  Eigen::MatrixXd monodromy(const FourierSeries& motion, double omega, int steps);
  // The multipliers in the order of their size, the largest first, 2r.
  Eigen::VectorXcd multipliers(const FourierSeries& motion, double omega, int steps);

 private:
  // From the samples to the stages of all steps (samples x 3 steps).
  struct Weights {
    Eigen::Index harmonics;
    int steps;
    PaddedMatrix weights;
  };
  const PaddedMatrix& weights_of(Eigen::Index harmonics, int steps);
  void sample(const FourierSeries& motion, double omega);

  const VibratingSystem& system_;
  PotentialWorkspace workspace_;
  Evaluation evaluation_;
  StrainRateForce strain_rates_;
  std::vector<Weights> weights_;
  Eigen::VectorXd q_;
  PaddedMatrix samples_, rate_samples_;     // r^2 x samples
  PaddedMatrix at_nodes_, rates_at_nodes_;  // r^2 x 3 steps: h^2 K / omega^2, h R / omega
};

// Kinds of loss of stability. kFold: the curve turns back, a multiplier at +1. kBranch: another
// curve crosses, a multiplier at +1. kPeriodDoubling: at -1. kNeimarkSacker: a pair on the circle.
enum class BifurcationKind { kFold, kBranch, kPeriodDoubling, kNeimarkSacker };
const char* name_of(BifurcationKind kind);

// The kind by the multiplier that crosses the unit circle.
BifurcationKind kind_of_crossing(std::complex<double> multiplier);

}  // namespace tremolo
