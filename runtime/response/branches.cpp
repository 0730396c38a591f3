#include "runtime/response/branches.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "common/text.h"
#include "runtime/math/dense/dense_lu.h"
#include "runtime/response/curve_tracer.h"
#include "runtime/response/static_state.h"

namespace tremolo {
namespace {

// The direction of the branch that crosses at y: a second null vector of the Jacobian, normal to
// the tangent of the first curve, by inverse iteration.
struct Crossing {
  Eigen::VectorXd tangent, other;  // of length 1 in the weights
};
Result<Crossing> crossing_at(CurveEquations& equations, const Eigen::VectorXd& y,
                             const Eigen::VectorXd& along) {
  const Eigen::Index n = equations.unknowns();
  const Eigen::VectorXd weights = equations.weights(y);
  const auto length = [&](const Eigen::VectorXd& v) {
    return (weights.array() * v.array()).matrix().norm();
  };
  Crossing crossing;
  crossing.tangent = along / length(along);
  Eigen::MatrixXd matrix(n, n);
  equations.jacobian(y, matrix);
  matrix.row(n - 1) = (weights.array().square() * crossing.tangent.array()).matrix().transpose();
  const DenseLu factor(matrix);
  Eigen::VectorXd other = Eigen::VectorXd::Ones(n);
  for (int i = 0; i < 4; ++i) {
    const Eigen::VectorXd left = factor.solve_transposed(other);
    other = factor.solve(left.normalized());
    other /= length(other);
    if (!other.allFinite()) return Error{ErrorKind::kSolver, "the equations are singular there"};
  }
  crossing.other = std::move(other);
  return crossing;
}

// A place on a curve's polygon: on the way from the point `before` to the next one.
struct PlaceOnCurve {
  std::size_t before = 0;
  double distance = INFINITY;  // relative to the motion and the frequency at `scale`
};
// The nearest to a point.
PlaceOnCurve nearest_place(const MotionCurve& curve, const CurvePoint& point,
                           const CurvePoint& scale) {
  const auto scaled = [&](const CurvePoint& at) {
    const FourierSeries motion = with_harmonics(at.motion, scale.harmonics());
    Eigen::VectorXd y(motion.size() + 1);
    y << motion.reshaped() / scale.motion.norm(), at.omega / scale.omega;
    return y;
  };
  const Eigen::VectorXd y = scaled(point);
  PlaceOnCurve place;
  Eigen::VectorXd a = scaled(curve.points.front());
  for (std::size_t i = 0; i < curve.points.size(); ++i) {
    const std::size_t next = std::min(i + 1, curve.points.size() - 1);
    const Eigen::VectorXd b = scaled(curve.points[next]), side = b - a;
    const double square = side.squaredNorm();
    const double part = square > 0.0 ? std::clamp(side.dot(y - a) / square, 0.0, 1.0) : 0.0;
    const double distance = (y - a - part * side).norm();
    if (distance < place.distance) place = {i, distance};
    a = b;
  }
  return place;
}

// The curve's direction at a point of it, in the unknowns, of length 1 in the weights.
Eigen::VectorXd chord_at(const MotionCurve& curve, const CurvePoint& at,
                         const ForcedEquations& equations) {
  const std::size_t last = curve.points.size() - 1;
  const std::size_t before = std::min(nearest_place(curve, at, at).before, last > 0 ? last - 1 : 0);
  const CurvePoint &a = curve.points[before], &b = curve.points[std::min(before + 1, last)];
  const Eigen::VectorXd chord =
      equations.unknowns_of(b.motion, b.omega) - equations.unknowns_of(a.motion, a.omega);
  const Eigen::VectorXd weights = equations.weights(equations.unknowns_of(at.motion, at.omega));
  return chord / (weights.array() * chord.array()).matrix().norm();
}

double omega_scale_of(const ResponseRequest& request) {
  return std::max(request.omega_from, request.omega_to);
}

}  // namespace

Result<MotionCurve> fold_curve(const VibratingSystem& system, const ResponseRequest& request,
                               const CurvePoint& fold, double to_load,
                               const CurveOptions& options) {
  if (!(to_load > 0.0) || !std::isfinite(to_load) || to_load == 1.0)
    return content_error("the load's last factor must be positive, finite and other than 1");
  CurveOptions plain = options;
  plain.stability = false;
  plain.harmonics = fold.harmonics();
  plain.most_harmonics = std::max(plain.most_harmonics, plain.harmonics);
  const Result<Eigen::VectorXd> rest = static_state(system.potential, request.force.col(0));
  if (!rest) return rest.error();
  FoldEquations equations(system, request.force, fold.harmonics(),
                          vibration_size(fold.motion, *rest), omega_scale_of(request));
  equations.set_rest(*rest);
  Eigen::VectorXd y = equations.unknowns_of(fold.motion, fold.omega, 1.0);
  equations.refer_to(y);
  const Eigen::Index n = y.size();
  const Eigen::VectorXd border = Eigen::VectorXd::Unit(n, n - 2);
  if (!solve_on_border(equations, border, kCurveTolerance, y).converged)
    return Error{ErrorKind::kSolver, "no fold of the response was found at the given point"};
  const double upwards = to_load > 1.0 ? 1.0 : -1.0;
  CurveGoal goal;
  goal.beyond = [=](const CurvePoint& point) { return upwards * (point.load / to_load - 1.0); };
  // Past the cusp it is back at the first load, on the other fold.
  goal.enough = [=](const MotionCurve& curve) {
    return upwards * (curve.points.back().load - 1.0) < -1e-9;
  };
  return trace_curve(equations, system, std::move(y), upwards * border, goal, false, plain);
}

Result<MotionCurve> crossing_branch(const VibratingSystem& system, const ResponseRequest& request,
                                    const MotionCurve& first, const CurvePoint& branch, int sign,
                                    const CurveOptions& options) {
  constexpr double kFirstPart = 0.02;  // of the motion, along the branch
  constexpr double kNeighbour = 1e-3;  // of the motion, along the first curve
  CurveOptions from = options;
  from.harmonics = branch.harmonics();
  from.most_harmonics = std::max(from.most_harmonics, from.harmonics);
  const Result<Eigen::VectorXd> rest = static_state(system.potential, request.force.col(0));
  if (!rest) return rest.error();
  ForcedEquations equations(system, request.force, branch.harmonics(),
                            vibration_size(branch.motion, *rest), omega_scale_of(request));
  equations.set_rest(*rest);
  const Eigen::VectorXd at = equations.unknowns_of(branch.motion, branch.omega);
  // The first curve's tangent from its neighbours a little along it: at one frequency there may be
  // none, near a fold.
  const Eigen::VectorXd chord = chord_at(first, branch, equations);
  const Eigen::VectorXd across = equations.weights(at).array().square() * chord.array();
  Eigen::VectorXd ahead = at + kNeighbour * chord, behind = at - kNeighbour * chord;
  if (!solve_on_border(equations, across, kCurveTolerance, ahead).converged ||
      !solve_on_border(equations, across, kCurveTolerance, behind).converged)
    return Error{ErrorKind::kSolver, "the curve was not found near its branch point"};
  const Result<Crossing> crossing = crossing_at(equations, at, ahead - behind);
  if (!crossing) return crossing.error();
  const Eigen::VectorXd weights = equations.weights(at);
  const Eigen::VectorXd direction =
      sign * (weights.array().square() * crossing->other.array()).matrix();
  const double low = std::min(request.omega_from, request.omega_to);
  const double high = std::max(request.omega_from, request.omega_to);
  CurveGoal goal;
  goal.beyond = [=](const CurvePoint& point) {
    return std::max(point.omega / high - 1.0, 1.0 - point.omega / low);
  };
  // The branch meets the first curve at a minimum of their distance near zero.
  std::vector<double> distances;
  goal.enough = [&](const MotionCurve& curve) {
    constexpr double kNear = 0.3;  // of the largest distance; a step is a tenth of the motion
    distances.push_back(nearest_place(first, curve.points.back(), branch).distance);
    const std::size_t n = distances.size();
    if (n < 4) return false;
    const double most = *std::max_element(distances.begin(), distances.end());
    const double now = distances[n - 2];
    return now < distances[n - 3] && now < distances[n - 1] && now < kNear * most;
  };
  for (double part = kFirstPart; part > 1e-4; part *= 0.3) {
    Eigen::VectorXd y = at + sign * part * crossing->other;
    if (!solve_on_border(equations, direction, kCurveTolerance, y).converged) continue;
    Result<MotionCurve> curve =
        trace_curve(equations, system, std::move(y), direction, goal, false, from);
    // Beyond the meeting point the branch repeats itself.
    const bool inside = curve && goal.beyond(curve->points.back()) < -1e-9;
    if (curve && curve->end == CurveEnd::kDone && inside) curve->points.pop_back();
    return curve;
  }
  return Error{ErrorKind::kSolver, "no branch was found at the branch point"};
}

}  // namespace tremolo
