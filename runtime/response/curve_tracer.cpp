#include "runtime/response/curve_tracer.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

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
// Distance of a multiplier from the unit circle that counts: above the errors of its computation.
constexpr double kOutside = 1e-7, kOutsideConservative = 1e-5;
// So many points take all steps after one whose multipliers are near the unit circle.
constexpr int kPointsNear = 8;

double tangent_cosine(const CurveState& a, const CurveState& b) {
  return (a.weights.array().square() * a.tangent.array() * b.tangent.array()).sum() /
         (a.weights.array() * b.tangent.array()).matrix().norm();
}

class Tracer {
 public:
  Tracer(MotionEquations& equations, const VibratingSystem& system, const CurveGoal& goal,
         bool conservative, const CurveOptions& options)
      : equations_(equations),
        system_(system),
        floquet_(system),
        goal_(goal),
        conservative_(conservative),
        options_(options),
        ds_(std::min(kFirstStep, options.longest_step)) {}

  Result<MotionCurve> trace(Eigen::VectorXd first, const Eigen::VectorXd& direction) {
    Result<CurveState> state = curve_state(equations_, std::move(first), direction);
    if (!state) return state.error();
    state_ = std::move(*state);
    if (!adapt_harmonics()) return Error{ErrorKind::kSolver, "more harmonics give no motion"};
    add_point(next_point_of(state_.y));
    while (!ended()) {
      if (!advance_once()) curve_.end = CurveEnd::kStuck, finished_ = true;
    }
    return std::move(curve_);
  }

 private:
  // The multipliers that decide on stability: without the two at +1 of a free motion.
  Eigen::VectorXcd deciding(const Eigen::VectorXcd& all) const {
    if (!conservative_) return all;
    std::vector<std::complex<double>> kept(all.begin(), all.end());
    for (int i = 0; i < 2; ++i)
      kept.erase(std::min_element(kept.begin(), kept.end(), [](const auto& a, const auto& b) {
        return std::abs(a - 1.0) < std::abs(b - 1.0);
      }));
    return Eigen::Map<Eigen::VectorXcd>(kept.data(), static_cast<Eigen::Index>(kept.size()));
  }
  double circle() const { return 1.0 + (conservative_ ? kOutsideConservative : kOutside); }

  CurvePoint point_of(const Eigen::VectorXd& y) {
    CurvePoint point = measured_point(y);
    if (options_.stability) set_multipliers(point, floquet_steps(point.harmonics()));
    return point;
  }
  CurvePoint measured_point(const Eigen::VectorXd& y) {
    CurvePoint point = bare_point(y);
    point.share = last_share(point.motion);
    point.missing = equations_.missing_share(y);
    point.length = length_;
    return point;
  }
  void set_multipliers(CurvePoint& point, int steps) {
    point.multipliers = floquet_.multipliers(point.motion, point.omega, steps);
    point.unstable = 0;
    for (const auto& multiplier : deciding(point.multipliers))
      if (!(std::abs(multiplier) <= circle())) ++point.unstable;
    point.stable = point.unstable == 0;
  }

