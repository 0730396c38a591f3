#include "tests/lab/known/pendulum.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/lab/known/quartic_model.h"
#include "tests/lab/work/failure.h"

namespace tremolo::known {
namespace {

// The length at which the bar pulls with `force`, m/s^2: (k/2)(l^2/L^2 - 1) l = force.
double stretched_length(const Pendulum& pendulum, double force) {
  const double k = pendulum.stiffness;
  const double square = pendulum.length * pendulum.length;
  double l = pendulum.length;
  for (int i = 0; i < 50; ++i)  // Newton on a convex function, from below: one overshoot, then down
    l -= (0.5 * k * (l * l / square - 1.0) * l - force) / (0.5 * k * (3.0 * l * l / square - 1.0));
  return l;
}

}  // namespace

double hanging_length(const Pendulum& pendulum) {
  return stretched_length(pendulum, pendulum.gravity);
}

Model::Pointer pendulum_model(const Pendulum& pendulum) {
  const double l = hanging_length(pendulum);
  const double k = pendulum.stiffness;
  const double square = pendulum.length * pendulum.length;
  const double swing = pendulum.gravity / l;
  BasisData data = quadratic_basis(Eigen::Vector2d(swing, swing + k * l * l / square));
  // With s = (a^2 + b^2 - 2 l b)/L^2 the strain has grown by s/2; V = (k L^2/8)(2 e s + s^2) + g b.
  const double cubic = -0.5 * k * l / square;
  add_monomial(data, cubic, 0, 0, 1);
  add_monomial(data, cubic, 1, 1, 1);
  const double quartic = k / (8.0 * square);
  add_monomial(data, quartic, 0, 0, 0, 0);
  add_monomial(data, 2.0 * quartic, 0, 0, 1, 1);
  add_monomial(data, quartic, 1, 1, 1, 1);
  return or_fail(Model::from_data(data));
}

Eigen::Vector2d pendulum_position(const Pendulum& pendulum, const Eigen::VectorXd& q) {
  return {q[0], q[1] - hanging_length(pendulum)};
}

State pendulum_start(const Pendulum& pendulum) {
  const double length = stretched_length(pendulum, pendulum.gravity * std::cos(pendulum.angle));
  return {Eigen::Vector2d(length * std::sin(pendulum.angle),
                          hanging_length(pendulum) - length * std::cos(pendulum.angle)),
          Eigen::Vector2d::Zero()};
}

double pendulum_potential(const Pendulum& pendulum, const Eigen::Vector2d& x) {
  const double square = pendulum.length * pendulum.length;
  const auto value = [&](const Eigen::Vector2d& at) {
    const double strain = at.squaredNorm() / square - 1.0;
    return 0.125 * pendulum.stiffness * square * strain * strain + pendulum.gravity * at.y();
  };
  return value(x) - value({0.0, -hanging_length(pendulum)});
}

PendulumRun run_pendulum(const Pendulum& pendulum, std::string_view method, double step,
                         double duration, double swings) {
  const Model::Pointer model = pendulum_model(pendulum);
  IntegratorOptions options{.step = step};
  options.split = {.rule = SplitRule::kCount, .count = 1};
  options.tolerance = 1e-12;
  const std::unique_ptr<Integrator> integrator = or_fail(make_integrator(method, model, options));
  State state = pendulum_start(pendulum);
  const StepLoad none = make_step_load(2);
  const double bound = 10.0 * total_energy(*model, *integrator, state);
  PendulumRun run;
  run.method = method;
  run.step = step;
  for (long k = 0; k <= std::lround(duration / step); ++k) {
    run.reached = static_cast<double>(k) * step;
    const Eigen::Vector2d at = pendulum_position(pendulum, state.q);
    run.t.push_back(run.reached);
    run.angle.push_back(std::atan2(at.x(), -at.y()));
    run.x.push_back(at.x());
    run.y.push_back(at.y());
    if (!(total_energy(*model, *integrator, state) <= bound)) {
      run.failure = "energy bound left";
      break;
    }
    if (!integrator->step(state, none).converged) {
      run.failure = "solver gave up";
      break;
    }
  }
  // The period of small swings; that of large ones is some per cent longer, which does not matter.
  const double window =
      swings * 2.0 * std::numbers::pi * std::sqrt(hanging_length(pendulum) / pendulum.gravity);
  for (std::size_t k = 0; k < run.t.size(); ++k) {
    const double size = std::abs(run.angle[k]);
    if (run.t[k] <= window) run.first = std::max(run.first, size);
    if (run.t[k] >= run.reached - window) run.last = std::max(run.last, size);
  }
  return run;
}

}  // namespace tremolo::known
