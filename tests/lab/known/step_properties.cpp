#include "tests/lab/known/step_properties.h"

#include <array>
#include <cmath>
#include <utility>

#include "tests/lab/known/quartic_model.h"
#include "tests/lab/known/spring_chain.h"
#include "tests/lab/work/failure.h"

namespace tremolo::known {
namespace {

IntegratorOptions options_of(double step) {
  IntegratorOptions options{.step = step};
  options.split = {.rule = SplitRule::kCount, .count = 2};
  options.tolerance = 1e-13;
  options.max_iterations = 50;
  options.halvings = 0;  // a step in parts is another map
  return options;
}

Eigen::VectorXd scaled(const State& state, double sigma) {
  Eigen::VectorXd z(2 * state.q.size());
  z << sigma * state.q, state.p / sigma;
  return z;
}

State unscaled(const Eigen::VectorXd& z, double sigma) {
  const Eigen::Index r = z.size() / 2;
  return {z.head(r) / sigma, sigma * z.tail(r)};
}

double middle_sigma(const Model& model) {
  return std::pow(model.lambda()[model.modes() / 2], 0.25);
}

// One step from a reset integrator, which holds nothing of earlier steps.
std::optional<Eigen::VectorXd> map_once(Integrator& integrator, const Eigen::VectorXd& z,
                                        double sigma) {
  State state = unscaled(z, sigma);
  integrator.reset();
  if (!integrator.step(state, make_step_load(state.q.size())).converged) return std::nullopt;
  return scaled(state, sigma);
}

// Classical Runge-Kutta on q' = p, p' = -R(q): has no code in common with the integrators.
State reference_orbit(const Model& model, State state, double duration, int steps) {
  const double h = duration / steps;
  const auto acceleration = [&](const Eigen::VectorXd& q) {
    return Eigen::VectorXd(-potential_force(model, q));
  };
  for (int k = 0; k < steps; ++k) {
    const Eigen::VectorXd a1 = acceleration(state.q);
    const Eigen::VectorXd v2 = state.p + 0.5 * h * a1;
    const Eigen::VectorXd a2 = acceleration(state.q + 0.5 * h * state.p);
    const Eigen::VectorXd v3 = state.p + 0.5 * h * a2;
    const Eigen::VectorXd a3 = acceleration(state.q + 0.5 * h * v2);
    const Eigen::VectorXd v4 = state.p + h * a3;
    const Eigen::VectorXd a4 = acceleration(state.q + h * v3);
    state.q += h / 6.0 * (state.p + 2.0 * v2 + 2.0 * v3 + v4);
    state.p += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
  }
  return state;
}

// Slope of log2(error) over log2(step) for steps that halve.
double fitted_order(const std::vector<double>& errors) {
  const double middle = 0.5 * (static_cast<double>(errors.size()) - 1.0);
  double product = 0.0;
  double square = 0.0;
  for (std::size_t k = 0; k < errors.size(); ++k) {
    const double x = middle - static_cast<double>(k);
    product += x * std::log2(errors[k]);
    square += x * x;
  }
  return product / square;
}

constexpr int kOrderSteps = 32;

void measure_order(const Model::Pointer& model, const State& start, double sigma, double order_step,
                   StepProperties& properties) {
  // 512 steps for each coarsest one: the reference's own error is below 1e-11.
  const State exact = reference_orbit(*model, start, kOrderSteps * order_step, kOrderSteps * 512);
  const Eigen::VectorXd end = scaled(exact, sigma);
  for (int halving = 0; halving < 4; ++halving) {
    const double h = std::ldexp(order_step, -halving);
    const auto integrator = or_fail(make_integrator(properties.method, model, options_of(h)));
    State state = start;
    const StepLoad none = make_step_load(state.q.size());
    for (int k = 0; k < kOrderSteps << halving; ++k)
      if (!integrator->step(state, none).converged) return;
    const Eigen::VectorXd q = state.q;
    Eigen::VectorXd momentum = state.p;
    integrator->synchronized_momentum(state, momentum);
    properties.order_errors.push_back((scaled({q, momentum}, sigma) - end).norm() / end.norm());
  }
  properties.order = fitted_order(properties.order_errors);
}

}  // namespace

std::optional<Promise> promise_of(std::string_view method) {
  static constexpr std::pair<std::string_view, Promise> kPromises[] = {
      {"verlet", {2, true, true, false}},
      {"verlet4", {4, true, true, false}},
      {"midpoint", {2, true, true, false}},
      {"newmark", {2, false, true, false}},
      // The first order is that of the start: p is taken as lagging half a kick, and is not.
      {"imexv-thesis", {1, false, false, false}},
      {"imexv", {2, false, true, false}},
      {"imexv-adaptive", {2, false, false, false}},
      {"imexv-linear", {2, true, true, false}},
      {"imexv-coupled", {2, true, true, false}},
      {"avf", {2, false, true, true}},
      {"ep2", {2, false, true, true}},
      {"ep4", {4, false, false, true}},
      {"explicit-euler", {1, false, false, false}},
      {"implicit-euler", {1, false, false, false}},
      {"rk2", {2, false, false, false}},
      {"rk4", {4, false, false, false}},
  };
  for (const auto& [name, promise] : kPromises)
    if (name == method) return promise;
  return std::nullopt;
}

std::optional<Eigen::MatrixXd> step_jacobian(Integrator& integrator, const State& state,
                                             double sigma) {
  static constexpr std::array kWeights = {4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0};
  const Eigen::VectorXd z = scaled(state, sigma);
  // Truncation grows with the eighth power, rounding falls with the first: about equal here.
  const double step = 0.01 * z.cwiseAbs().maxCoeff();
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(z.size(), z.size());
  for (Eigen::Index column = 0; column < z.size(); ++column)
    for (int distance = 1; distance <= 4; ++distance)
      for (const double side : {1.0, -1.0}) {
        Eigen::VectorXd moved = z;
        moved[column] += side * distance * step;
        const std::optional<Eigen::VectorXd> image = map_once(integrator, moved, sigma);
        if (!image) return std::nullopt;
        jacobian.col(column) += side * kWeights[distance - 1] / step * *image;
      }
  return jacobian;
}

Eigen::MatrixXd verlet_jacobian(const Model& model, const State& state, double h, double sigma) {
  const Eigen::Index r = state.q.size();
  PotentialWorkspace workspace = model.potential().make_workspace();
  Evaluation evaluation = model.potential().make_evaluation();
  const auto kick = [&](const Eigen::VectorXd& q) {
    model.potential().evaluate(q, kWantForce | kWantTangent, workspace, evaluation);
    Eigen::MatrixXd map = Eigen::MatrixXd::Identity(2 * r, 2 * r);
    map.bottomLeftCorner(r, r) = -0.5 * h / (sigma * sigma) * evaluation.tangent;
    return map;
  };
  Eigen::MatrixXd drift = Eigen::MatrixXd::Identity(2 * r, 2 * r);
  drift.topRightCorner(r, r).diagonal().setConstant(h * sigma * sigma);
  const Eigen::MatrixXd first = kick(state.q);
  const Eigen::VectorXd end = state.q + h * (state.p - 0.5 * h * evaluation.force);
  return kick(end) * drift * first;
}

double symplectic_defect(const Eigen::MatrixXd& jacobian) {
  const Eigen::Index r = jacobian.rows() / 2;
  Eigen::MatrixXd omega = Eigen::MatrixXd::Zero(2 * r, 2 * r);
  omega.topRightCorner(r, r).setIdentity();
  omega.bottomLeftCorner(r, r) = -Eigen::MatrixXd::Identity(r, r);
  return (jacobian.transpose() * omega * jacobian - omega).cwiseAbs().maxCoeff();
}

std::optional<double> reversal_error(Integrator& integrator, const State& state, double sigma) {
  const Eigen::VectorXd start = scaled(state, sigma);
  Eigen::VectorXd z = start;
  for (int half = 0; half < 2; ++half) {
    const std::optional<Eigen::VectorXd> image = map_once(integrator, z, sigma);
    if (!image) return std::nullopt;
    z = *image;
    z.tail(z.size() / 2) *= -1.0;
  }
  return (z - start).norm() / start.norm();
}

StepProperties measure_step(std::string_view method, double step, double order_step) {
  const SpringChain chain = spring_chain();
  const auto made = or_fail(make_integrator(method, chain.model, options_of(step)));
  Integrator& integrator = *made;
  const double sigma = middle_sigma(*chain.model);
  const State start = spring_chain_state(chain);

  StepProperties properties;
  properties.method = method;
  if (const auto jacobian = step_jacobian(integrator, start, sigma))
    properties.defect = symplectic_defect(*jacobian);
  properties.reversal = reversal_error(integrator, start, sigma);
  State moved = start;
  integrator.reset();
  if (integrator.step(moved, make_step_load(moved.q.size())).converged) {
    const double before = total_energy(*chain.model, integrator, start);
    const double after = total_energy(*chain.model, integrator, moved);
    properties.energy = std::abs(after - before) / before;
  }
  measure_order(chain.model, start, sigma, order_step, properties);
  return properties;
}

double jacobian_accuracy(double step, double scale) {
  const SpringChain chain = spring_chain();
  const auto integrator = or_fail(make_integrator("verlet", chain.model, options_of(step)));
  const double sigma = middle_sigma(*chain.model);
  const State state = spring_chain_state(chain, scale);
  const auto numeric = step_jacobian(*integrator, state, sigma);
  if (!numeric) throw Failure({ErrorKind::kSolver, "a Verlet step on the spring chain failed"});
  return (*numeric - verlet_jacobian(*chain.model, state, step, sigma)).cwiseAbs().maxCoeff();
}

}  // namespace tremolo::known
