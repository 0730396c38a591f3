#include "runtime/response/curve_tracer.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "runtime/response/closed_loop.h"

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
// Longer steps of free motions do not pass a change of the determinant's sign, where they may cross
// from one curve to another.
constexpr double kShortestOverGap = 1e-3;
// So many points take all steps after one whose multipliers are near the unit circle.
constexpr int kPointsNear = 8;
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
    held_ = direction;
    adapt_harmonics();
    held_.resize(0);
    add_point(next_point_of(state_));
    while (!ended()) {
      if (!advance_once() && !pass_singular_point())
        curve_.end = CurveEnd::kStuck, finished_ = true;
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
    if (options_.stability) set_multipliers(point, floquet_steps(point.harmonics()), 0);
    return point;
  }
  CurvePoint measured_point(const Eigen::VectorXd& y) {
    CurvePoint point = bare_point(y);
    point.share = last_share(point.motion);
    point.missing = equations_.missing_share(y);
    point.length = length_;
    return point;
  }
  // sign: MotionEquations::motion_sign at the point, or 0. The multipliers are those of the whole
  // linear equation about a motion of few harmonics, so that one passes +1 slightly off the point
  // at which the equations of few harmonics turn. The equations decide, since the curve is theirs:
  // the real multiplier nearest to +1 counts on the side that they say.
  void set_multipliers(CurvePoint& point, int steps, int sign) {
    point.multipliers = floquet_.multipliers(point.motion, point.omega, steps);
    point.unstable = outside(deciding(point.multipliers));
    if (sign != 0 && (above_one(point.multipliers) % 2 != 0) != (sign < 0)) {
      const Eigen::Index nearest = nearest_to_one(point.multipliers);
      point.unstable += nearest >= 0 && is_outside(point.multipliers[nearest]) ? -1 : 1;
    }
    point.stable = point.unstable == 0;
  }
  bool is_outside(std::complex<double> multiplier) const {
    return !(std::abs(multiplier) <= circle());
  }
  int outside(const Eigen::VectorXcd& multipliers) const {
    return static_cast<int>(std::count_if(multipliers.begin(), multipliers.end(),
                                          [&](const auto& m) { return is_outside(m); }));
  }
  // The real multipliers above 1.
  int above_one(const Eigen::VectorXcd& multipliers) const {
    return static_cast<int>(std::count_if(
        multipliers.begin(), multipliers.end(),
        [&](const auto& m) { return m.imag() == 0.0 && m.real() > 0.0 && is_outside(m); }));
  }
  // Of the real ones; -1 if there is none.
  static Eigen::Index nearest_to_one(const Eigen::VectorXcd& multipliers) {
    Eigen::Index nearest = -1;
    for (Eigen::Index i = 0; i < multipliers.size(); ++i)
      if (multipliers[i].imag() == 0.0 &&
          (nearest < 0 || std::abs(multipliers[i] - 1.0) < std::abs(multipliers[nearest] - 1.0)))
        nearest = i;
    return nearest;
  }

  // A point of the curve. Half the steps suffice to see that the multipliers of a motion of few
  // harmonics are far from the unit circle. Otherwise this point and some after it take all steps.
  // Half the steps show the stiffest coordinates as less damped than they are, which only asks for
  // all steps too often.
  CurvePoint next_point_of(const CurveState& state) {
    if (!options_.stability || conservative_) return point_of(state.y);
    CurvePoint point = measured_point(state.y);
    const int steps = floquet_steps(point.harmonics()), sign = equations_.motion_sign(state);
    if (sign >= 0 && points_near_circle_ == 0 && few_harmonics(point, steps / 2)) {
      set_multipliers(point, steps / 2, sign);
      if (far_inside(point)) return point;
    }
    set_multipliers(point, steps, sign);
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

  // The direction of the curve at state_, for curve_state().
  Eigen::VectorXd onwards() const {
    return state_.weights.array().square() * state_.tangent.array();
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
        Result<CurveState> next = curve_state(equations_, std::move(y), onwards());
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
    length_ += ds_;
    if (joins) return join(next);
    CurvePoint point = next_point_of(next);
    if (goal_.beyond(point) >= 0.0) {
      if (arrive(point)) return true;
      length_ -= ds_;
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
    if (equations_.harmonics() != before) point = next_point_of(state_);
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
    point.amplitude = amplitude(point.motion, point.load);
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
    CurvePoint point = next_point_of(*end);
    find_events(*end, point);
    add_point(std::move(point));
    return finished_ = true;
  }
  CurvePoint bare_point(const Eigen::VectorXd& y) const {
    CurvePoint point;
    point.omega = equations_.omega(y);
    point.motion = equations_.motion(y);
    point.load = equations_.load_factor(y);
    point.amplitude = amplitude(point.motion, point.load);
    return point;
  }
  double amplitude(const FourierSeries& motion, double load) const {
    return options_.loaded_amplitude ? options_.loaded_amplitude(motion, load)
                                     : options_.amplitude(motion);
  }

  // Folds and changes of stability between state_ and `next`, whose point is `point`.
  void find_events(const CurveState& next, const CurvePoint& point) {
    if (!goal_.events) return;
    const double span = (state_.border.array() * (next.y - state_.y).array()).sum() /
                        state_.border.dot(state_.tangent);
    const bool turned = (next.omega_slope() > 0.0) != (state_.omega_slope() > 0.0);
    const bool crossed = next.sign != state_.sign;
    const bool forced = equations_.motion_sign(next) != 0;
    const std::size_t known = curve_.bifurcations.size();
    if (turned) find_fold(span, next);
    // With stability the multipliers name the branch points of free motions.
    if (crossed && (forced || !options_.stability))
      curve_.bifurcations.push_back(find_branch(span, next));
    if (options_.stability) find_crossing(span, point, turned, forced && turned != crossed, forced);
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

  // At a singular point in between nothing finer than the next point is found.
  void add_event(BifurcationKind kind, const Result<Eigen::VectorXd>& found,
                 const CurveState& next) {
    curve_.bifurcations.push_back({kind, point_of(found ? *found : next.y), 1.0});
  }
  void find_fold(double span, const CurveState& next) {
    const auto slope = [&](const Eigen::VectorXd& y) {
      const Result<CurveState> at = curve_state(equations_, y, onwards());
      return at ? at->omega_slope() : NAN;
    };
    add_event(BifurcationKind::kFold,
              find_zero(equations_, state_, span, state_.omega_slope(), next.omega_slope(), slope),
              next);
  }
  // The least singular value of a state's matrix, with the sign of its determinant.
  static double signed_least(const CurveState& at) {
    Eigen::VectorXd left = Eigen::VectorXd::Ones(at.y.size()).normalized();
    double inverse = 0.0;
    for (int i = 0; i < 3; ++i) {
      left = at.factor.solve_transposed(at.factor.solve(left).normalized());
      inverse = left.norm();
      left /= inverse;
    }
    return at.sign / inverse;
  }
  // Where the bordered matrix is singular. If its determinant jumps from one sign to the other, the
  // step has left the curve for another one across a narrow gap, and the point is that of the jump.
  Bifurcation find_branch(double span, const CurveState& next) {
    constexpr double kSingular = 1e-3;  // relative to the values at the ends
    const double before = signed_least(state_), behind = signed_least(next);
    const double scale = std::min(std::abs(before), std::abs(behind));
    double newest = NAN;
    const auto least = [&](const Eigen::VectorXd& y) {
      const Result<CurveState> at = curve_state(equations_, y, onwards());
      return newest = at ? signed_least(*at) / scale : NAN;
    };
    const Result<Eigen::VectorXd> found =
        find_zero(equations_, state_, span, before / scale, behind / scale, least);
    const bool singular = found && std::abs(newest) < kSingular;
    CurvePoint at = point_of(singular ? *found : point_of_jump(span, next));
    return {BifurcationKind::kBranch, std::move(at), 1.0, !singular};
  }
  // By halves of the step, on the far side of the jump.
  Eigen::VectorXd point_of_jump(double span, const CurveState& next) {
    constexpr double kNearEnough = 1e-6;  // of the step
    double a = 0.0, b = span;
    Eigen::VectorXd far = next.y, y;
    while (std::abs(b - a) > kNearEnough * std::abs(span)) {
      bool found = false;
      // At a singular point in between nothing is found; next to it there is.
      for (const double part : {0.5, 0.3, 0.7, 0.1, 0.9}) {
        const double at = a + part * (b - a);
        if (!advance(equations_, state_, at, true, y).converged) continue;
        const Result<CurveState> state = curve_state(equations_, y, onwards());
        if (!state) continue;
        found = true;
        if (state->sign == next.sign)
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
  void find_crossing(double span, const CurvePoint& point, bool turned, bool explained,
                     bool forced) {
    const CurvePoint& before = curve_.points.back();
    const auto one_sided = [&](const CurvePoint& at) {
      return outside(deciding(at.multipliers)) != at.unstable;
    };
    const bool without_nearest = explained || one_sided(before) || one_sided(point);
    const auto counted = [&](const CurvePoint& at) {
      Eigen::VectorXcd list = deciding(at.multipliers);
      const Eigen::Index nearest = without_nearest ? nearest_to_one(list) : -1;
      if (nearest < 0) return list;
      list.segment(nearest, list.size() - nearest - 1) =
          list.tail(list.size() - nearest - 1).eval();
      return Eigen::VectorXcd(list.head(list.size() - 1));
    };
    const Eigen::VectorXcd first = counted(before), last = counted(point);
    const int change = outside(last) - outside(first);
    if (change == 0 || first.size() != last.size()) return;
    const Eigen::Index index = std::min(outside(first), outside(last));
    const auto distance = [&](std::complex<double> m) { return std::abs(m) - circle(); };
    const auto measure = [&](const Eigen::VectorXd& y) {
      const Eigen::VectorXcd list = counted(point_of(y));
      return index < list.size() ? distance(list[index]) : NAN;
    };
    const Result<Eigen::VectorXd> found =
        find_zero(equations_, state_, span, distance(first[index]), distance(last[index]), measure);
    if (!found) return;
    CurvePoint at = point_of(*found);
    const std::complex<double> multiplier = counted(at)[index];
    const BifurcationKind kind = kind_of_crossing(multiplier);
    // A fold is where the curve turns, a branch point where the equations are singular; two
    // multipliers at once leave their determinant's sign as it is.
    if (kind == BifurcationKind::kBranch && (turned || (forced && change % 2 != 0))) return;
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
  int pause_ = 0;               // so many points until more harmonics are tried again
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
