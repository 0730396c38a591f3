#include "runtime/response/backbone.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <Eigen/Core>

#include "common/text.h"
#include "runtime/math/dense/decompositions.h"
#include "runtime/response/curve_tracer.h"
#include "runtime/response/half_period.h"
#include "runtime/response/static_state.h"

namespace tremolo {
namespace {

constexpr double kFirstAmplitude = 1e-3;  // of a backbone, relative to its last

// Of the two highest harmonics relative to the share at which harmonics are added: 5 % in all if
// that is not given. An orbit with as much misses its beginning by more than that after a period.
constexpr double kMostShare = 50.0;

constexpr int kMostJoints = 8;  // with backbones of twice the frequency

// A backbone that ends on a loop is followed again so often, each time with steps shorter by this.
constexpr int kFinerAttempts = 2;
constexpr double kFiner = 0.3;

// A mode of small vibration about a state at rest.
struct SmallVibration {
  Eigen::VectorXd shape;  // r, of length 1
  double omega = 0.0;     // rad/s
};

SmallVibration small_vibration(const Potential& potential, const Eigen::VectorXd& rest,
                               Eigen::Index mode) {
  if (rest.isZero(0.0))
    return {Eigen::VectorXd::Unit(rest.size(), mode), std::sqrt(potential.lambda()[mode])};
  PotentialWorkspace workspace = potential.make_workspace(kUseTangent);
  Evaluation at = potential.make_evaluation();
  potential.evaluate(rest, kWantTangent, workspace, at);
  const SymmetricEigen solver = symmetric_eigen(at.tangent);
  return {solver.vectors.col(mode), std::sqrt(solver.values[mode])};
}

Status check(const VibratingSystem& system, Eigen::Index mode, double to_amplitude) {
  if (mode < 0 || mode >= system.size())
    return content_error("mode " + std::to_string(mode + 1) + ": the model has modes 1 to " +
                         std::to_string(system.size()));
  if (!(to_amplitude > 0.0) || !std::isfinite(to_amplitude))
    return content_error("the amplitude must be positive and finite");
  return Success{};
}

// The other frequency that is closest to that of the mode, as a sentence if it is equal to 1e-6.
std::string equal_frequency(const VibratingSystem& system, Eigen::Index mode) {
  const Eigen::VectorXd& lambda = system.potential.lambda();
  for (Eigen::Index i = 0; i < lambda.size(); ++i)
    if (i != mode && std::abs(lambda[i] / lambda[mode] - 1.0) < 2e-6)
      return "; modes " + std::to_string(std::min(i, mode) + 1) + " and " +
             std::to_string(std::max(i, mode) + 1) +
             " have the same frequency, so that the direction of small vibration is not unique";
  return {};
}

Eigen::VectorXd or_zero(const Eigen::VectorXd& vector, Eigen::Index size) {
  return vector.size() > 0 ? vector : Eigen::VectorXd(Eigen::VectorXd::Zero(size));
}

// The mode's coordinate at the first amplitude. Error: kContent.
Result<double> size_of_first(const SmallVibration& mode, double to_amplitude,
                             const CurveOptions& options) {
  FourierSeries unit = FourierSeries::Zero(mode.shape.size(), 3);
  unit.col(cosine_column(1)) = mode.shape;
  const double amplitude = options.amplitude(unit);
  if (!(amplitude > 0.0))
    return content_error("the mode does not move the point whose amplitude is asked");
  return kFirstAmplitude * to_amplitude / amplitude;
}

CurveGoal amplitude_goal(double to_amplitude) {
  CurveGoal goal;
  goal.beyond = [=](const CurvePoint& point) { return point.amplitude / to_amplitude - 1.0; };
  // An internal resonance may lead back to rest.
  goal.returned = [=](const CurvePoint& point) {
    return point.amplitude < 0.5 * kFirstAmplitude * to_amplitude;
  };
  return goal;
}

void append(MotionCurve more, MotionCurve& curve) {
  for (CurvePoint& point : more.points) curve.points.push_back(std::move(point));
  for (Bifurcation& found : more.bifurcations) curve.bifurcations.push_back(std::move(found));
  curve.end = more.end;
  curve.largest_share = std::max(curve.largest_share, more.largest_share);
}

}  // namespace

double mean_energy(const VibratingSystem& system, const FourierSeries& motion, double omega) {
  const Eigen::Index H = harmonics_of(motion);
  // V has 4H harmonics: more samples than that give its exact mean.
  const Eigen::Index samples = 4 * H + 2;
  PotentialWorkspace workspace = system.potential.make_workspace(kUsePoint);
  Evaluation at = system.potential.make_evaluation();
  double sum = 0.0;
  for (Eigen::Index n = 0; n < samples; ++n) {
    const double theta =
        2.0 * 3.14159265358979323846 * static_cast<double>(n) / static_cast<double>(samples);
    const Eigen::VectorXd q = motion * fourier_row(H, theta);
    system.potential.evaluate(q, kWantEnergy, workspace, at);
    sum += at.energy + 0.5 * omega * omega * (motion * fourier_slope_row(H, theta)).squaredNorm();
  }
  return sum / static_cast<double>(samples);
}

HarmonicPart largest_part(const FourierSeries& motion) {
  HarmonicPart part;
  double all = 0.0, largest = 0.0;
  for (Eigen::Index k = 1; k <= harmonics_of(motion); ++k) {
    const auto order = static_cast<double>(k);
    const Eigen::VectorXd energies = order * order *
                                     (motion.col(cosine_column(k)).array().square() +
                                      motion.col(sine_column(k)).array().square());
    all += energies.sum();
    Eigen::Index coordinate = 0;
    const double most = energies.maxCoeff(&coordinate);
    if (k == 1 || most <= largest) continue;
    largest = most;
    part.harmonic = k;
    part.coordinate = coordinate;
  }
  if (all > 0.0) part.share = largest / all;
  return part;
}

namespace {

Result<MotionCurve> follow_backbone(const VibratingSystem& system, const BackboneRequest& request,
                                    const CurveOptions& options) {
  if (Status s = check(system, request.mode, request.to_amplitude); !s) return s.error();
  VibratingSystem undamped = system;
  undamped.damping.setZero();
  undamped.beta = 0.0;
  undamped.strains = nullptr;
  const Eigen::VectorXd constant = or_zero(request.constant, system.size());
  const Result<Eigen::VectorXd> rest = static_state(system.potential, constant);
  if (!rest) return rest.error();
  const SmallVibration mode = small_vibration(system.potential, *rest, request.mode);
  const Result<double> first_size = size_of_first(mode, request.to_amplitude, options);
  if (!first_size) return first_size.error();
  const double size = *first_size;
  FourierSeries start = with_harmonics(*rest, options.harmonics);
  start.col(cosine_column(1)) = size * mode.shape;
  FreeEquations equations(undamped, constant, options.harmonics, size, mode.omega);
  equations.set_rest(*rest);
  Eigen::VectorXd y = equations.unknowns_of(start, mode.omega);
  equations.refer_to(y);
  Eigen::VectorXd direction = Eigen::VectorXd::Zero(y.size());
  direction.segment(system.size(), system.size()) = mode.shape;
  if (!solve_on_border(equations, direction, kCurveTolerance, y).converged)
    return Error{ErrorKind::kSolver, "no free motion of small amplitude was found near mode " +
                                         std::to_string(request.mode + 1) +
                                         equal_frequency(system, request.mode)};
  CurveGoal goal = amplitude_goal(request.to_amplitude);
  goal.ends_at_half_period = true;
  // Who fixes the number of harmonics knows which motion they hold, as in an internal resonance.
  if (options.harmonics < options.most_harmonics)
    goal.most_share = kMostShare * options.harmonic_share;
  Result<MotionCurve> curve =
      trace_curve(equations, undamped, std::move(y), direction, goal, true, options);
  const FreeMotions free{undamped, constant, *rest, size, mode.omega};
  for (int i = 0; curve && curve->end == CurveEnd::kJoined && i < kMostJoints; ++i) {
    std::optional<MotionCurve> more = past_half_period(free, goal, options, *curve);
    if (!more) break;
    append(std::move(*more), *curve);
  }
  return curve;
}

}  // namespace

Result<MotionCurve> backbone_curve(const VibratingSystem& system, const BackboneRequest& request,
                                   const CurveOptions& options) {
  Result<MotionCurve> curve = follow_backbone(system, request, options);
  // A curve does not lead onto a loop: a step has crossed a narrow gap, which shorter ones may not.
  CurveOptions finer = options;
  for (int i = 0; i < kFinerAttempts && curve && curve->end == CurveEnd::kLoop; ++i) {
    finer.longest_step *= kFiner;
    Result<MotionCurve> again = follow_backbone(system, request, finer);
    if (!again || again->end == CurveEnd::kLoop) continue;
    again->longest_step = finer.longest_step;
    return again;
  }
  return curve;
}

Result<MotionCurve> damped_backbone_curve(const VibratingSystem& system,
                                          const DampedBackboneRequest& request,
                                          const CurveOptions& options) {
  // A share of the load that moves the mode less than this acts on it by rounding only.
  constexpr double kLeastShare = 1e-6;
  if (Status s = check(system, request.mode, request.to_amplitude); !s) return s.error();
  if (!system.damped())
    return content_error("a damped backbone needs damping; without it, it is the free one");
  const Eigen::VectorXd constant = or_zero(request.constant, system.size());
  const Result<Eigen::VectorXd> rest = static_state(system.potential, constant);
  if (!rest) return rest.error();
  const SmallVibration mode = small_vibration(system.potential, *rest, request.mode);
  const double along = mode.shape.dot(request.load);
  if (!(std::abs(along) > kLeastShare * request.load.norm()))
    return content_error("the load does not move mode " + std::to_string(request.mode + 1) +
                         "; a damped backbone needs a load that does");
  const Result<double> size = size_of_first(mode, request.to_amplitude, options);
  if (!size) return size.error();
  // The force that keeps the mode alone at this size.
  const double rate = mode.shape.dot(system.damping.cwiseProduct(mode.shape));
  const double factor = *size * rate * mode.omega / along;
  FourierSeries force = with_harmonics(constant, 1);
  force.col(cosine_column(1)) = factor * request.load;
  const Result<FourierSeries> start =
      linear_motion(system, *rest, force, mode.omega, options.harmonics);
  if (!start) return start.error();
  QuadratureEquations equations(system, constant, request.load, options.harmonics, *size,
                                mode.omega);
  equations.set_rest(*rest);
  Eigen::VectorXd y = equations.unknowns_of(*start, mode.omega, factor);
  Eigen::VectorXd direction = equations.unknowns_of(*start, 0.0, 0.0);
  direction.head(system.size()).setZero();
  if (!solve_on_border(equations, direction, kCurveTolerance, y).converged)
    return Error{ErrorKind::kSolver, "no motion in phase resonance was found near mode " +
                                         std::to_string(request.mode + 1) +
                                         equal_frequency(system, request.mode)};
  return trace_curve(equations, system, std::move(y), direction,
                     amplitude_goal(request.to_amplitude), false, options);
}

}  // namespace tremolo
