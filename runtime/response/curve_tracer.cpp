#include "runtime/response/curve_tracer.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "runtime/response/closed_loop.h"
#include "runtime/response/curve_events.h"
#include "runtime/response/curve_points.h"

namespace tremolo {
namespace {

constexpr double kFirstStep = 0.01;
constexpr double kShortestStep = 1e-7;
constexpr double kLeastCosine = 0.87;  // between the tangents of neighbours: 30 degrees
// Of the harmonics left out relative to the share of the highest: they decide on the frequency by
// their square, and an internal resonance by as little.
constexpr double kMissingPart = 0.1;
constexpr double kFarBelow = 0.2;  // of both limits, before harmonics are taken away
constexpr int kFewFactorizations = 2, kManyFactorizations = 3;
// Longer steps of free motions do not pass a change of the determinant's sign, where they may cross
// from one curve to another.
constexpr double kShortestOverGap = 1e-3;
// So many points have the harmonics of the one before once more of them were tried in vain.
constexpr int kPause = 4;

double tangent_cosine(const CurveState& a, const CurveState& b) {
  return (a.weights.array().square() * a.tangent.array() * b.tangent.array()).sum() /
         (a.weights.array() * b.tangent.array()).matrix().norm();
}

// A corrector that moves along the plane may find another part of the curve, with a similar
// tangent. Within the angle above a step is at most 1.2 times as long as planned.
constexpr double kLongestWay = 2.0;

class Tracer {
 public:
  Tracer(MotionEquations& equations, const VibratingSystem& system, const CurveGoal& goal,
         bool conservative, const CurveOptions& options)
      : equations_(equations),
        points_(equations, system, conservative, options),
        events_(equations, points_, options.stability),
        goal_(goal),
        options_(options),
        ds_(std::min(kFirstStep, options.longest_step)) {}

  Result<MotionCurve> trace(Eigen::VectorXd first, const Eigen::VectorXd& direction) {
    Result<CurveState> state = curve_state(equations_, std::move(first), direction);
    if (!state) return state.error();
    state_ = std::move(*state);
    held_ = direction;
    adapt_harmonics();
    held_.resize(0);
    add_point(points_.next(state_));
    while (!ended()) {
      if (!advance_once() && !pass_singular_point())
        curve_.end = CurveEnd::kStuck, finished_ = true;
    }
    return std::move(curve_);
  }

 private:
  void add_point(CurvePoint point) {
    curve_.largest_share = std::max(curve_.largest_share, point.share);
    curve_.points.push_back(std::move(point));
  }

  bool ended() {
    if (finished_) return true;
    const CurvePoint& last = curve_.points.back();
    const auto end = [&](CurveEnd reason) {
      curve_.end = reason;
      return true;
    };
    if (options_.stopped && options_.stopped()) return end(CurveEnd::kStopped);
    if (last.amplitude > options_.largest_amplitude) return end(CurveEnd::kUnbounded);
    if (last.share > goal_.most_share) return end(CurveEnd::kCoarse);
    if (curve_.points.size() > 1 && goal_.returned && goal_.returned(last))
      return end(CurveEnd::kReturned);
    if (goal_.enough && goal_.enough(curve_)) return end(CurveEnd::kDone);
    if (curve_.points.size() >= static_cast<std::size_t>(options_.most_points))
      return end(CurveEnd::kLong);
    return false;
  }

