#include "runtime/response/response.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/LU>

#include "common/text.h"
#include "runtime/response/curve_tracer.h"
#include "runtime/response/static_state.h"

namespace tremolo {
namespace {

// The motion at one frequency under the growing force, from the linear one on.
Result<Eigen::VectorXd> first_motion(const VibratingSystem& system, const FourierSeries& force,
                                     const Eigen::VectorXd& rest, double omega,
                                     Eigen::Index harmonics, double omega_scale) {
  constexpr double kLeastPart = 1e-3;
  FourierSeries part_of_force = force;
  FourierSeries motion = with_harmonics(rest, harmonics);
  double done = 0.0, part = 1.0;
  Eigen::VectorXd y;
  while (done < 1.0) {
    const double next = std::min(1.0, done + part);
    part_of_force.rightCols(force.cols() - 1) = next * force.rightCols(force.cols() - 1);
    Result<FourierSeries> guess = FourierSeries(motion);
    if (done == 0.0) guess = linear_motion(system, rest, part_of_force, omega, harmonics);
    if (!guess) return guess.error();
    ForcedEquations equations(system, part_of_force, harmonics, vibration_size(*guess, rest),
                              omega_scale);
    equations.set_rest(rest);
    y = equations.unknowns_of(*guess, omega);
    const Eigen::VectorXd border = Eigen::VectorXd::Unit(y.size(), y.size() - 1);
    if (solve_on_border(equations, border, kCurveTolerance, y).converged) {
      motion = equations.motion(y);
      done = next;
      part *= 1.5;
      continue;
    }
    part *= 0.5;
    if (part < kLeastPart)
      return Error{ErrorKind::kSolver, "no periodic motion was found at the first frequency"};
  }
  return y;
}

Status check(const VibratingSystem& system, const ResponseRequest& request,
             const CurveOptions& options) {
  for (const double omega : {request.omega_from, request.omega_to})
    if (!(omega > 0.0) || !std::isfinite(omega))
      return content_error("the frequency of a periodic force must be positive and finite");
  if (request.omega_from == request.omega_to)
    return content_error("the first and the last frequency are the same");
  if (harmonics_of(request.force) > options.most_harmonics)
    return content_error("the force has harmonic " + std::to_string(harmonics_of(request.force)) +
                         ", but the motion has at "
                         "most " +
                         std::to_string(options.most_harmonics));
  if (!request.force.allFinite() || request.force.rows() != system.size())
    return content_error("the force is not finite");
  return Success{};
}

}  // namespace

const char* name_of(CurveEnd end) {
  constexpr const char* kNames[] = {"done", "unbounded", "returned", "stuck",
                                    "long", "stopped",   "joined"};
  return kNames[static_cast<int>(end)];
}

Result<FourierSeries> linear_motion(const VibratingSystem& system, const Eigen::VectorXd& q0,
                                    const FourierSeries& force, double omega,
                                    Eigen::Index harmonics) {
  const Eigen::Index r = system.size();
  PotentialWorkspace workspace = system.potential.make_workspace(kUseTangent);
  Evaluation at = system.potential.make_evaluation();
  system.potential.evaluate(q0, kWantTangent, workspace, at);
  FourierSeries motion = with_harmonics(q0, harmonics);
  for (Eigen::Index k = 1; k <= std::min(harmonics, harmonics_of(force)); ++k) {
    const double speed = static_cast<double>(k) * omega;
    Eigen::MatrixXcd dynamic = at.tangent.cast<std::complex<double>>();
    for (Eigen::Index i = 0; i < r; ++i)
      dynamic(i, i) += std::complex<double>(-speed * speed, speed * system.damping[i]);
    Eigen::VectorXcd right(r);
    // a cos + b sin is the real part of (a - i b) exp(i k theta).
    right.real() = force.col(cosine_column(k));
    right.imag() = -force.col(sine_column(k));
    const Eigen::VectorXcd found = dynamic.partialPivLu().solve(right);
    if (!found.allFinite())
      return Error{ErrorKind::kSolver,
                   "an undamped frequency is met exactly: the motion is unbounded"};
    motion.col(cosine_column(k)) = found.real();
    motion.col(sine_column(k)) = -found.imag();
  }
  return motion;
}

Result<FourierSeries> load_course(std::span<const LoadHarmonic> parts) {
  constexpr LoadHarmonic kSine;
  if (parts.empty()) parts = {&kSine, 1};
  int most = 1;
  for (const LoadHarmonic& part : parts) {
    if (part.number < 1 || part.number > 99)
      return content_error("a harmonic of the load has the number " + std::to_string(part.number) +
                           ": it must be from 1 to 99");
    if (!std::isfinite(part.scale) || !std::isfinite(part.phase))
      return content_error("the scale and the phase of a load's harmonic must be finite");
    most = std::max(most, part.number);
  }
  FourierSeries course = FourierSeries::Zero(1, 2 * most + 1);
  for (const LoadHarmonic& part : parts) {
    course(0, cosine_column(part.number)) += part.scale * std::sin(part.phase);
    course(0, sine_column(part.number)) += part.scale * std::cos(part.phase);
  }
  if (course.isZero(0.0)) return content_error("the harmonics of the load add up to no load");
  return course;
}

Result<MotionCurve> response_curve(const VibratingSystem& system, const ResponseRequest& request,
                                   const CurveOptions& options) {
  if (Status s = check(system, request, options); !s) return s.error();
  const Result<Eigen::VectorXd> rest = static_state(system.potential, request.force.col(0));
  if (!rest) return rest.error();
  Eigen::Index harmonics =
      std::min(options.most_harmonics, std::max(options.harmonics, harmonics_of(request.force)));
  const double omega_scale = std::max(request.omega_from, request.omega_to);
  const auto first_with = [&](Eigen::Index with) {
    return first_motion(system, request.force, *rest, request.omega_from, with, omega_scale);
  };
  Result<Eigen::VectorXd> first = first_with(harmonics);
  // The equations of few harmonics may have no motion there that grows out of the linear one.
  while (!first && first.error().kind == ErrorKind::kSolver && harmonics < options.most_harmonics) {
    harmonics = std::min(harmonics + 2, options.most_harmonics);
    first = first_with(harmonics);
  }
  if (!first) return first.error();
  const double upwards = request.omega_to > request.omega_from ? 1.0 : -1.0;
  const FourierSeries motion =
      first->head(first->size() - 1).reshaped(system.size(), 2 * harmonics + 1);
  ForcedEquations equations(system, request.force, harmonics, vibration_size(motion, *rest),
                            omega_scale);
  equations.set_rest(*rest);
  CurveGoal goal;
  goal.first = first_with;
  goal.beyond = [&](const CurvePoint& point) {
    return upwards * (point.omega / request.omega_to - 1.0);
  };
  goal.returned = [&](const CurvePoint& point) {
    return upwards * (point.omega / request.omega_from - 1.0) < -1e-9;
  };
  const Eigen::VectorXd direction =
      upwards * Eigen::VectorXd::Unit(first->size(), first->size() - 1);
  return trace_curve(equations, system, *first, direction, goal, false, options);
}

}  // namespace tremolo
