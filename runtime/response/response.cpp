#include "runtime/response/response.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/LU>

#include "common/text.h"
#include "runtime/response/curve_tracer.h"
#include "runtime/response/first_motion.h"
#include "runtime/response/static_state.h"

namespace tremolo {
namespace {

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
  constexpr const char* kNames[] = {"done",    "unbounded", "returned", "stuck", "long",
                                    "stopped", "joined",    "loop",     "coarse"};
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
  const double omega_scale = std::max(request.omega_from, request.omega_to);
  const FirstMotionRequest at_start{system, request.force, *rest, request.omega_from, omega_scale};
  CurveOptions starting = options;
  starting.harmonics =
      std::min(options.most_harmonics, std::max(options.harmonics, harmonics_of(request.force)));
  const Result<FourierSeries> motion = first_motion(at_start, starting);
  if (!motion) return motion.error();
  const double upwards = request.omega_to > request.omega_from ? 1.0 : -1.0;
  ForcedEquations equations(system, request.force, harmonics_of(*motion),
                            vibration_size(*motion, *rest), omega_scale);
  equations.set_rest(*rest);
  Eigen::VectorXd first = equations.unknowns_of(*motion, request.omega_from);
  CurveGoal goal;
  goal.first = [&](Eigen::Index harmonics) -> Result<Eigen::VectorXd> {
    starting.harmonics = starting.most_harmonics = harmonics;
    const Result<FourierSeries> again = first_motion(at_start, starting);
    if (!again) return again.error();
    return equations.unknowns_of(*again, request.omega_from);
  };
  goal.beyond = [&](const CurvePoint& point) {
    return upwards * (point.omega / request.omega_to - 1.0);
  };
  goal.returned = [&](const CurvePoint& point) {
    return upwards * (point.omega / request.omega_from - 1.0) < -1e-9;
  };
  const Eigen::VectorXd direction = upwards * Eigen::VectorXd::Unit(first.size(), first.size() - 1);
  return trace_curve(equations, system, std::move(first), direction, goal, false, options);
}

}  // namespace tremolo