  // More harmonics where the highest or those left out hold too much, fewer where they hold far
  // less. Where more give no motion the curve continues with those that it has.
  void adapt_harmonics() {
    while (equations_.harmonics() < options_.most_harmonics && too_few_harmonics()) {
      const Change change = pause_ > 0 ? Change::kRefused : add_harmonics();
      if (change == Change::kDone) continue;
      if (change == Change::kPostponed) return;
      if (curve_.refused++ == 0) curve_.first_refused = equations_.omega(state_.y);
      pause_ = pause_ > 0 ? pause_ - 1 : kPause;
      return;
    }
    pause_ = 0;
    if (equations_.harmonics() >= options_.harmonics + 2 && too_many_harmonics())
      change_harmonics(equations_.harmonics() - 2);
  }
  enum class Change { kDone, kRefused, kPostponed };
  // Two more, or as many as give a motion.
  Change add_harmonics() {
    const Eigen::Index most = options_.most_harmonics;
    Eigen::Index harmonics = equations_.harmonics();
    Change change = Change::kRefused;
    while (change == Change::kRefused && harmonics < most) {
      harmonics = std::min(harmonics + 2, most);
      change = change_harmonics(harmonics);
    }
    return change;
  }
  bool too_few_harmonics() {
    return last_share(equations_.motion(state_.y)) > options_.harmonic_share ||
           equations_.missing_share(state_.y) > kMissingPart * options_.harmonic_share;
  }
  // Two harmonics fewer would not be too few.
  bool too_many_harmonics() {
    const double most = kFarBelow * options_.harmonic_share;
    const FourierSeries fewer =
        with_harmonics(equations_.motion(state_.y), equations_.harmonics() - 2);
    return last_share(fewer) < most && equations_.last_strain_share(state_.y) < kMissingPart * most;
  }
  Change change_harmonics(Eigen::Index harmonics) {
    const bool held = held_.size() > 0;
    const Eigen::Index before = equations_.harmonics();
    const FourierSeries motion = equations_.motion(state_.y);
    const Eigen::VectorXd along = held ? held_ : state_.tangent;
    const FourierSeries slope = equations_.motion(along);
    const double omega = equations_.omega(state_.y), extra = equations_.extra(state_.y);
    const double omega_slope = equations_.omega(along), extra_slope = equations_.extra(along);
    equations_.set_harmonics(harmonics);
    Eigen::VectorXd y = equations_.unknowns_of(motion, omega, extra);
    Eigen::VectorXd direction = equations_.unknowns_of(slope, omega_slope, extra_slope);
    if (!held) direction.array() *= equations_.weights(y).array().square();
    equations_.refer_to(y);
    Change change = Change::kRefused;
    bool found = solve_on_border(equations_, direction, kCurveTolerance, y).converged;
    if (!found && held && goal_.first) {
      Result<Eigen::VectorXd> again = goal_.first(harmonics);
      found = again && again->size() == direction.size();
      if (found) y = std::move(*again);
    }
    if (found) {
      Result<CurveState> state = curve_state(equations_, std::move(y), direction);
      // Near a fold the curves of both may have turned or not; this is decided behind it.
      const bool same =
          state &&
          (held || equations_.motion_sign(*state) == 0 ||
           (state->sign == state_.sign && state->omega_slope() * state_.omega_slope() > 0.0));
      if (same) {
        state_ = std::move(*state);
        if (held) held_ = direction;
        return Change::kDone;
      }
      if (state) change = Change::kPostponed;
    }
    equations_.set_harmonics(before);
    equations_.refer_to(state_.y);
    return change;
  }

  bool is_near(const CurveState& next) const {
    const double way = (state_.weights.array() * (next.y - state_.y).array()).matrix().norm();
    return way <= kLongestWay * ds_;
  }

  // One accepted step; shortens it until it succeeds. False: even the shortest fails.
  bool advance_once() {
    while (ds_ > kShortestStep) {
      Eigen::VectorXd y;
      const CorrectorReport report = advance(equations_, state_, ds_, false, y);
      if (report.converged) {
        Result<CurveState> next = curve_state(equations_, std::move(y), state_.onwards());
        if (next && is_near(*next) && tangent_cosine(state_, *next) > kLeastCosine &&
            accept(*next, report))
          return true;
      }
      ds_ *= 0.5;
    }
    return false;
  }

  // At a branch point the steps shrink to nothing, since its tangent is not unique. The direction
  // from a point further back leads over it.
  bool pass_singular_point() {
    constexpr double kBack = 0.02, kAhead[] = {0.02, 0.05, 0.01, 0.1, 0.005};
    const auto before =
        std::find_if(curve_.points.rbegin(), curve_.points.rend(), [&](const CurvePoint& point) {
          return curve_.points.back().length - point.length > kBack;
        });
    if (before == curve_.points.rend() || before->harmonics() != equations_.harmonics())
      return false;
    const double extra = equations_.has_free_phase() ? equations_.extra(state_.y) : before->load;
    Eigen::VectorXd way = state_.y - equations_.unknowns_of(before->motion, before->omega, extra);
    way /= (state_.weights.array() * way.array()).matrix().norm();
    const Eigen::VectorXd border = state_.weights.array().square() * way.array();
    for (const double ahead : kAhead) {
      ds_ = ahead;
      Eigen::VectorXd y = state_.y + ahead * way;
      equations_.refer_to(state_.y);
      const CorrectorReport report = solve_on_border(equations_, border, kCurveTolerance, y);
      if (!report.converged) continue;
      Result<CurveState> next = curve_state(equations_, std::move(y), border);
      if (next && is_near(*next) && border.dot(next->tangent) > kLeastCosine &&
          accept(*next, report))
        return true;
    }
    return false;
  }

