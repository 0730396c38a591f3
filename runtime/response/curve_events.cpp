#include "runtime/response/curve_events.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tremolo {
namespace {

// The least singular value of a state's matrix, with the sign of its determinant.
double signed_least(const CurveState& at) {
  Eigen::VectorXd left = Eigen::VectorXd::Ones(at.y.size()).normalized();
  double inverse = 0.0;
  for (int i = 0; i < 3; ++i) {
    left = at.factor.solve_transposed(at.factor.solve(left).normalized());
    inverse = left.norm();
    left /= inverse;
  }
  return at.sign / inverse;
}

}  // namespace

void CurveEvents::find(const CurveState& from, const CurveState& next, const CurvePoint& before,
                       const CurvePoint& point, std::vector<Bifurcation>& events) {
  const Step step{
      from, next,
      (from.border.array() * (next.y - from.y).array()).sum() / from.border.dot(from.tangent)};
  const bool turned = (next.omega_slope() > 0.0) != (from.omega_slope() > 0.0);
  const bool crossed = next.sign != from.sign;
  const bool forced = equations_.motion_sign(next) != 0;
  const std::size_t known = events.size();
  if (turned) events.push_back(find_fold(step));
  // With stability the multipliers name the branch points of free motions.
  if (crossed && (forced || !stability_)) events.push_back(find_branch(step));
  if (stability_) {
    const bool explained = forced && turned != crossed;
    find_crossing(step, before, point, turned, forced, explained, events);
  }
  std::stable_sort(events.begin() + static_cast<std::ptrdiff_t>(known), events.end(),
                   [&](const auto& a, const auto& b) {
                     return distance_from(from, a.point) < distance_from(from, b.point);
                   });
  equations_.refer_to(next.y);
}

double CurveEvents::distance_from(const CurveState& from, const CurvePoint& point) const {
  const Eigen::VectorXd y = equations_.unknowns_of(point.motion, point.omega);
  return from.border.dot(y - from.y);
}

// At a singular point in between nothing finer than the next point is found.
Bifurcation CurveEvents::find_fold(const Step& step) {
  const auto slope = [&](const Eigen::VectorXd& y) {
    const Result<CurveState> at = curve_state(equations_, y, step.from.onwards());
    return at ? at->omega_slope() : NAN;
  };
  const Result<Eigen::VectorXd> found = find_zero(
      equations_, step.from, step.span, step.from.omega_slope(), step.next.omega_slope(), slope);
  return {BifurcationKind::kFold, points_.at(found ? *found : step.next.y), 1.0};
}

// Where the bordered matrix is singular. If its determinant jumps from one sign to the other, the
// step has left the curve for another one across a narrow gap, and the point is that of the jump.
Bifurcation CurveEvents::find_branch(const Step& step) {
  constexpr double kSingular = 1e-3;  // relative to the values at the ends
  const double before = signed_least(step.from), behind = signed_least(step.next);
  const double scale = std::min(std::abs(before), std::abs(behind));
  double newest = NAN;
  const auto least = [&](const Eigen::VectorXd& y) {
    const Result<CurveState> at = curve_state(equations_, y, step.from.onwards());
    return newest = at ? signed_least(*at) / scale : NAN;
  };
  const Result<Eigen::VectorXd> found =
      find_zero(equations_, step.from, step.span, before / scale, behind / scale, least);
  const bool singular = found && std::abs(newest) < kSingular;
  CurvePoint at = points_.at(singular ? *found : point_of_jump(step));
  return {BifurcationKind::kBranch, std::move(at), 1.0, !singular};
}

// By halves of the step, on the far side of the jump.
Eigen::VectorXd CurveEvents::point_of_jump(const Step& step) {
  constexpr double kNearEnough = 1e-6;  // of the step
  double a = 0.0, b = step.span;
  Eigen::VectorXd far = step.next.y, y;
  while (std::abs(b - a) > kNearEnough * std::abs(step.span)) {
    bool found = false;
    // At a singular point in between nothing is found; next to it there is.
    for (const double part : {0.5, 0.3, 0.7, 0.1, 0.9}) {
      const double at = a + part * (b - a);
      if (!advance(equations_, step.from, at, true, y).converged) continue;
      const Result<CurveState> state = curve_state(equations_, y, step.from.onwards());
      if (!state) continue;
      found = true;
      if (state->sign == step.next.sign)
        b = at, far = y;
      else
        a = at;
      break;
    }
    if (!found) break;
  }
  return far;
}

// The multiplier that leaves or enters the unit circle, and where. explained: a fold or a branch
// point has been found, whose multiplier is the one nearest to +1.
void CurveEvents::find_crossing(const Step& step, const CurvePoint& before, const CurvePoint& point,
                                bool turned, bool forced, bool explained,
                                std::vector<Bifurcation>& events) {
  const auto one_sided = [&](const CurvePoint& at) {
    return points_.outside(points_.deciding(at.multipliers)) != at.unstable;
  };
  const bool without_nearest = explained || one_sided(before) || one_sided(point);
  const auto counted = [&](const CurvePoint& at) {
    Eigen::VectorXcd list = points_.deciding(at.multipliers);
    const Eigen::Index nearest = without_nearest ? CurvePoints::nearest_to_one(list) : -1;
    if (nearest < 0) return list;
    list.segment(nearest, list.size() - nearest - 1) = list.tail(list.size() - nearest - 1).eval();
    return Eigen::VectorXcd(list.head(list.size() - 1));
  };
  const Eigen::VectorXcd first = counted(before), last = counted(point);
  const int change = points_.outside(last) - points_.outside(first);
  if (change == 0 || first.size() != last.size()) return;
  const Eigen::Index index = std::min(points_.outside(first), points_.outside(last));
  const auto distance = [&](std::complex<double> m) { return std::abs(m) - points_.circle(); };
  const auto measure = [&](const Eigen::VectorXd& y) {
    const Eigen::VectorXcd list = counted(points_.at(y));
    return index < list.size() ? distance(list[index]) : NAN;
  };
  const Result<Eigen::VectorXd> found = find_zero(
      equations_, step.from, step.span, distance(first[index]), distance(last[index]), measure);
  if (!found) return;
  CurvePoint at = points_.at(*found);
  const std::complex<double> multiplier = counted(at)[index];
  const BifurcationKind kind = kind_of_crossing(multiplier);
  // A fold is where the curve turns, a branch point where the equations are singular; two
  // multipliers at once leave their determinant's sign as it is.
  if (kind == BifurcationKind::kBranch && (turned || (forced && change % 2 != 0))) return;
  events.push_back({kind, std::move(at), multiplier});
}

}  // namespace tremolo
