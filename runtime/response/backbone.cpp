#include "runtime/response/backbone.h"

#include <cmath>
#include <utility>

#include <Eigen/Eigenvalues>

#include "common/text.h"
#include "runtime/response/curve_tracer.h"
#include "runtime/response/static_state.h"

namespace tremolo {
namespace {

constexpr double kFirstAmplitude = 1e-3;  // of a backbone, relative to its last

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
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(at.tangent);
  return {solver.eigenvectors().col(mode), std::sqrt(solver.eigenvalues()[mode])};
}

Status check(const VibratingSystem& system, const BackboneRequest& request) {
  if (request.mode < 0 || request.mode >= system.size())
    return content_error("mode " + std::to_string(request.mode + 1) +
                         ": the model has modes 1 to " + std::to_string(system.size()));
  if (!(request.to_amplitude > 0.0) || !std::isfinite(request.to_amplitude))
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

Result<MotionCurve> backbone_curve(const VibratingSystem& system, const BackboneRequest& request,
                                   const CurveOptions& options) {
  if (Status s = check(system, request); !s) return s.error();
  VibratingSystem undamped = system;
  undamped.damping.setZero();
  undamped.beta = 0.0;
  undamped.strains = nullptr;
  const Eigen::VectorXd constant = request.constant.size() > 0
                                       ? request.constant
                                       : Eigen::VectorXd(Eigen::VectorXd::Zero(system.size()));
  const Result<Eigen::VectorXd> rest = static_state(system.potential, constant);
  if (!rest) return rest.error();
  const SmallVibration mode = small_vibration(system.potential, *rest, request.mode);
  FourierSeries start = with_harmonics(*rest, options.harmonics);
  start.col(0).setZero();
  start.col(cosine_column(1)) = mode.shape;
  const double unit = options.amplitude(start);
  if (!(unit > 0.0))
    return content_error("the mode does not move the point whose amplitude is asked");
  const double size = kFirstAmplitude * request.to_amplitude / unit;
  start.col(cosine_column(1)) *= size;
  start.col(0) = *rest;
  FreeEquations equations(undamped, constant, options.harmonics, size, mode.omega);
  Eigen::VectorXd y = equations.unknowns_of(start, mode.omega);
  equations.refer_to(y);
  Eigen::VectorXd direction = Eigen::VectorXd::Zero(y.size());
  direction.segment(system.size(), system.size()) = mode.shape;
  if (!solve_on_border(equations, direction, kCurveTolerance, y).converged)
    return Error{ErrorKind::kSolver, "no free motion of small amplitude was found near mode " +
                                         std::to_string(request.mode + 1) +
                                         equal_frequency(system, request.mode)};
  CurveGoal goal;
  goal.beyond = [&](const CurvePoint& point) {
    return point.amplitude / request.to_amplitude - 1.0;
  };
  // An internal resonance may lead back to rest.
  goal.returned = [&](const CurvePoint& point) {
    return point.amplitude < 0.5 * kFirstAmplitude * request.to_amplitude;
  };
  return trace_curve(equations, undamped, std::move(y), direction, goal, true, options);
}

}  // namespace tremolo