  // False: the end of the curve in this step was not found.
  bool accept(CurveState& next, const CorrectorReport& report) {
    const bool joins = goal_.ends_at_half_period && meets_half_period(next);
    if (!joins && equations_.has_free_phase() && next.sign != state_.sign && ds_ > kShortestOverGap)
      return false;
    points_.length += ds_;
    if (joins) return join(next);
    CurvePoint point = points_.next(next);
    if (goal_.beyond(point) >= 0.0) {
      if (arrive(point)) return true;
      points_.length -= ds_;
      return false;
    }
    find_events(next, point);
    if (const auto again = point_passed_again(equations_, curve_, state_, next)) {
      curve_.loop_start = *again;
      curve_.end = CurveEnd::kLoop;
      finished_ = true;
    }
    equations_.refer_to(next.y);
    state_ = std::move(next);
    const Eigen::Index before = equations_.harmonics();
    adapt_harmonics();
    if (equations_.harmonics() != before) point = points_.next(state_);
    add_point(std::move(point));
    // The coupling of soft and stiff coordinates makes old factors contract slowly, at steps that
    // Newton's method itself takes easily: factorizations are what limits a step.
    if (report.factorizations <= kFewFactorizations)
      ds_ = std::min(1.5 * ds_, options_.longest_step);
    else if (report.factorizations > kManyFactorizations)
      ds_ *= 0.6;
    return true;
  }

  void find_events(const CurveState& next, const CurvePoint& point) {
    if (goal_.events) events_.find(state_, next, curve_.points.back(), point, curve_.bifurcations);
  }

  // True if the odd harmonics vanish between state_ and `next`.
  bool meets_half_period(const CurveState& next) const {
    constexpr double kNearZero = 0.2;  // of the way, off a straight line through zero
    const Eigen::VectorXd a = odd_harmonics(equations_.motion(state_.y)).reshaped();
    const Eigen::VectorXd b = odd_harmonics(equations_.motion(next.y)).reshaped();
    if (!(a.dot(b) < 0.0)) return false;
    const double part = a.norm() / (a.norm() + b.norm());
    return (a + part * (b - a)).norm() < kNearZero * (b - a).norm();
  }
  // Ends the curve at the even harmonics between state_ and `next`, which nearly solve.
  bool join(const CurveState& next) {
    const FourierSeries a = equations_.motion(state_.y), b = equations_.motion(next.y);
    const double before = odd_harmonics(a).norm(), behind = odd_harmonics(b).norm();
    const double part = before / (before + behind);
    CurvePoint point = curve_.points.back();
    point.motion = a + part * (b - a);
    point.motion -= odd_harmonics(point.motion);
    point.omega += part * (equations_.omega(next.y) - point.omega);
    point.amplitude = points_.amplitude(point.motion, point.load);
    point.length = points_.length;
    add_point(std::move(point));
    curve_.end = CurveEnd::kJoined;
    return finished_ = true;
  }

  // The last point is at the goal itself.
  bool arrive(const CurvePoint& behind) {
    const auto beyond = [&](const Eigen::VectorXd& y) { return goal_.beyond(points_.bare(y)); };
    const Result<Eigen::VectorXd> last =
        find_zero(equations_, state_, ds_, beyond(state_.y), goal_.beyond(behind), beyond);
    if (!last) return false;
    const Result<CurveState> end = curve_state(equations_, *last, state_.onwards());
    if (!end) return false;
    CurvePoint point = points_.next(*end);
    find_events(*end, point);
    add_point(std::move(point));
    return finished_ = true;
  }
  MotionEquations& equations_;
  CurvePoints points_;
  CurveEvents events_;
  const CurveGoal& goal_;
  const CurveOptions& options_;
  double ds_;
  int pause_ = 0;  // so many points until more harmonics are tried again
  CurveState state_;
  // The direction along which the first point stays where it is; empty behind it.
  Eigen::VectorXd held_;
  MotionCurve curve_;
  bool finished_ = false;
};

}  // namespace

Result<MotionCurve> trace_curve(MotionEquations& equations, const VibratingSystem& system,
                                Eigen::VectorXd first, const Eigen::VectorXd& direction,
                                const CurveGoal& goal, bool conservative,
                                const CurveOptions& options) {
  Tracer tracer(equations, system, goal, conservative, options);
  return tracer.trace(std::move(first), direction);
}

}  // namespace tremolo
