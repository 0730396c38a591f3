#include "runtime/response/curve_points.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tremolo {
namespace {

// Distance of a multiplier from the unit circle that counts: above the errors of its computation.
constexpr double kOutside = 1e-7, kOutsideConservative = 1e-5;
// So many points take all steps after one whose multipliers are near the unit circle.
constexpr int kPointsNear = 8;

}  // namespace

CurvePoint CurvePoints::bare(const Eigen::VectorXd& y) const {
  CurvePoint point;
  point.omega = equations_.omega(y);
  point.motion = equations_.motion(y);
  point.load = equations_.load_factor(y);
  point.amplitude = amplitude(point.motion, point.load);
  return point;
}

double CurvePoints::amplitude(const FourierSeries& motion, double load) const {
  return options_.loaded_amplitude ? options_.loaded_amplitude(motion, load)
                                   : options_.amplitude(motion);
}

CurvePoint CurvePoints::measured(const Eigen::VectorXd& y) const {
  CurvePoint point = bare(y);
  point.share = last_share(point.motion);
  point.missing = equations_.missing_share(y);
  point.length = length;
  return point;
}

CurvePoint CurvePoints::at(const Eigen::VectorXd& y) {
  CurvePoint point = measured(y);
  if (options_.stability) set_multipliers(point, floquet_steps(point.harmonics()), 0);
  return point;
}

CurvePoint CurvePoints::next(const CurveState& state) {
  if (!options_.stability || conservative_) return at(state.y);
  CurvePoint point = measured(state.y);
  const int steps = floquet_steps(point.harmonics()), sign = equations_.motion_sign(state);
  if (sign >= 0 && points_near_circle_ == 0 && few_harmonics(point, steps / 2)) {
    set_multipliers(point, steps / 2, sign);
    if (far_inside(point)) return point;
  }
  set_multipliers(point, steps, sign);
  points_near_circle_ = far_inside(point) ? std::max(points_near_circle_ - 1, 0) : kPointsNear;
  return point;
}

Eigen::VectorXcd CurvePoints::deciding(const Eigen::VectorXcd& all) const {
  if (!conservative_) return all;
  std::vector<std::complex<double>> kept(all.begin(), all.end());
  for (int i = 0; i < 2; ++i)
    kept.erase(std::min_element(kept.begin(), kept.end(), [](const auto& a, const auto& b) {
      return std::abs(a - 1.0) < std::abs(b - 1.0);
    }));
  return Eigen::Map<Eigen::VectorXcd>(kept.data(), static_cast<Eigen::Index>(kept.size()));
}

double CurvePoints::circle() const {
  return 1.0 + (conservative_ ? kOutsideConservative : kOutside);
}

// sign: MotionEquations::motion_sign at the point, or 0. The multipliers are those of the whole
// linear equation about a motion of few harmonics, so that one passes +1 slightly off the point
// at which the equations of few harmonics turn. The equations decide, since the curve is theirs:
// the real multiplier nearest to +1 counts on the side that they say.
void CurvePoints::set_multipliers(CurvePoint& point, int steps, int sign) {
  point.multipliers = floquet_.multipliers(point.motion, point.omega, steps);
  point.unstable = outside(deciding(point.multipliers));
  if (sign != 0 && (above_one(point.multipliers) % 2 != 0) != (sign < 0)) {
    const Eigen::Index nearest = nearest_to_one(point.multipliers);
    point.unstable += nearest >= 0 && is_outside(point.multipliers[nearest]) ? -1 : 1;
  }
  point.stable = point.unstable == 0;
}

bool CurvePoints::is_outside(std::complex<double> multiplier) const {
  return !(std::abs(multiplier) <= circle());
}

int CurvePoints::outside(const Eigen::VectorXcd& multipliers) const {
  return static_cast<int>(std::count_if(multipliers.begin(), multipliers.end(),
                                        [&](const auto& m) { return is_outside(m); }));
}

// The real multipliers above 1.
int CurvePoints::above_one(const Eigen::VectorXcd& multipliers) const {
  return static_cast<int>(std::count_if(multipliers.begin(), multipliers.end(), [&](const auto& m) {
    return m.imag() == 0.0 && m.real() > 0.0 && is_outside(m);
  }));
}

Eigen::Index CurvePoints::nearest_to_one(const Eigen::VectorXcd& multipliers) {
  Eigen::Index nearest = -1;
  for (Eigen::Index i = 0; i < multipliers.size(); ++i)
    if (multipliers[i].imag() == 0.0 &&
        (nearest < 0 || std::abs(multipliers[i] - 1.0) < std::abs(multipliers[nearest] - 1.0)))
      nearest = i;
  return nearest;
}

// exp(-this) is the largest multiplier of the linear body.
double CurvePoints::least_decay(const CurvePoint& point) const {
  return 0.5 * system_.damping.minCoeff() * 2.0 * std::numbers::pi / point.omega;
}

// True if there are four steps to each harmonic that holds enough to excite another mode.
bool CurvePoints::few_harmonics(const CurvePoint& point, int steps) const {
  const Eigen::Index H = point.harmonics(), resolved = std::min<Eigen::Index>(H, steps / 4);
  const double rest = point.motion.rightCols(2 * (H - resolved)).norm();
  return rest < 0.01 * least_decay(point) * point.motion.rightCols(2 * H).norm();
}

// True if all multipliers decay by a quarter of the least decay of the linear body, or more.
bool CurvePoints::far_inside(const CurvePoint& point) const {
  return std::abs(point.multipliers[0]) < std::exp(-0.25 * least_decay(point));
}

}  // namespace tremolo
