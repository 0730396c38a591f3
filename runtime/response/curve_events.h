// Folds, branch points and changes of stability within one step of a curve.
#pragma once

#include <vector>

#include "runtime/response/curve_points.h"

namespace tremolo {

class CurveEvents {
 public:
  // The equations and the points must outlive the object. stability: multipliers are known.
  CurveEvents(MotionEquations& equations, CurvePoints& points, bool stability)
      : equations_(equations), points_(points), stability_(stability) {}

  // Appends what is found between `from` and `next`, the ends of a step, in the order of the curve.
  // before, point: the points of the two.
  void find(const CurveState& from, const CurveState& next, const CurvePoint& before,
            const CurvePoint& point, std::vector<Bifurcation>& events);

 private:
  // A step, and the way along its border from one end to the other.
  struct Step {
    const CurveState& from;
    const CurveState& next;
    double span;
  };
  double distance_from(const CurveState& from, const CurvePoint& point) const;
  Bifurcation find_fold(const Step& step);
  Bifurcation find_branch(const Step& step);
  Eigen::VectorXd point_of_jump(const Step& step);
  void find_crossing(const Step& step, const CurvePoint& before, const CurvePoint& point,
                     bool turned, bool forced, bool explained, std::vector<Bifurcation>& events);

  MotionEquations& equations_;
  CurvePoints& points_;
  bool stability_;
};

}  // namespace tremolo
