#include "runtime/response/closed_loop.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tremolo {
namespace {

constexpr std::ptrdiff_t kApart = 8;  // points; neighbours are near anyway
constexpr double kNear = 0.3;         // of the step: a chord's distance from its curve
constexpr double kSame = 1e-6;        // of the motion: the same solution
// Of the motion: of a solution with another number of harmonics, above
// CurveOptions::harmonic_share.
constexpr double kOtherHarmonics = 1e-2;

// The shift that brings the motion nearest to the other one, rad: free motions have any phase.
double nearest_shift(const FourierSeries& motion, const FourierSeries& to) {
  constexpr int kSamples = 64;
  const auto product = [&](double shift) {
    return shifted(motion, shift).cwiseProduct(to).rightCols(to.cols() - 1).sum();
  };
  double best = 0.0, largest = product(0.0);
  for (int n = 1; n < kSamples; ++n) {
    const double shift = 2.0 * std::numbers::pi * n / kSamples, value = product(shift);
    if (value > largest) largest = value, best = shift;
  }
  // Golden section around it.
  const double golden = 0.5 * (std::sqrt(5.0) - 1.0), width = 2.0 * std::numbers::pi / kSamples;
  double low = best - width, high = best + width;
  while (high - low > 1e-9) {
    const double a = high - golden * (high - low), b = low + golden * (high - low);
    if (product(a) > product(b))
      high = b;
    else
      low = a;
  }
  return 0.5 * (low + high);
}

double length(const CurveState& state, const Eigen::VectorXd& v) {
  return (state.weights.array() * v.array()).matrix().norm();
}

}  // namespace

std::optional<std::size_t> point_passed_again(MotionEquations& equations, const MotionCurve& curve,
                                              const CurveState& from, const CurveState& next) {
  const Eigen::VectorXd step = next.y - from.y;
  const double way = length(from, step);
  const double along = from.border.dot(step);
  const double omega_weight = from.weights[from.weights.size() - 1];
  const FourierSeries here = equations.motion(next.y);
  const double size = here.norm(), size_weight = from.weights[0];
  const auto count = std::ssize(curve.points);
  for (std::ptrdiff_t i = 0; i + kApart < count; ++i) {
    const CurvePoint& point = curve.points[static_cast<std::size_t>(i)];
    // What costs nothing first.
    if (omega_weight * std::abs(point.omega - equations.omega(next.y)) > 2.0 * way ||
        size_weight * std::abs(point.motion.norm() - size) > 2.0 * way)
      continue;
    const double shift =
        equations.has_free_phase()
            ? nearest_shift(with_harmonics(point.motion, equations.harmonics()), here)
            : 0.0;
    const auto unknowns = [&](const CurvePoint& at) {
      return equations.unknowns_of(shift == 0.0 ? at.motion : shifted(at.motion, shift), at.omega,
                                   equations.has_free_phase() ? 0.0 : at.load);
    };
    const Eigen::VectorXd known = unknowns(point);
    const double part = from.border.dot(known - from.y) / along;
    if (!(part > 0.0) || part > 1.0) continue;
    if (length(from, known - from.y - part * step) > kNear * way) continue;
    const CurvePoint& after = curve.points[static_cast<std::size_t>(i + 1)];
    const Eigen::VectorXd onwards = unknowns(after) - known;
    const auto squares = from.weights.array().square();
    if (!((squares * onwards.array() * step.array()).sum() > 0.5 * way * length(from, onwards)))
      continue;
    Eigen::VectorXd now, before = known;
    const double ds = part * along / from.border.dot(from.tangent);
    if (!advance(equations, from, ds, true, now).converged) continue;
    if (!solve_on_border(equations, from.border, kSharpTolerance, before).converged) continue;
    const double off = point.harmonics() == equations.harmonics() ? kSame : kOtherHarmonics;
    if (length(from, before - known) < off && length(from, before - now) < kSame)
      return static_cast<std::size_t>(i);
  }
  return std::nullopt;
}

}  // namespace tremolo
