// The points of a curve: what is measured of a motion, and its stability.
#pragma once

#include "runtime/response/equations/motion_equations.h"
#include "runtime/response/response.h"

namespace tremolo {

// conservative: motions are free and undamped: two of their multipliers are always at +1.
class CurvePoints {
 public:
  // The equations, the system and the options must outlive the object.
  CurvePoints(MotionEquations& equations, const VibratingSystem& system, bool conservative,
              const CurveOptions& options)
      : equations_(equations),
        system_(system),
        floquet_(system),
        conservative_(conservative),
        options_(options) {}

  double length = 0.0;  // CurvePoint::length of the points that are measured next

  // CurvePoint::amplitude. load: CurvePoint::load.
  double amplitude(const FourierSeries& motion, double load) const;
  // Frequency, motion, load and amplitude of the unknowns y.
  CurvePoint bare(const Eigen::VectorXd& y) const;
  // With the multipliers, if they are asked for.
  CurvePoint at(const Eigen::VectorXd& y);
  // The next accepted point of the curve. Half the steps suffice to see that the multipliers of a
  // motion of few harmonics are far from the unit circle. Otherwise this point and some after it
  // take all steps. Half the steps show the stiffest coordinates as less damped than they are,
  // which only asks for all steps too often.
  CurvePoint next(const CurveState& state);

  // The multipliers that decide on stability: without the two at +1 of a free motion.
  Eigen::VectorXcd deciding(const Eigen::VectorXcd& all) const;
  // The size beyond which a multiplier counts as outside the unit circle.
  double circle() const;
  int outside(const Eigen::VectorXcd& multipliers) const;
  // The number of the real multiplier nearest to +1; -1 if there is none.
  static Eigen::Index nearest_to_one(const Eigen::VectorXcd& multipliers);

 private:
  CurvePoint measured(const Eigen::VectorXd& y) const;
  void set_multipliers(CurvePoint& point, int steps, int sign);
  bool is_outside(std::complex<double> multiplier) const;
  int above_one(const Eigen::VectorXcd& multipliers) const;
  double least_decay(const CurvePoint& point) const;
  bool few_harmonics(const CurvePoint& point, int steps) const;
  bool far_inside(const CurvePoint& point) const;

  MotionEquations& equations_;
  const VibratingSystem& system_;
  Floquet floquet_;
  bool conservative_;
  const CurveOptions& options_;
  int points_near_circle_ = 1;  // so many points from here on take all steps
};

}  // namespace tremolo
