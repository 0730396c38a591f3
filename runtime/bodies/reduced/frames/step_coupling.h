// The effect of a moving frame on a step of the energy-preserving family
// (runtime/bodies/reduced/integrators/energy_preserving.cpp): forces in addition to G - f, and a
// momentum p that may differ from the velocity v of the coordinates.
#pragma once

#include <cmath>

#include <Eigen/Core>

#include "common/load_signal.h"
#include "runtime/math/state.h"

namespace tremolo {

class StepCoupling {
 public:
  virtual ~StepCoupling() = default;

  // Call this before the first evaluate() of a step of h, s, from q0 and v0, r each. A step that is
  // taken in parts calls it for each part.
  virtual void begin(double h, const Eigen::VectorXd& q0, const Eigen::VectorXd& v0) = 0;

  // Called once per residual. d = q1 - q0, S: the diagonal of (a), r each. dp: in, the value of (a)
  // without the coupling, S (N d/h - v0); out, p1 - p0. force: the forces of (b) in addition to G -
  // f are added to it.
  virtual void evaluate(const Eigen::VectorXd& d, const Eigen::VectorXd& S, Eigen::VectorXd& dp,
                        Eigen::VectorXd& force) = 0;

  // Not 0: the last evaluate() could not solve an equation of its own, and this is left of it. Such
  // a step must not be accepted.
  virtual double unsolved() const { return 0.0; }

  // False: evaluate() never changes dp.
  virtual bool changes_momentum() const = 0;

  // Norm of a force that a residual is compared with, in addition to R and f.
  virtual double force_scale() const = 0;

  // Ends a step (or part) that converged, with the d of the last evaluate(). True: it changed v
  // from v0 to v1 and returned to v the energy left over by the solve, `defect` in J. False: p is
  // v, and the method does both.
  virtual bool finish(const Eigen::VectorXd& d, double defect, Eigen::VectorXd& v) = 0;

 protected:
  StepCoupling() = default;
  StepCoupling(const StepCoupling&) = default;
  StepCoupling& operator=(const StepCoupling&) = default;
};

// Removes the fraction x = defect/most of a kinetic energy `most` from v: v <- sqrt(1 - x) v. It
// does not compute v *= sqrt(1 - x), because near one the roots round to one side, 5e-17 a step.
// False, with v unchanged: the fraction is larger than a tenth.
inline bool give_back(double defect, double most, Eigen::VectorXd& v) {
  constexpr double kFarthestFix = 0.1;
  const double x = defect / most;
  if (!(std::abs(x) < kFarthestFix)) return false;
  v -= (x / (1.0 + std::sqrt(1.0 - x))) * v;
  return true;
}

// A force in the world on a vertex of a body whose frame moves. A force along the world's axes on a
// vertex.
struct PointForce {
  Signal signal;                                    // multiplies the force
  VertexRows place;                                 // the vertex
  Eigen::Vector3d force = Eigen::Vector3d::Zero();  // N
  int steps = 0;  // remaining steps if positive; else it acts as long as the signal lasts
  Eigen::VectorXd weights = {};  // of the vertex on the body's bones; empty with one frame
};

}  // namespace tremolo
