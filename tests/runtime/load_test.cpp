#include "runtime/load.h"

#include <cmath>
#include <initializer_list>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/support/dynamics.h"

namespace tremolo {
namespace {

constexpr double kPi = std::numbers::pi;

// h times the sum of the averages over `count` steps from time 0.
double total_impulse(const Signal& signal, double step, int count) {
  double sum = 0.0;
  for (int k = 0; k < count; ++k) sum += step * sample_signal(signal, k * step, step).average;
  return sum;
}

// Steps that divide a pulse of 3 ms or 0.3 s, that do not, and that are longer than it.
class StepOfLoad : public ::testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(Steps, StepOfLoad,
                         ::testing::Values(1e-3, 3e-3, 1e-4, 7e-4, 2.9e-3, 4e-3, 1e-2, 0.0123));

TEST_P(StepOfLoad, AveragesAddUpToTheIntegralOfAPulse) {
  const double step = GetParam();
  const int count = static_cast<int>(std::ceil(1.0 / step));
  // A snapped edge may move by 1e-9 of a step.
  EXPECT_NEAR(total_impulse({.kind = SignalKind::kImpulse}, step, count), 3e-3, 2e-9 * step);
  EXPECT_NEAR(total_impulse({.kind = SignalKind::kSquare}, step, count), 0.3, 2e-9 * step);
  EXPECT_NEAR(
      total_impulse({.kind = SignalKind::kSquare, .start = 0.0501, .duration = 0.2}, step, count),
      0.2, 2e-9 * step);
}

TEST_P(StepOfLoad, AveragesAddUpToTheIntegralOfASine) {
  const double step = GetParam();
  const int count = static_cast<int>(std::ceil(0.8 / step));
  const double end = count * step;
  const Signal signal{.kind = SignalKind::kSine, .frequency = 1.7};
  const double exact = (1.0 - std::cos(2.0 * kPi * 1.7 * end)) / (2.0 * kPi * 1.7);
  EXPECT_NEAR(total_impulse(signal, step, count), exact, 1e-13);  // rounding of 8000 terms
}

TEST(Signal, EndsAreOneSidedWhereAPulseEndsWithAStep) {
  const Signal impulse{.kind = SignalKind::kImpulse};
  for (int k = 0; k < 5; ++k) {
    const StepSignal sample = sample_signal(impulse, k * 1e-3, 1e-3);
    const double expected = k < 3 ? 1.0 : 0.0;
    EXPECT_EQ(sample.start, expected) << k;
    EXPECT_EQ(sample.average, expected) << k;
    EXPECT_EQ(sample.end, expected) << k;
  }
}

TEST(Signal, PulseFillsTheStepsThatDivideItWhateverTheRounding) {
  for (int n = 1; n <= 400; ++n) {
    const double step = 0.3 / n;
    for (int k = 0; k <= n; ++k) {
      const StepSignal sample = sample_signal({.kind = SignalKind::kSquare}, k * step, step);
      const double expected = k < n ? 1.0 : 0.0;
      ASSERT_EQ(sample.start, expected) << k << " of " << n;
      ASSERT_EQ(sample.average, expected) << k << " of " << n;
      ASSERT_EQ(sample.end, expected) << k << " of " << n;
    }
  }
}

TEST(Signal, JumpInsideAStepShowsTheAverageThreeTimes) {
  const StepSignal sample = sample_signal({.kind = SignalKind::kImpulse}, 0.0, 1e-2);
  EXPECT_NEAR(sample.average, 0.3, 1e-15);
  EXPECT_EQ(sample.start, sample.average);
  EXPECT_EQ(sample.end, sample.average);
}

TEST(Signal, SineThatBeginsInsideAStepIsAKinkAndNoJump) {
  const Signal sine{.kind = SignalKind::kSine, .start = 0.4, .frequency = 0.25};
  const StepSignal sample = sample_signal(sine, 0.0, 1.0);
  EXPECT_NEAR(sample.start, 0.0, 1e-16);
  EXPECT_NEAR(sample.end, std::sin(2.0 * kPi * 0.25 * 0.6), 1e-15);
  EXPECT_NEAR(sample.average, (1.0 - std::cos(2.0 * kPi * 0.25 * 0.6)) / (2.0 * kPi * 0.25), 1e-15);
}

TEST(Signal, ConstantLastsAndNoneIsNothing) {
  EXPECT_EQ(sample_signal({.kind = SignalKind::kConstant}, 1e6, 1e-3).average, 1.0);
  EXPECT_EQ(sample_signal({}, 0.0, 1e-3).average, 0.0);
  EXPECT_TRUE(std::isinf(signal_end({.kind = SignalKind::kConstant})));
  EXPECT_TRUE(std::isinf(signal_end({.kind = SignalKind::kSine})));
  EXPECT_DOUBLE_EQ(signal_end({.kind = SignalKind::kSquare}), 0.3);
}

TEST(Signal, NamesAreReadAndUnknownOnesAreListed) {
  EXPECT_EQ(parse_signal("impulse")->kind, SignalKind::kImpulse);
  EXPECT_EQ(parse_signal("sine")->kind, SignalKind::kSine);
  const Result<Signal> unknown = parse_signal("boom");
  ASSERT_FALSE(unknown);
  EXPECT_EQ(unknown.error().kind, ErrorKind::kUsage);
  EXPECT_NE(unknown.error().message.find("square"), std::string::npos);
}

TEST(Loads, SeveralAddUp) {
  const Eigen::VectorXd a = testing::random_vector(3, 1.0, 1);
  const Eigen::VectorXd b = testing::random_vector(3, 1.0, 2);
  StepLoad load = make_step_load(3);
  sample_loads({{{.kind = SignalKind::kConstant}, a}, {{.kind = SignalKind::kSquare}, b}}, 0.0, 0.6,
               load);
  EXPECT_TRUE(load.active);
  EXPECT_LE((load.average - (a + 0.5 * b)).norm(), 1e-15);
  sample_loads({{{.kind = SignalKind::kSquare}, b}}, 0.6, 0.6, load);
  EXPECT_FALSE(load.active);
  EXPECT_EQ(load.average, Eigen::VectorXd::Zero(3));
}

TEST(Loads, PulseShorterThanAStepGivesEveryMethodTheSameImpulse) {
  // So soft that in two steps the spring takes less than 1e-12 of the momentum.
  const auto strain = testing::random_strain_model(Eigen::Vector2d(1e-5, 2e-5), 0.0, 1);
  const Model::Pointer model = testing::make_model(strain);
  const Eigen::Vector2d force(2.0, -3.0);
  for (const std::string_view name : integrator_names()) {
    IntegratorOptions options{.step = 1e-2};
    options.split = {.rule = SplitRule::kCount, .count = 1};
    const auto integrator = testing::make(name, model, options);
    State state{Eigen::VectorXd::Zero(2), Eigen::VectorXd::Zero(2)};
    testing::run(*integrator, state, {{{.kind = SignalKind::kImpulse}, force}}, options.step, 2);
    Eigen::VectorXd momentum(2);
    integrator->synchronized_momentum(state, momentum);
    EXPECT_LE((momentum - 3e-3 * force).norm(), 1e-11 * 3e-3 * force.norm()) << name;
  }
}

TEST(Loads, ForceAtAVertexIsReducedByItsRows) {
  const auto strain = testing::random_strain_model(testing::spread_omega(4, 1.0, 9.0), 0.1, 1);
  const Model::Pointer model = testing::make_model(strain);
  const Eigen::Vector3d force(1.0, 2.0, 3.0);
  const BasisData data = testing::sample_basis(strain);
  const Eigen::VectorXd inside = data.interior.rows.bottomRows(3).transpose() * force;
  const Eigen::VectorXd outside = data.surface.rows.middleRows(6, 3).transpose() * force;
  EXPECT_LE((*reduce_force(*model, 4, force) - inside).norm(), 1e-15 * inside.norm());
  EXPECT_LE((*reduce_force(*model, 3, force) - outside).norm(), 1e-15 * outside.norm());
  const Result<Eigen::VectorXd> both = reduce_load(*model, {{3, 4}, {force, force}}, 2.0);
  EXPECT_LE((*both - 2.0 * (inside + outside)).norm(), 1e-14 * both->norm());
}

TEST(Loads, ForceIsRefusedAtAnUnknownVertexAndWhereItIsNotFinite) {
  const Model::Pointer model =
      testing::make_model(testing::random_strain_model(Eigen::Vector2d(1.0, 2.0), 0.1, 1));
  EXPECT_EQ(reduce_force(*model, 7, {1.0, 0.0, 0.0}).error().kind, ErrorKind::kUsage);
  EXPECT_EQ(reduce_force(*model, -1, {1.0, 0.0, 0.0}).error().kind, ErrorKind::kUsage);
  EXPECT_EQ(reduce_force(*model, 3, {NAN, 0.0, 0.0}).error().kind, ErrorKind::kUsage);
}

Signal signal_of(const SignalTable& table) {
  return {.kind = SignalKind::kTable, .table = &table};
}

TEST_P(StepOfLoad, AveragesOfATableAddUpToItsArea) {
  const double step = GetParam();
  const int count = static_cast<int>(std::ceil(1.0 / step));
  // A triangle, a jump, a plateau that ends at once.
  const SignalTable table{{0.0, 0.1, 0.2, 0.2, 0.5}, {0.0, 2.0, 1.0, -3.0, -3.0}};
  const Signal signal = signal_of(table);
  EXPECT_NEAR(total_impulse(signal, step, count), 0.1 + 0.15 - 0.9, 1e-8 * step);
}

TEST(SignalTable, SamplesAreItsStraightLines) {
  const SignalTable table{{0.0, 1.0, 3.0}, {0.0, 4.0, 0.0}};
  const Signal signal = signal_of(table);
  const StepSignal rising = sample_signal(signal, 0.25, 0.5);
  EXPECT_DOUBLE_EQ(rising.start, 1.0);
  EXPECT_DOUBLE_EQ(rising.average, 2.0);
  EXPECT_DOUBLE_EQ(rising.end, 3.0);
  const StepSignal bent = sample_signal(signal, 0.5, 1.0);  // a kink inside is no jump
  EXPECT_DOUBLE_EQ(bent.start, 2.0);
  EXPECT_DOUBLE_EQ(bent.end, 3.0);
  EXPECT_DOUBLE_EQ(bent.average, 0.5 * 3.0 + 0.5 * 3.5);
  EXPECT_EQ(sample_signal(signal, 3.0, 0.5).average, 0.0);
  EXPECT_EQ(sample_signal(signal, -1.0, 1.0).average, 0.0);
  EXPECT_EQ(signal_end(signal), 3.0);
}

TEST(SignalTable, AJumpInsideAStepShowsItsAverageAndOneAtAnEndDoesNot) {
  const SignalTable table{{0.0, 1.0, 1.0, 2.0}, {1.0, 1.0, 5.0, 5.0}};
  const Signal signal = signal_of(table);
  const StepSignal across = sample_signal(signal, 0.5, 1.0);
  EXPECT_DOUBLE_EQ(across.average, 3.0);
  EXPECT_DOUBLE_EQ(across.start, 3.0);
  EXPECT_DOUBLE_EQ(across.end, 3.0);
  EXPECT_DOUBLE_EQ(sample_signal(signal, 0.5, 0.5).end, 1.0);
  EXPECT_DOUBLE_EQ(sample_signal(signal, 1.0, 0.5).start, 5.0);
  EXPECT_DOUBLE_EQ(sample_signal(signal, 1.5, 0.5).end, 5.0);
  EXPECT_DOUBLE_EQ(sample_signal(signal, -0.5, 1.0).start, 0.5);  // it begins with a jump
}

TEST(SignalTable, WhatIsNoTableIsTold) {
  EXPECT_EQ(table_problem({{0.0, 1.0}, {1.0, 1.0}}), "");
  for (const SignalTable& table :
       std::initializer_list<SignalTable>{{{0.0}, {1.0}},
                                          {{0.0, 1.0}, {1.0}},
                                          {{1.0, 0.0}, {1.0, 1.0}},
                                          {{1.0, 1.0}, {0.0, 1.0}},
                                          {{0.0, 1.0, 1.0, 1.0}, {0.0, 1.0, 2.0, 3.0}},
                                          {{0.0, INFINITY}, {0.0, 1.0}}})
    EXPECT_NE(table_problem(table), "");
}

}  // namespace
}  // namespace tremolo
