// What a moving frame adds to a step of the energy-preserving family
// (runtime/integrators/energy_preserving.cpp): forces beside its G - f, and a momentum p that may
// not be the velocity v of the coordinates alone.
#pragma once

#include <cmath>

#include <Eigen/Core>

namespace tremolo {

class StepCoupling {
 public:
  virtual ~StepCoupling() = default;

  // Before the first evaluate() of a step of h, s, from q0 and v0, r each. A step that is taken in
  // parts calls it for each part.
  virtual void begin(double h, const Eigen::VectorXd& q0, const Eigen::VectorXd& v0) = 0;

  // Once a residual. d = q1 - q0, S: the diagonal of (a), r each. dp: in what (a) says without the
  // coupling, S (N d/h - v0); out p1 - p0. force: what (b) has beside G - f is added to it.
  virtual void evaluate(const Eigen::VectorXd& d, const Eigen::VectorXd& S, Eigen::VectorXd& dp,
                        Eigen::VectorXd& force) = 0;

  // False: evaluate() leaves dp as it is, whatever it is.
  virtual bool changes_momentum() const = 0;

  // The norm of a force by which a residual is judged besides those of R and f.
  virtual double force_scale() const = 0;

  // At the end of a step (or part) that converged, with the d of the last evaluate(). Returns true
  // if it made v, which is v0, to v1 and gave back there the energy that the solve left over,
  // `defect` in J; false if p is v and the method does both.
  virtual bool finish(const Eigen::VectorXd& d, double defect, Eigen::VectorXd& v) = 0;

 protected:
  StepCoupling() = default;
  StepCoupling(const StepCoupling&) = default;
  StepCoupling& operator=(const StepCoupling&) = default;
};

// Takes x = defect/most of a kinetic energy `most` off v: v <- sqrt(1 - x) v. Not by v *= sqrt(1 -
// x): near one the roots round to one side, 5e-17 a step. Returns false, and leaves v, for a
// larger share than a tenth.
inline bool give_back(double defect, double most, Eigen::VectorXd& v) {
  constexpr double kFarthestFix = 0.1;
  const double x = defect / most;
  if (!(std::abs(x) < kFarthestFix)) return false;
  v -= (x / (1.0 + std::sqrt(1.0 - x))) * v;
  return true;
}

}  // namespace tremolo
