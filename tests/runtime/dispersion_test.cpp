// The closed forms of the frequencies that methods give a linear mode, against their steps.
#include "runtime/integrators/dispersion.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/dynamics.h"
#include "tests/support/linear_model.h"

namespace tremolo {
namespace {

// The angle by which a linear oscillator rotates in a step, from four of its positions: they obey
// q_{n+1} = T q_n - D q_{n-1} with the trace T and the determinant D of the step.
double measured_angle(std::string_view name, double z, bool linear) {
  const IntegratorOptions options = testing::oscillator_options();
  const Eigen::VectorXd omega = Eigen::VectorXd::Constant(1, z / options.step);
  const Model::Pointer model =
      linear ? testing::linear_model(omega)
             : testing::make_model(testing::random_strain_model(omega, 0.0, 1));
  const auto integrator = testing::make(name, model, options);
  State state{Eigen::VectorXd::Constant(1, 0.3), Eigen::VectorXd::Constant(1, 0.1 * omega[0])};
  std::vector<double> q = {0.3};
  for (int n = 0; n < 5; ++n) {
    testing::run(*integrator, state, {}, options.step, 1);
    q.push_back(state.q[0]);
  }
  // A method that stores a staggered momentum takes the first step otherwise.
  Eigen::Matrix2d lines;
  lines << q[3], -q[2], q[4], -q[3];
  const Eigen::Vector2d found = lines.inverse() * Eigen::Vector2d(q[4], q[5]);
  return std::acos(found[0] / (2.0 * std::sqrt(found[1])));
}

TEST(Dispersion, TheClosedFormIsTheAngleOfTheStep) {
  int checked = 0;
  for (const std::string_view name : integrator_names())
    for (const double z : {0.1, 0.7, 1.3, 1.75, 2.3, 3.0, 3.1, 6.0}) {
      const auto angle = step_angle(name, z, testing::oscillator_options());
      if (!angle) continue;
      // Explicit Runge-Kutta methods rotate by an argument, which an arc cosine knows up to pi.
      if (*angle < 0.0) continue;
      EXPECT_NEAR(measured_angle(name, z, false), *angle, 1e-8) << name << " " << z;
      ++checked;
    }
  EXPECT_GT(checked, 80);
  EXPECT_NEAR(measured_angle("ep4", 2.5, true), 2.5, 1e-8);
  EXPECT_EQ(*step_angle("ep4", 2.5, {}, true), 2.5);
}

// The bell of 3 843 Hz in steps of 8 kHz that is heard at 3 092 Hz.
TEST(Dispersion, Ep4LowersWhatIsNearHalfTheRate) {
  const double h = 1.0 / 8000.0, z = 2.0 * std::numbers::pi * 3843.0 * h;
  EXPECT_NEAR(*step_angle("ep4", z, {}) / (2.0 * std::numbers::pi * h), 3092.0, 2.0);
  EXPECT_EQ(frequency_error("verlet", 2.5, {}), std::numeric_limits<double>::infinity());
  EXPECT_LT(frequency_error("ep2", 2.39, {}), 1e-14);
}

}  // namespace
}  // namespace tremolo
