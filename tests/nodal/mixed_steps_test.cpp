// Anderson's mixing against what is known of it on linear problems.
#include <cmath>

#include <gtest/gtest.h>

#include "runtime/step/implicit_solve.h"

namespace tremolo {
namespace {

using Eigen::VectorXd;

// p(x) = b - A x with A = diag(rates): x <- x + p(x) alone diverges where a rate is above 2.
VectorXd linear_step(const VectorXd& rates, const VectorXd& x) {
  return VectorXd::Ones(rates.size()) - rates.cwiseProduct(x);
}

// |p| after so many steps.
double left_after(const VectorXd& rates, int steps, bool mixing) {
  MixedSteps steps_of(rates.size());
  VectorXd x = VectorXd::Zero(rates.size()), step(rates.size());
  for (int k = 0; k < steps; ++k) {
    const VectorXd p = linear_step(rates, x);
    x += mixing && steps_of.mix(x, p, step) ? step : p;
  }
  return linear_step(rates, x).norm();
}

// As GMRES: so many steps as there are different rates, and one.
TEST(MixedSteps, EndALinearIterationInAsManyStepsAsItHasRates) {
  const VectorXd rates{{0.05, 0.3, 0.8, 1.4, 0.3, 1.4}};
  EXPECT_LE(left_after(rates, 5, true),
            1e-6);  // 1e-10 of the squares is left out, times a condition
  EXPECT_GE(left_after(rates, 5, false), 0.5);
}

TEST(MixedSteps, ConvergeWhereTheStepsAloneDiverge) {
  const VectorXd rates{{0.5, 1.0, 2.5}};
  EXPECT_GE(left_after(rates, 20, false), 100.0);
  EXPECT_LE(left_after(rates, 20, true), 1e-12);
}

TEST(MixedSteps, SayNothingAtFirstAndAfterTheyWereCleared) {
  MixedSteps steps(2);
  VectorXd mixed(2);
  const VectorXd x = VectorXd::Zero(2), p = VectorXd::Ones(2);
  EXPECT_FALSE(steps.mix(x, p, mixed));
  EXPECT_TRUE(steps.mix(p, 0.5 * p, mixed));
  steps.clear();
  EXPECT_FALSE(steps.mix(x, p, mixed));
}

TEST(MixedSteps, StepsThatDoNotChangeOrAreNoNumbersMixNothing) {
  MixedSteps steps(2);
  VectorXd mixed(2);
  const VectorXd x = VectorXd::Zero(2), p = VectorXd::Ones(2);
  EXPECT_FALSE(steps.mix(x, p, mixed));
  EXPECT_FALSE(steps.mix(x, p, mixed));
  EXPECT_FALSE(steps.mix(x, p * std::nan(""), mixed));
}

}  // namespace
}  // namespace tremolo