  // A point of the curve. Half the steps suffice to see that the multipliers of a motion of few
  // harmonics are far from the unit circle. Otherwise this point and some after it take all steps.
  // Half the steps show the stiffest coordinates as less damped than they are, which only asks for
  // all steps too often.
  CurvePoint next_point_of(const Eigen::VectorXd& y) {
    if (!options_.stability || conservative_) return point_of(y);
    CurvePoint point = measured_point(y);
    const int steps = floquet_steps(point.harmonics());
    if (points_near_circle_ == 0 && few_harmonics(point, steps / 2)) {
      set_multipliers(point, steps / 2);
      if (far_inside(point)) return point;
    }
    set_multipliers(point, steps);
    points_near_circle_ = far_inside(point) ? std::max(points_near_circle_ - 1, 0) : kPointsNear;
    return point;
  }
  // exp(-this) is the largest multiplier of the linear body.
  double least_decay(const CurvePoint& point) const {
    return 0.5 * system_.damping.minCoeff() * 2.0 * std::numbers::pi / point.omega;
  }
  // True if there are four steps to each harmonic that holds enough to excite another mode.
  bool few_harmonics(const CurvePoint& point, int steps) const {
    const Eigen::Index H = point.harmonics(), resolved = std::min<Eigen::Index>(H, steps / 4);
    const double rest = point.motion.rightCols(2 * (H - resolved)).norm();
    return rest < 0.01 * least_decay(point) * point.motion.rightCols(2 * H).norm();
  }
  // True if all multipliers decay by a quarter of the least decay of the linear body, or more.
  bool far_inside(const CurvePoint& point) const {
    return std::abs(point.multipliers[0]) < std::exp(-0.25 * least_decay(point));
  }

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
    if (goal_.returned && goal_.returned(last)) return end(CurveEnd::kReturned);
    if (goal_.enough && goal_.enough(curve_)) return end(CurveEnd::kDone);
    if (curve_.points.size() >= static_cast<std::size_t>(options_.most_points))
      return end(CurveEnd::kLong);
    return false;
  }

  // More harmonics where the highest or those left out hold too much, fewer where they hold far
  // less. False: the motion with more was not found.
  bool adapt_harmonics() {
    while (equations_.harmonics() < options_.most_harmonics && too_few_harmonics())
      if (!change_harmonics(std::min(equations_.harmonics() + 2, options_.most_harmonics)))
        return false;
    if (equations_.harmonics() >= options_.harmonics + 2 && too_many_harmonics())
      change_harmonics(equations_.harmonics() - 2);
    return true;
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
  bool change_harmonics(Eigen::Index harmonics) {
    const Eigen::Index before = equations_.harmonics();
    const FourierSeries motion = equations_.motion(state_.y);
    const FourierSeries slope = equations_.motion(state_.tangent);
    const double omega = equations_.omega(state_.y), extra = equations_.extra(state_.y);
    const double omega_slope = state_.omega_slope(), extra_slope = equations_.extra(state_.tangent);
    equations_.set_harmonics(harmonics);
    Eigen::VectorXd y = equations_.unknowns_of(motion, omega, extra);
    Eigen::VectorXd direction = equations_.unknowns_of(slope, omega_slope, extra_slope);
    direction.array() *= equations_.weights(y).array().square();
    equations_.refer_to(y);
    if (solve_on_border(equations_, direction, kCurveTolerance, y).converged) {
      Result<CurveState> state = curve_state(equations_, std::move(y), direction);
      if (state) {
        state_ = std::move(*state);
        return true;
      }
    }
    equations_.set_harmonics(before);
    equations_.refer_to(state_.y);
    return false;
  }

  // The direction of the curve at state_, for curve_state().
  Eigen::VectorXd onwards() const {
    return state_.weights.array().square() * state_.tangent.array();
  }

  // One accepted step; shortens it until it succeeds. False: even the shortest fails.
  bool advance_once() {
    while (ds_ > kShortestStep) {
      Eigen::VectorXd y;
      const CorrectorReport report = advance(equations_, state_, ds_, false, y);
      if (report.converged) {
        Result<CurveState> next = curve_state(equations_, std::move(y), onwards());
        if (next && tangent_cosine(state_, *next) > kLeastCosine) return accept(*next, report);
      }
      ds_ *= 0.5;
    }
    return false;
  }

  bool accept(CurveState& next, const CorrectorReport& report) {
    length_ += ds_;
    CurvePoint point = next_point_of(next.y);
    if (goal_.ends_at_half_period && meets_half_period(next)) return join(next);
    if (goal_.beyond(point) >= 0.0) return arrive(point);
    find_events(next, point);
    state_ = std::move(next);
    const Eigen::Index before = equations_.harmonics();
    if (!adapt_harmonics()) return add_point(std::move(point)), false;
    if (equations_.harmonics() != before) point = next_point_of(state_.y);
    add_point(std::move(point));
    // The coupling of soft and stiff coordinates makes old factors contract slowly, at steps that
    // Newton's method itself takes easily: factorizations are what limits a step.
    if (report.factorizations <= kFewFactorizations)
      ds_ = std::min(1.5 * ds_, options_.longest_step);
    else if (report.factorizations > kManyFactorizations)
      ds_ *= 0.6;
    return true;
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
    point.amplitude = options_.amplitude(point.motion);
    point.length = length_;
    add_point(std::move(point));
    curve_.end = CurveEnd::kJoined;
    return finished_ = true;
  }

  // The last point is at the goal itself.
  bool arrive(const CurvePoint& behind) {
    const auto beyond = [&](const Eigen::VectorXd& y) { return goal_.beyond(bare_point(y)); };
    const Result<Eigen::VectorXd> last =
        find_zero(equations_, state_, ds_, beyond(state_.y), goal_.beyond(behind), beyond);
    if (!last) return false;
    const Result<CurveState> end = curve_state(equations_, *last, onwards());
    if (!end) return false;
    CurvePoint point = next_point_of(end->y);
    find_events(*end, point);
    add_point(std::move(point));
    return finished_ = true;
  }
  CurvePoint bare_point(const Eigen::VectorXd& y) const {
    CurvePoint point;
    point.omega = equations_.omega(y);
    point.motion = equations_.motion(y);
    point.amplitude = options_.amplitude(point.motion);
    point.load = equations_.load_factor(y);
    return point;
  }

  // Folds and changes of stability between state_ and `next`, whose point is `point`.
  void find_events(const CurveState& next, const CurvePoint& point) {
    const double span = (state_.border.array() * (next.y - state_.y).array()).sum() /
                        state_.border.dot(state_.tangent);
    const bool turned = (next.omega_slope() > 0.0) != (state_.omega_slope() > 0.0);
    const std::size_t known = curve_.bifurcations.size();
    if (turned) {
      const auto slope = [&](const Eigen::VectorXd& y) {
        const Result<CurveState> at = curve_state(equations_, y, onwards());
        return at ? at->omega_slope() : NAN;
      };
      const Result<Eigen::VectorXd> fold =
          find_zero(equations_, state_, span, state_.omega_slope(), next.omega_slope(), slope);
      if (fold) curve_.bifurcations.push_back({BifurcationKind::kFold, point_of(*fold), 1.0});
    }
    if (options_.stability && curve_.points.back().unstable != point.unstable)
      find_crossing(span, point, turned);
    else if (!options_.stability && next.sign != state_.sign)
      curve_.bifurcations.push_back({BifurcationKind::kBranch, point, 1.0});
    std::stable_sort(curve_.bifurcations.begin() + static_cast<std::ptrdiff_t>(known),
                     curve_.bifurcations.end(), [&](const auto& a, const auto& b) {
                       return distance_from_state(a.point) < distance_from_state(b.point);
                     });
    equations_.refer_to(next.y);
  }
  double distance_from_state(const CurvePoint& point) const {
    const Eigen::VectorXd y = equations_.unknowns_of(point.motion, point.omega);
    return state_.border.dot(y - state_.y);
  }

  // The multiplier that leaves or enters the unit circle, and where.
  void find_crossing(double span, const CurvePoint& point, bool turned) {
    const CurvePoint& before = curve_.points.back();
    const Eigen::Index index = std::min(before.unstable, point.unstable);
    const auto outside = [&](const CurvePoint& at) {
      return std::abs(deciding(at.multipliers)[index]) - circle();
    };
    const auto measure = [&](const Eigen::VectorXd& y) { return outside(point_of(y)); };
    const Result<Eigen::VectorXd> found =
        find_zero(equations_, state_, span, outside(before), outside(point), measure);
    if (!found) return;
    CurvePoint at = point_of(*found);
    const std::complex<double> multiplier = deciding(at.multipliers)[index];
    const BifurcationKind kind = kind_of_crossing(multiplier);
    // A fold is where the curve turns.
    if (kind == BifurcationKind::kBranch && turned) return;
    curve_.bifurcations.push_back({kind, std::move(at), multiplier});
  }

  MotionEquations& equations_;
  const VibratingSystem& system_;
  Floquet floquet_;
  const CurveGoal& goal_;
  bool conservative_;
  const CurveOptions& options_;
  double ds_;
  double length_ = 0.0;
  int points_near_circle_ = 1;  // so many points from here on take all steps
  CurveState state_;
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
