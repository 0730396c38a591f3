// Motion of the unreduced body: energy, order, reversibility, damping, steps taken in parts.
#include <cmath>

#include <gtest/gtest.h>

#include "common/energy.h"
#include "precompute/reference/full/step_equation.h"
#include "precompute/reference/time_integration.h"
#include "tests/support/reference_body.h"

namespace tremolo {
namespace {

using testing::bar_problem;
using testing::ReferenceBody;

// The bar bent by a third of its length and released.
class ReferenceMotion : public ::testing::Test {
 protected:
  void SetUp() override {
    bar_.solver.options.tolerance = 1e-12;
    bent_ = static_solution(bar_.system, bar_.tip_load(15.0)).u;
  }
  Motion start() const { return start_motion(bar_.system, bent_, Vector::Zero(bar_.body.size())); }
  void run(const TimeSettings& settings, int steps, Motion& motion) const {
    const LoadHistory none = [this](double, double) -> Vector {
      return Vector::Zero(bar_.body.size());
    };
    for (int k = 0; k < steps; ++k) advance(bar_.system, settings, none, motion);
  }

  ReferenceBody bar_{bar_problem()};
  Vector bent_;
};

TEST_F(ReferenceMotion, TheAveragedFieldKeepsTheEnergyAtLargeDeflection) {
  EXPECT_GT(bent_.cwiseAbs().maxCoeff(), 0.12);
  Motion motion = start();
  const double energy = motion.total();
  double worst = 0;
  for (int k = 0; k < 300; ++k) {
    run({TimeScheme::kAveragedField, 5e-3, 0, 0}, 1, motion);
    worst = std::max(worst, std::abs(motion.total() - energy));
  }
  EXPECT_EQ(motion.halved_steps, 0);
  // 300 steps of a solve to 1e-12 each; the midpoint rule misses by 1e-3 and more.
  EXPECT_LE(worst, 1e-10 * energy);
  Motion other = start();
  run({TimeScheme::kMidpoint, 5e-3, 0, 0}, 300, other);
  EXPECT_GE(std::abs(other.total() - energy), 1e-4 * energy);
}

TEST_F(ReferenceMotion, BothSchemesAreOfSecondOrder) {
  for (TimeScheme scheme : {TimeScheme::kMidpoint, TimeScheme::kAveragedField})
    for (const double damping : {0.0, 1.0}) {
      const auto end = [&](int steps) {
        Motion motion = start();
        run({scheme, 0.02 / steps, 3.0 * damping, 1e-4 * damping}, steps, motion);
        return motion.u;
      };
      const Vector coarse = end(80), middle = end(160), fine = end(320);
      const double order = std::log2((coarse - middle).norm() / (middle - fine).norm());
      EXPECT_NEAR(order, 2.0, 0.15) << damping;
    }
}

TEST_F(ReferenceMotion, StepsCanBeTakenBack) {
  for (TimeScheme scheme : {TimeScheme::kMidpoint, TimeScheme::kAveragedField}) {
    Motion motion = start();
    run({scheme, 2e-3, 0, 0}, 60, motion);
    EXPECT_GT((motion.u - bent_).norm(), 0.3 * bent_.norm());
    Motion back = start_motion(bar_.system, motion.u, -motion.v);
    run({scheme, 2e-3, 0, 0}, 60, back);
    EXPECT_LE((back.u - bent_).norm(),
              1e-7 * bent_.norm());  // solves of 1e-12, sixty there and back
  }
}

TEST_F(ReferenceMotion, WorkAndLossesBalanceTheEnergy) {
  const Vector load = bar_.tip_load(1.0);
  Motion motion = start();
  const double energy = motion.total();
  const LoadHistory pull = [&](double time, double) -> Vector { return std::cos(9 * time) * load; };
  double last = 0;
  for (int k = 0; k < 100; ++k) {
    advance(bar_.system, {TimeScheme::kAveragedField, 4e-3, 2.0, 1e-3}, pull, motion);
    EXPECT_GE(motion.dissipated, last);
    last = motion.dissipated;
  }
  EXPECT_GT(motion.dissipated, 0.1 * energy);
  EXPECT_NEAR(motion.total(), energy + motion.work - motion.dissipated, 1e-10 * energy);
}

// A mode of small amplitude: mass damping takes exactly e^{-alpha h} of its area in each step.
TEST_F(ReferenceMotion, MassDampingIsExactForALinearMode) {
  const double tiny = 1e-6, alpha = 5.0;
  const Vector shape = static_solution(bar_.system, bar_.tip_load(tiny)).u;
  const auto wronskian = [&](const Motion& a, const Motion& b) {
    return a.u.dot(bar_.system.mass_times(b.v)) - b.u.dot(bar_.system.mass_times(a.v));
  };
  const Vector zero = Vector::Zero(shape.size());
  Motion a = start_motion(bar_.system, shape, zero), b = start_motion(bar_.system, zero, shape);
  const double before = wronskian(a, b);
  const TimeSettings settings{TimeScheme::kAveragedField, 3e-3, alpha, 0};
  run(settings, 40, a);
  run(settings, 40, b);
  EXPECT_NEAR(wronskian(a, b) / before, std::exp(-alpha * 0.12), 1e-5);  // what is not linear
}

TEST_F(ReferenceMotion, AStepThatFailsIsTakenInParts) {
  Motion motion = start();
  const double energy = motion.total();
  bar_.solver.options.max_iterations = 6;
  run({TimeScheme::kAveragedField, 0.02, 0, 0}, 10, motion);
  EXPECT_GT(motion.halved_steps, 0);
  EXPECT_NEAR(motion.time, 0.2, 1e-12);
  EXPECT_NEAR(motion.total(), energy, 1e-9 * energy);
}

TEST_F(ReferenceMotion, AStepThatCannotBeSolvedIsASolverFailure) {
  Motion motion = start();
  bar_.solver.options.max_iterations = 0;
  try {
    run({TimeScheme::kAveragedField, 0.02, 0, 0}, 1, motion);
    FAIL() << "no failure";
  } catch (const Failure& failure) {
    EXPECT_EQ(failure.error().kind, ErrorKind::kSolver);
    EXPECT_NE(failure.error().message.find("did not converge"), std::string::npos);
  }
}

TEST(ReferenceFreeBody, MovesWithoutRigidMotionAndKeepsItsEnergy) {
  Problem problem = testing::box_problem({4, 1, 2}, {0.4, 0.05, 0.1}, {2e5, 0.3, 1000.0});
  problem.free_body = true;
  ReferenceBody bar(problem);
  bar.solver.options.tolerance = 1e-12;
  const Vector load = bar.tip_load(2.0);
  Motion motion =
      start_motion(bar.system, Vector::Zero(bar.body.size()), Vector::Zero(bar.body.size()));
  const LoadHistory push = [&](double time, double) -> Vector {
    return time < 0.05 ? load : Vector::Zero(load.size());
  };
  DriftMeter drift;
  for (int k = 0; k < 150; ++k) {
    drift.observe(motion.total(), motion.work, motion.dissipated, motion.time < 0.05);
    advance(bar.system, {TimeScheme::kAveragedField, 2.5e-3, 0, 0}, push, motion);
  }
  EXPECT_GT(drift.reference(), 0);
  EXPECT_LE(drift.worst(), 1e-9);
  const Vector rigid = bar.body.mass_rigid.transpose() * motion.u;
  EXPECT_LE(rigid.norm(), 1e-10 * std::sqrt(motion.u.dot(bar.system.mass_times(motion.u))));
}

}  // namespace
}  // namespace tremolo
