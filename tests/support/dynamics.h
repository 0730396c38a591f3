// Helpers for tests of integrators: make one, run it, and an independent reference orbit.
#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <gtest/gtest.h>

#include "runtime/integrator.h"
#include "tests/support/sample_basis.h"

namespace tremolo::testing {

inline Model::Pointer make_model(const StrainModel& strain) {
  Result<Model::Pointer> model = Model::from_data(sample_basis(strain));
  EXPECT_TRUE(model) << (model ? "" : model.error().message);
  return *model;
}

inline std::unique_ptr<Integrator> make(std::string_view name, const Model::Pointer& model,
                                        const IntegratorOptions& options) {
  Result<std::unique_ptr<Integrator>> made = make_integrator(name, model, options);
  EXPECT_TRUE(made) << (made ? "" : made.error().message);
  return std::move(*made);
}

// A strongly nonlinear model: four coordinates of 3 to 40 rad/s. In the state next to it, |q| =
// 0.3, the quartic part is as large as the quadratic; the force moves it as much.
inline StrainModel strong_strain_model(Eigen::Index blocks = 0) {
  return random_strain_model(spread_omega(4, 3.0, 40.0), 0.8, 21, blocks);
}
inline State strong_state() {
  return {Eigen::Vector4d(0.25, -0.15, 0.1, 0.05), Eigen::Vector4d(-0.6, 1.0, 0.7, -1.1)};
}
inline const Eigen::Vector4d kStrongForce(8.0, -20.0, 30.0, 50.0);

// Nine coordinates of 5 to 900 rad/s: bodies that live alone and in a world.
inline constexpr Eigen::Index kCrowdModes = 9;
inline StrainModel crowd_strain_model(double nonlinearity = 0.02) {
  return random_strain_model(spread_omega(kCrowdModes, 5.0, 900.0), nonlinearity, 61);
}
inline Model::Pointer crowd_model(double nonlinearity = 0.02) {
  return make_model(crowd_strain_model(nonlinearity));
}
inline constexpr double kNever = std::numeric_limits<double>::infinity();  // s

// For the maps of single steps on linear oscillators: the step (s), and the rounding error of a few
// dozen operations, relative to the largest number among them.
inline constexpr double kOscillatorStep = 0.01;
inline constexpr double kOscillatorRounding = 1e-13;
inline IntegratorOptions oscillator_options(double alpha = 0.0, double beta = 0.0) {
  IntegratorOptions options{.step = kOscillatorStep, .alpha = alpha, .beta = beta};
  options.tolerance = 1e-13;  // a linear equation is solved by one correction
  return options;
}

// Methods without an implicit half: the step must resolve the highest frequency.
inline bool is_explicit(std::string_view name) {
  return name == "verlet" || name == "verlet4" || name == "explicit-euler" || name == "rk2" ||
         name == "rk4";
}

// Order on a smooth problem, loaded or not; imexv-thesis has 1 where there is damping, ep4 2 where
// the damping depends on q.
inline int order_of(std::string_view name, double beta = 0.0) {
  if (name == "explicit-euler" || name == "implicit-euler") return 1;
  if (name == "ep4" && beta > 0.0) return 2;
  if (name == "verlet4" || name == "rk4" || name == "ep4") return 4;
  return 2;
}

// Three different random values of a load, each as testing::random_vector(r, size, seed + 0..2).
inline void randomize(StepLoad& load, double size, unsigned seed) {
  for (Eigen::VectorXd* f : {&load.start, &load.average, &load.end})
    *f = random_vector(f->size(), size, seed++);
}

// `count` steps from time 0; fails the test where a step does not converge.
inline void run(Integrator& integrator, State& state, const std::vector<Load>& loads, double step,
                int count) {
  StepLoad load = make_step_load(state.q.size());
  for (int k = 0; k < count; ++k) {
    sample_loads(loads, k * step, step, load);
    const StepReport report = integrator.step(state, load);
    ASSERT_TRUE(report.converged) << integrator.name() << " at step " << k << ", residual "
                                  << report.residual;
  }
}

// Classical Runge-Kutta on q' = p, p' = f(t) - D(q) p - grad V(q), with the strain form of V and of
// the damping: has no code in common with the tested method. ratio: of critical damping of every
// coordinate, in addition to alpha and beta.
inline State reference_orbit(const StrainModel& model, State state, double alpha, double beta,
                             const std::function<Eigen::VectorXd(double)>& force, double duration,
                             int steps, double ratio = 0.0) {
  const Eigen::VectorXd rates = alpha + 2.0 * ratio * model.omega.array();
  const auto slope = [&](double t, const State& s) {
    return State{s.p, force(t) - rates.cwiseProduct(s.p) -
                          beta * strain_damping_force(model, s.q, s.p) - strain_force(model, s.q)};
  };
  const auto moved = [](const State& s, const State& d, double h) {
    return State{s.q + h * d.q, s.p + h * d.p};
  };
  const double h = duration / steps;
  for (int k = 0; k < steps; ++k) {
    const double t = k * h;
    const State k1 = slope(t, state);
    const State k2 = slope(t + 0.5 * h, moved(state, k1, 0.5 * h));
    const State k3 = slope(t + 0.5 * h, moved(state, k2, 0.5 * h));
    const State k4 = slope(t + h, moved(state, k3, h));
    state.q += h / 6.0 * (k1.q + 2.0 * k2.q + 2.0 * k3.q + k4.q);
    state.p += h / 6.0 * (k1.p + 2.0 * k2.p + 2.0 * k3.p + k4.p);
  }
  return state;
}

}  // namespace tremolo::testing
