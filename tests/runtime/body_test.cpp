#include "runtime/body.h"

#include <cmath>

#include <gtest/gtest.h>

#include "common/energy.h"
#include "tests/support/dynamics.h"

namespace tremolo {
namespace {

testing::StrainModel body_strain_model(double nonlinearity) {
  return testing::random_strain_model(testing::spread_omega(5, 5.0, 900.0), nonlinearity, 41);
}

Body make_body(std::string_view integrator, double nonlinearity = 0.4,
               IntegratorOptions options = {}) {
  options.tolerance = 1e-12;
  Result<Body> body =
      Body::create(testing::make_model(body_strain_model(nonlinearity)), integrator, options);
  EXPECT_TRUE(body);
  return std::move(*body);
}

void advance(Body& body, int count) {
  for (int k = 0; k < count; ++k) ASSERT_TRUE(body.step().converged);
}

TEST(Body, StartsAtRestInTheRestShape) {
  const Body body = make_body("imexv");
  EXPECT_EQ(body.time(), 0.0);
  EXPECT_EQ(body.energy().total(), 0.0);
  std::vector<double> positions(15);
  ASSERT_TRUE(body.surface_positions(positions));
  for (std::size_t v = 0; v < 5; ++v)
    for (std::size_t axis = 0; axis < 3; ++axis)
      EXPECT_EQ(positions[3 * v + axis], body.model().surface().rest[v][axis]);
}

TEST(Body, TimeIsTheNumberOfStepsTimesTheStep) {
  Body body = make_body("verlet", 0.4, {.step = 1e-3});
  advance(body, 3000);
  EXPECT_EQ(body.time(), 3000 * 1e-3);  // not a sum of 3000 roundings
}

TEST(Body, PositionsAreTheRestShapePlusDisplacements) {
  Body body = make_body("imexv");
  const Eigen::VectorXd q = testing::random_vector(5, 0.1, 1);
  ASSERT_TRUE(body.set_state(q, Eigen::VectorXd::Zero(5)));
  std::vector<double> positions(15);
  std::vector<float> rounded(15);
  ASSERT_TRUE(body.surface_positions(positions));
  ASSERT_TRUE(body.surface(rounded));
  for (std::size_t v = 0; v < 5; ++v) {
    const VertexId id = body.model().surface().vertex_ids[v];
    const Eigen::Vector3d expected = body.model().surface().rest[v] + *body.displacement(id);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(positions[3 * v + axis], expected[axis], 1e-15);
      // Five products summed in float, of numbers below 1.
      EXPECT_NEAR(rounded[3 * v + axis], positions[3 * v + axis], 1e-6);
    }
  }
  EXPECT_TRUE(body.displacement(0)->isZero()) << "vertex 0 is fixed";
  EXPECT_FALSE(body.displacement(1)->isZero()) << "vertex 1 is inside";
}

TEST(Body, BufferOfTheWrongLengthIsRefused) {
  const Body body = make_body("imexv");
  std::vector<double> positions(14);
  EXPECT_EQ(body.surface_positions(positions).error().kind, ErrorKind::kUsage);
}

TEST(Body, AppliedForceEqualsAPulseOfTheSameSteps) {
  Body pushed = make_body("imexv");
  Body loaded = make_body("imexv");
  const Eigen::Vector3d force(1.0, -2.0, 0.5);
  ASSERT_TRUE(pushed.apply_force(5, force, 4));
  const Signal pulse{.kind = SignalKind::kSquare, .duration = 4 * loaded.options().step};
  ASSERT_TRUE(loaded.add_load(pulse, 5, force));
  for (int k = 0; k < 10; ++k) {
    EXPECT_EQ(pushed.load_to_come(), k < 4) << k;
    EXPECT_EQ(loaded.load_to_come(), k < 4) << k;
    advance(pushed, 1);
    advance(loaded, 1);
    EXPECT_EQ(pushed.state().q, loaded.state().q) << k;
  }
}

TEST(Body, AppliedForcesAddUp) {
  Body twice = make_body("imexv");
  Body once = make_body("imexv");
  ASSERT_TRUE(twice.apply_force(5, {1.0, 0.0, 0.0}));
  ASSERT_TRUE(twice.apply_force(5, {1.0, 0.0, 0.0}));
  ASSERT_TRUE(once.apply_force(5, {2.0, 0.0, 0.0}));
  advance(twice, 5);
  advance(once, 5);
  EXPECT_LE((twice.state().q - once.state().q).norm(), 1e-14 * once.state().q.norm());
}

TEST(Body, DefaultLoadIsTheModelsTimesTheScale) {
  Body by_default = make_body("imexv");
  Body by_hand = make_body("imexv");
  const Signal impulse{.kind = SignalKind::kImpulse};
  ASSERT_TRUE(by_default.add_default_load(impulse, 3.0));
  ASSERT_TRUE(by_hand.add_load(impulse, 3, {0.0, 0.0, -6.0}));
  advance(by_default, 5);
  advance(by_hand, 5);
  EXPECT_EQ(by_default.state().q, by_hand.state().q);
  by_default.clear_loads();
  EXPECT_FALSE(by_default.load_to_come());
}

TEST(Body, ModelWithoutADefaultLoadSaysSo) {
  BasisData data = testing::sample_basis(body_strain_model(0.1));
  data.load = {};
  Result<Body> body = Body::create(*Model::from_data(data), "imexv", {});
  EXPECT_EQ(body->add_default_load({.kind = SignalKind::kImpulse}).error().kind, ErrorKind::kUsage);
}

TEST(Body, WorkAndDissipationBalanceTheEnergyOfTheMidpointRuleExactly) {
  // For a linear model midpoint keeps dH = f.d - d.D d/h to rounding.
  Body body = make_body("midpoint", 0.0, {.step = 3e-3, .alpha = 2.0, .beta = 1e-4});
  ASSERT_TRUE(body.add_load({.kind = SignalKind::kSquare, .duration = 0.1}, 5, {3.0, 1.0, -2.0}));
  DriftMeter drift;
  drift.observe(0.0, 0.0, 0.0, true);
  for (int k = 0; k < 200; ++k) {
    advance(body, 1);
    drift.observe(body.energy().total(), body.sums().work, body.sums().dissipated,
                  body.load_to_come());
  }
  EXPECT_GT(body.sums().dissipated, 0.1 * body.sums().work);
  EXPECT_LE(drift.worst(), 1e-11);  // rounding of 200 steps
}

// |dH - work + dissipation| / max H after a damped, loaded run of half a second.
double imbalance(std::string_view name, double step) {
  Body body = make_body(name, 0.3, {.step = step, .alpha = 1.0, .beta = 1e-5});
  EXPECT_TRUE(body.add_load({.kind = SignalKind::kSine, .frequency = 2.0}, 5, {3.0, 1.0, -2.0}));
  DriftMeter drift;
  for (long k = std::lround(0.5 / step); k > 0; --k) {
    advance(body, 1);
    drift.observe(body.energy().total(), body.sums().work, body.sums().dissipated,
                  body.load_to_come());
  }
  return drift.worst();
}

TEST(Body, EnergyBalanceOfEveryMethodClosesWithTheStep) {
  for (const std::string_view name : integrator_names()) {
    // At 900 rad/s explicit Euler grows by 4e5 h /s and rk2 by 8e10 h^3 /s; damping takes 4.5 /s.
    const double step = name == "explicit-euler" ? 5e-6 : name == "rk2" ? 2.5e-4 : 1e-3;
    const double coarse = imbalance(name, step), fine = imbalance(name, 0.25 * step);
    EXPECT_LE(coarse, 0.1) << name;
    // First order at worst: a quarter of the step, less than half the error.
    EXPECT_LE(fine, 0.5 * coarse) << name;
  }
}

TEST(Body, HighBandHoldsTheEnergyOfTheHighRowsOscillation) {
  Body body = make_body("imexv", 0.4);
  const Eigen::Index low = body.integrator().split()->low;
  ASSERT_GT(low, 0);
  ASSERT_LT(low, 5);
  const Eigen::VectorXd q = testing::random_vector(5, 0.1, 1);
  const Eigen::VectorXd p = testing::random_vector(5, 1.0, 2);
  ASSERT_TRUE(body.set_state(q, p));
  double expected = 0.0;
  const Eigen::VectorXd force = testing::strain_force(body_strain_model(0.4), q);
  for (Eigen::Index i = low; i < 5; ++i)
    expected += 0.5 * p[i] * p[i] + 0.5 * force[i] * force[i] / body.model().lambda()[i];
  const Energy energy = body.energy();
  EXPECT_NEAR(energy.high_band, expected, 1e-14 * expected);
  EXPECT_NEAR(energy.kinetic, 0.5 * p.squaredNorm(), 1e-15 * p.squaredNorm());
  EXPECT_NEAR(energy.potential, testing::strain_energy(body_strain_model(0.4), q),
              1e-12 * energy.potential);
}

TEST(Body, HighBandIsHarmonicInSmallMotionAndTheSameForMethodsThatDoNotSplit) {
  Body body = make_body("imexv", 0.4);
  Body other = make_body("midpoint", 0.4);
  const Eigen::VectorXd q = testing::random_vector(5, 1e-7, 1);
  const Eigen::VectorXd p = testing::random_vector(5, 1e-6, 2);
  ASSERT_TRUE(body.set_state(q, p));
  ASSERT_TRUE(other.set_state(q, p));
  double expected = 0.0;
  for (Eigen::Index i = body.integrator().split()->low; i < 5; ++i)
    expected += 0.5 * p[i] * p[i] + 0.5 * body.model().lambda()[i] * q[i] * q[i];
  EXPECT_NEAR(body.energy().high_band, expected, 1e-5 * expected);  // the quadratic force, ~ q
  EXPECT_EQ(other.energy().high_band, body.energy().high_band);
}

TEST(Body, FailedStepKeepsStateTimeAndPendingForces) {
  IntegratorOptions options;
  options.max_iterations = 1;
  Body body = make_body("midpoint", 1.0, options);
  const Eigen::VectorXd q = testing::random_vector(5, 2.0, 3);
  ASSERT_TRUE(body.set_state(q, 100.0 * q));
  ASSERT_TRUE(body.apply_force(5, {1.0, 0.0, 0.0}));
  EXPECT_FALSE(body.step().converged);
  EXPECT_EQ(body.counts().steps, 0);
  EXPECT_EQ(body.state().q, q);
  EXPECT_EQ(body.sums().work, 0.0);
  EXPECT_TRUE(body.load_to_come());
}

TEST(Body, BadArgumentsAreRefusedAndChangeNothing) {
  Body body = make_body("imexv");
  const Eigen::VectorXd five = Eigen::VectorXd::Ones(5), four = Eigen::VectorXd::Ones(4);
  EXPECT_FALSE(body.set_state(four, five));
  EXPECT_FALSE(body.set_state(five, Eigen::VectorXd::Constant(5, std::nan(""))));
  EXPECT_FALSE(body.apply_force(99, {1.0, 0.0, 0.0}));
  EXPECT_FALSE(body.apply_force(5, {1.0, 0.0, 0.0}, 0));
  EXPECT_FALSE(body.add_load({{.kind = SignalKind::kConstant}, four}));
  EXPECT_FALSE(body.displacement(99));
  EXPECT_EQ(body.state().q, Eigen::VectorXd::Zero(5));
  EXPECT_FALSE(body.load_to_come());
}

TEST(DriftMeter, ComparesWithTheEnergyWhenTheLoadsEnded) {
  DriftMeter drift;
  drift.observe(0.0, 0.0, 0.0, true);
  drift.observe(3.0, 2.5, 0.0, true);   // off by 0.5 while loaded
  drift.observe(4.0, 4.0, 0.0, false);  // the reference
  drift.observe(4.2, 4.0, 0.0, false);
  drift.observe(3.9, 4.0, 0.0, false);
  EXPECT_NEAR(drift.worst(), 0.05, 1e-15);
}

TEST(DriftMeter, CountsLoadedErrorAgainstTheHighestEnergyWhileALoadLasts) {
  DriftMeter drift;
  drift.observe(1.0, 0.0, 0.0, true);
  drift.observe(5.0, 4.0, 0.0, true);
  drift.observe(2.0, 2.0, 0.5, true);  // 2 - 1 - 2 + 0.5 = -0.5
  EXPECT_NEAR(drift.worst(), 0.1, 1e-15);
}

TEST(DriftMeter, DissipationIsNoDrift) {
  DriftMeter drift;
  drift.observe(4.0, 0.0, 0.0, false);
  drift.observe(3.0, 0.0, 1.0, false);
  EXPECT_EQ(drift.worst(), 0.0);
}

TEST(DriftMeter, EnergyThatIsNotANumberShows) {
  DriftMeter drift;
  drift.observe(4.0, 0.0, 0.0, false);
  drift.observe(std::nan(""), 0.0, 0.0, false);
  drift.observe(4.0, 0.0, 0.0, false);
  EXPECT_FALSE(std::isfinite(drift.worst()));
}

}  // namespace
}  // namespace tremolo
