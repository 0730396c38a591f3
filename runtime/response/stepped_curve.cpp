#include "runtime/response/stepped_curve.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <utility>

#include "common/processor.h"
#include "runtime/body.h"
#include "runtime/response/orbit.h"

namespace tremolo {
namespace {

constexpr double kSettled = 1e-4;   // of a settled motion, relative
constexpr int kMostPeriods = 1000;  // of one point
constexpr int kMostSteps = 2048;    // a period
constexpr double kTurn = 2.0 * std::numbers::pi;

double length(const Eigen::VectorXd& q, const Eigen::VectorXd& p, double omega) {
  return std::hypot(q.norm(), p.norm() / omega);
}

// A settled motion by time stepping.
struct Settled {
  State state;             // at the start of a period
  double amplitude = 0.0;  // m, over the last period
  int periods = 0;
  bool done = false;  // false: not within kMostPeriods
};

// Three distances at equal times give the largest one by a parabola, where it is between them.
double peak_of(double before, double at, double after) {
  const double bend = before - 2.0 * at + after;
  if (!(at >= before && at >= after && bend < 0.0)) return at;
  return at - 0.125 * (after - before) * (after - before) / bend;
}

Result<Body> body_at(const SteppedLoad& load, double omega, int steps) {
  IntegratorOptions options = load.damping;
  options.step = kTurn / omega / steps;
  Result<Body> body = Body::create(load.model, kDefaultIntegrator, options);
  if (!body) return body;
  const Signal sine{.kind = SignalKind::kSine, .frequency = omega / kTurn};
  const Signal constant{.kind = SignalKind::kConstant};
  if (Status s = body->add_load(Load{sine, load.periodic}); !s) return s.error();
  if (load.constant.isZero(0.0)) return body;
  if (Status s = body->add_load(Load{constant, load.constant}); !s) return s.error();
  return body;
}

// Steps from the start until the rest of the transient is kSettled of the motion.
Result<Settled> settle_at(const SteppedLoad& load, const CurvePoint& point, State start,
                          int steps) {
  Result<Body> body = body_at(load, point.omega, steps);
  if (!body) return body.error();
  if (Status s = body->set_state(start.q, start.p); !s) return s.error();
  const double slowest = std::abs(1.0 - point.multipliers[0]);
  Settled settled;
  settled.state = std::move(start);
  while (!settled.done && settled.periods < kMostPeriods) {
    double before = 0.0, at = 0.0, square = 0.0;
    for (int n = 0; n < steps; ++n) {
      const StepReport report = body->step();
      if (!report.converged)
        return Error{error_kind(report.failure), failure_message(report, body->time())};
      const double sine = std::sin(kTurn * (n + 1) / steps);
      const double now =
          (load.probe_rows * body->state().q + sine * load.probe_periodic + load.probe_constant)
              .squaredNorm();
      square = std::max({square, now, n < 2 ? 0.0 : peak_of(before, at, now)});
      before = at;
      at = now;
    }
    const State& state = body->state();
    const double change = length(state.q - settled.state.q, state.p - settled.state.p, point.omega);
    settled.state = state;
    settled.amplitude = std::sqrt(square);
    ++settled.periods;
    settled.done = change <= kSettled * slowest * length(state.q, state.p, point.omega);
  }
  return settled;
}

// The stable point with the largest amplitude whose transient decays by a twentieth a period or
// faster: next to a fold it hardly decays, and a coarse step has its fold elsewhere. Null: none.
const CurvePoint* largest_steady(const MotionCurve& curve) {
  constexpr double kLeastDecay = 0.05;
  const CurvePoint* largest = nullptr;
  for (const CurvePoint& point : curve.points)
    if (point.stable && std::abs(1.0 - point.multipliers[0]) >= kLeastDecay &&
        (largest == nullptr || point.amplitude > largest->amplitude))
      largest = &point;
  return largest;
}

// The fewest steps a period, of powers of two, with which that point has the amplitude of twice as
// many to kSettled.
Result<int> steps_needed(const SteppedLoad& load, const MotionCurve& curve) {
  const CurvePoint* largest = largest_steady(curve);
  if (largest == nullptr)
    return Error{ErrorKind::kSolver, "the curve has no stable point to step to"};
  int steps = 16;
  Result<Settled> coarse = settle_at(load, *largest, orbit_state(*largest, 0.0), steps);
  while (coarse && steps < kMostSteps) {
    Result<Settled> fine = settle_at(load, *largest, coarse->state, 2 * steps);
    if (!fine) return fine.error();
    if (std::abs(coarse->amplitude - fine->amplitude) <= kSettled * fine->amplitude) break;
    coarse = std::move(fine);
    steps *= 2;
  }
  if (!coarse) return coarse.error();
  return steps;
}

// The stable points in the order of sweeps. At a fold the body falls onto the next stable part. A
// sweep follows this part onwards from the fold's frequency; another one follows it back to its
// start.
struct SweepPoint {
  const CurvePoint* point;
  int from;  // number of the point whose settled state is the start; -1: the body at rest
};

void add_part(const std::vector<const CurvePoint*>& part, double direction,
              std::vector<SweepPoint>& order) {
  if (part.empty()) return;
  const int before = static_cast<int>(order.size()) - 1;
  auto beyond = part.begin();
  if (before >= 0) {
    const double fold = order.back().point->omega;
    beyond = std::find_if(part.begin(), part.end(), [&](const CurvePoint* point) {
      return direction * (point->omega - fold) >= 0.0;
    });
  }
  const auto add = [&](const CurvePoint* point, int from) {
    order.push_back({point, from});
    return static_cast<int>(order.size()) - 1;
  };
  int from = before;
  for (auto it = beyond; it != part.end(); ++it) from = add(*it, from);
  from = beyond == part.end() ? before : before + 1;
  for (auto it = beyond; it != part.begin();) from = add(*--it, from);
}

std::vector<SweepPoint> sweep_order(const MotionCurve& curve, double direction) {
  std::vector<SweepPoint> order;
  std::vector<const CurvePoint*> part;
  for (const CurvePoint& point : curve.points) {
    if (point.stable) part.push_back(&point);
    if (point.stable && &point != &curve.points.back()) continue;
    add_part(part, direction, order);
    part.clear();
  }
  return order;
}

}  // namespace

Result<SteppedCurve> step_curve(const SteppedLoad& load, const MotionCurve& curve,
                                double direction) {
  constexpr double kSame = 0.02;  // of the amplitude: more is another motion
  const Result<int> steps = steps_needed(load, curve);
  if (!steps) return steps.error();
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(load.periodic.size());
  std::vector<State> states;
  SteppedCurve stepped;
  stepped.steps = *steps;
  const double before = processor_time();
  for (const SweepPoint& at : sweep_order(curve, direction)) {
    const State start = at.from < 0 ? State{zero, zero} : states[static_cast<std::size_t>(at.from)];
    const Result<Settled> settled = settle_at(load, *at.point, start, *steps);
    if (!settled) return settled.error();
    states.push_back(settled->state);
    const double error = std::abs(settled->amplitude / at.point->amplitude - 1.0);
    ++stepped.points;
    stepped.periods += settled->periods;
    if (!settled->done || error > kSame)
      ++stepped.elsewhere;
    else
      stepped.difference = std::max(stepped.difference, error);
  }
  stepped.seconds = processor_time() - before;
  return stepped;
}

}  // namespace tremolo
