#include "runtime/response/half_period.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <utility>

#include "runtime/math/dense/dense_lu.h"

namespace tremolo {
namespace {

constexpr double kWalkStep = 0.01;  // along the other mode's backbone
constexpr int kWalkPoints = 300;
constexpr double kOutsideCircle = 1e-5;  // distance of a multiplier from the circle that counts

// The multipliers at which the period doubles unstably: real, negative, outside the unit circle.
int doublings(const CurvePoint& point) {
  int count = 0;
  for (const auto& multiplier : point.multipliers)
    if (std::abs(multiplier) > 1.0 + kOutsideCircle &&
        std::abs(std::arg(multiplier)) > std::numbers::pi - 1e-3)
      ++count;
  return count;
}

// The other mode's backbone from `start` on, towards larger amplitude (1) or smaller (-1).
Result<MotionCurve> walk(const FreeMotions& free, const CurveGoal& goal,
                         const CurveOptions& options, const CurvePoint& start, double towards,
                         int points, bool past_instability) {
  CurveOptions walking = options;
  walking.stability = true;
  walking.harmonics = start.harmonics();
  walking.most_harmonics = std::max<Eigen::Index>(start.harmonics(), options.most_harmonics / 2);
  walking.longest_step = kWalkStep;
  walking.most_points = points;
  FreeEquations equations(free.system, free.constant, start.harmonics(), free.least_size,
                          2.0 * free.omega_scale);
  equations.set_rest(free.rest);
  Eigen::VectorXd y = equations.unknowns_of(start.motion, start.omega);
  equations.refer_to(y);
  Eigen::VectorXd direction = equations.unknowns_of(start.motion, 0.0);
  direction.head(free.system.size()).setZero();
  if (!solve_on_border(equations, direction, kCurveTolerance, y).converged)
    return Error{ErrorKind::kSolver, "no motion of half the period was found"};
  CurveGoal near_goal;
  near_goal.beyond = goal.beyond;  // not `returned`: the other mode may not move the probe
  if (past_instability)
    near_goal.enough = [](const MotionCurve& curve) {
      if (curve.points.size() < 3) return false;
      const int now = doublings(curve.points.back());
      return std::any_of(curve.points.begin() + 1, curve.points.end(),
                         [&](const CurvePoint& point) { return doublings(point) > now; });
    };
  return trace_curve(equations, free.system, std::move(y), towards * direction, near_goal, true,
                     walking);
}

// The odd harmonics that a small motion at a period doubling has: a null vector of the odd block
// of the Jacobian, by inverse iteration.
FourierSeries doubled_shape(const FreeMotions& free, const FourierSeries& motion, double omega) {
  const Eigen::Index r = free.system.size(), H = harmonics_of(motion);
  HarmonicBalance balance(free.system, H);
  const Eigen::Index n = balance.unknowns();
  Eigen::MatrixXd J(n, n);
  Eigen::VectorXd by_omega(n);
  balance.jacobian(motion, omega, 0.0, J, by_omega, nullptr);
  std::vector<Eigen::Index> odd;
  for (Eigen::Index k = 1; k <= H; k += 2)
    for (Eigen::Index i = 0; i < 2 * r; ++i) odd.push_back(r * cosine_column(k) + i);
  const DenseLu factor(Eigen::MatrixXd(J(odd, odd)));
  const auto count = static_cast<Eigen::Index>(odd.size());
  Eigen::VectorXd shape = Eigen::VectorXd::Ones(count);
  for (int i = 0; i < 3; ++i) {
    shape = factor.solve_transposed(shape).normalized();
    shape = factor.solve(shape).normalized();
  }
  Eigen::VectorXd all = Eigen::VectorXd::Zero(n);
  all(odd) = shape;
  return all.reshaped(r, 2 * H + 1);
}

// The backbone that branches off at the period doubling.
Result<MotionCurve> branch_off(const FreeMotions& free, const CurveGoal& goal,
                               const CurveOptions& options, const CurvePoint& doubling) {
  constexpr double kFirstPart = 0.02;  // of the odd harmonics, relative to the motion
  const Eigen::Index H =
      std::min(options.most_harmonics, std::max(options.harmonics, 2 * doubling.harmonics() + 1));
  const FourierSeries motion = with_harmonics(doubled_period(doubling.motion), H);
  const double omega = 0.5 * doubling.omega;
  FreeEquations equations(free.system, free.constant, H, free.least_size, free.omega_scale);
  equations.set_rest(free.rest);
  const Eigen::VectorXd even = equations.unknowns_of(motion, omega);
  const FourierSeries shape = doubled_shape(free, motion, omega);
  const Eigen::VectorXd direction = equations.unknowns_of(shape, 0.0);
  const double size = motion.rightCols(2 * H).norm();
  for (double part = kFirstPart; part > 1e-4; part *= 0.3) {
    Eigen::VectorXd y = even + part * size * direction;
    equations.refer_to(even);
    if (solve_on_border(equations, direction, kCurveTolerance, y).converged)
      return trace_curve(equations, free.system, std::move(y), direction, goal, true, options);
  }
  return Error{ErrorKind::kSolver, "no motion was found at the period doubling"};
}

// A point of the other mode's backbone as one of the first, with twice the period.
CurvePoint doubled(CurvePoint point, double length, const CurveOptions& options) {
  point.motion = doubled_period(point.motion);
  point.omega *= 0.5;
  point.length += length;
  if (options.stability)
    point.multipliers = point.multipliers.array().square().matrix().eval();
  else
    point.multipliers.resize(0);
  return point;
}

}  // namespace

std::optional<MotionCurve> past_half_period(const FreeMotions& free, const CurveGoal& goal,
                                            const CurveOptions& options, MotionCurve& joined) {
  const double length = joined.points.back().length;
  CurvePoint start = joined.points.back();
  start.motion = halved_period(start.motion);
  start.omega *= 2.0;
  int most = -1;
  double towards = 1.0;
  for (const double sign : {1.0, -1.0}) {
    const Result<MotionCurve> first = walk(free, goal, options, start, sign, 2, false);
    if (!first) return std::nullopt;
    if (sign > 0.0) joined.points.back() = doubled(first->points.front(), length, options);
    const int count = doublings(first->points.back());
    if (count > most) most = count, towards = sign;
  }
  if (most == 0) return std::nullopt;
  Result<MotionCurve> walked = walk(free, goal, options, start, towards, kWalkPoints, true);
  if (!walked || walked->end != CurveEnd::kDone) return std::nullopt;
  const auto doubling = std::find_if(
      walked->bifurcations.rbegin(), walked->bifurcations.rend(),
      [](const Bifurcation& at) { return at.kind == BifurcationKind::kPeriodDoubling; });
  if (doubling == walked->bifurcations.rend()) return std::nullopt;
  Result<MotionCurve> beyond = branch_off(free, goal, options, doubling->point);
  if (!beyond) return std::nullopt;
  MotionCurve curve;
  // The last point of the walk is beyond the doubling.
  for (std::size_t i = 1; i + 1 < walked->points.size(); ++i)
    curve.points.push_back(doubled(walked->points[i], length, options));
  Bifurcation mark{BifurcationKind::kBranch, doubled(doubling->point, length, options), 1.0};
  curve.bifurcations.push_back({mark.kind, joined.points.back(), 1.0});
  curve.bifurcations.push_back(std::move(mark));
  const double so_far = length + walked->points.back().length;
  for (CurvePoint& point : beyond->points) {
    point.length += so_far;
    curve.points.push_back(std::move(point));
  }
  for (Bifurcation& found : beyond->bifurcations) curve.bifurcations.push_back(std::move(found));
  curve.end = beyond->end;
  curve.largest_share = beyond->largest_share;
  return curve;
}

}  // namespace tremolo
