// tremolo bench on a small model in memory: the basis of its figures.
#include <cmath>
#include <filesystem>
#include <limits>

#include <gtest/gtest.h>

#include "runtime/apps/tremolo/output/statistics.h"
#include "tests/lab/bench/precision_report.h"
#include "tests/lab/bench/stability.h"
#include "tests/lab/report/table.h"
#include "tests/support/dynamics.h"
#include "tests/support/temporary_folder.h"

namespace tremolo::bench {
namespace {

namespace fs = std::filesystem;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kPi = 3.14159265358979323846;

// Five coordinates from 1.5 to 150 Hz; the second band exists at 3 ms.
SampleModel small_sample() {
  const auto strain =
      testing::random_strain_model(testing::spread_omega(5, 3.0 * kPi, 300.0 * kPi), 0.02, 3);
  return {"small", "0123456789abcdef", testing::make_model(strain)};
}

Options small_options() {
  Options options;
  options.integrators = {"verlet", "newmark", "imexv"};
  options.loads = {"square", "impulse"};
  options.amplitudes = {0.01, 0.05};
  options.steps_ms = {3, 1.5, 0.3};
  options.duration = 0.12;
  return options;
}

Precision measure(const std::string& folder, unsigned threads) {
  Options options = small_options();
  options.threads = threads;
  return measure_precision(options, {small_sample()}, *Store::open(folder));
}

// The table without its last two columns, the times.
std::string untimed(const Precision& precision) {
  Table table = bench_table(precision);
  for (auto& row : table.rows) row.resize(row.size() - 2);
  return to_csv(table);
}

TEST(TrajectoryError, IsZeroAgainstItselfAndRelativeOtherwise) {
  const Eigen::MatrixXd q = Eigen::MatrixXd::Random(4, 50);
  EXPECT_EQ(trajectory_error(q, q, 50), 0.0);
  EXPECT_NEAR(trajectory_error(1.01 * q, q, 50), 0.01, 1e-14);  // rounding of 1.01 q - q
  Eigen::MatrixXd late = q;
  late.rightCols(10).setZero();
  EXPECT_EQ(trajectory_error(late, q, 40), 0.0);
  EXPECT_GT(trajectory_error(late, q, 41), 0.0);
  EXPECT_EQ(trajectory_error(q.leftCols(30), q, 40), kInfinity) << "broke off before the horizon";
}

TEST(Reference, HorizonEndsWhereTheTwoFirstPart) {
  SampledRun one;
  one.q = Eigen::MatrixXd::Constant(4, 100, 0.5);  // root mean square of |q|: 1
  SampledRun other = one;
  for (Eigen::Index k = 0; k < 100; ++k) other.q(1, k) += 0.9 * kAgree;
  other.q(2, 60) += 2.0 * kAgree;  // apart at one sample only, together again after it
  const Reference reference = compare_references(one, other, 6e-3);
  EXPECT_EQ(reference.horizon, 60);
  EXPECT_DOUBLE_EQ(reference.seconds, 0.36);
  EXPECT_NEAR(reference.gap, 0.9 * kAgree, 1e-9 * kAgree);  // 1e-16 / kAgree of rounding
  EXPECT_GT(reference.worst_gap, 2.0 * kAgree);
  EXPECT_TRUE(reference.trouble.empty());
  EXPECT_EQ(compare_references(one, one, 6e-3).gap, 0.0);
  EXPECT_EQ(compare_references(one, one, 6e-3).horizon, 100);
}

TEST(Reference, WhatBreaksOffIsNoReference) {
  SampledRun one;
  one.q = Eigen::MatrixXd::Ones(2, 10);
  SampledRun other = one;
  other.q.conservativeResize(2, 4);
  other.exit_code = 4;
  EXPECT_FALSE(compare_references(one, other, 6e-3).trouble.empty());
  SampledRun apart = one;
  apart.q.col(0) *= 2.0;
  EXPECT_FALSE(compare_references(one, apart, 6e-3).trouble.empty());
}

TEST(OrbitText, GivesBackEveryBit) {
  Eigen::MatrixXd q = Eigen::MatrixXd::Random(3, 7);
  q(0, 0) = -0.0;
  q(1, 1) = std::numeric_limits<double>::denorm_min();
  q(2, 2) = -kInfinity;
  const Eigen::MatrixXd back = orbit_from_text(orbit_text(q), 3);
  ASSERT_EQ(back.cols(), 7);
  for (Eigen::Index i = 0; i < q.size(); ++i)
    EXPECT_EQ(std::bit_cast<std::uint64_t>(back(i)), std::bit_cast<std::uint64_t>(q(i)));
  EXPECT_EQ(orbit_from_text("0123456789abcdeg", 1).size(), 0);
  EXPECT_EQ(orbit_from_text("0123", 1).size(), 0);
}

// error = 3 step^order, the same time a step: cost = microseconds / step.
std::vector<Entry> power_law(double order, const std::vector<double>& steps) {
  std::vector<Entry> curve;
  for (const double step : steps) {
    Entry entry;
    entry.step = step;
    entry.error = 3.0 * std::pow(step, order);
    entry.microseconds = 20.0;
    curve.push_back(entry);
  }
  return curve;
}

TEST(CostOfError, IsExactOnAPowerLaw) {
  for (const double order : {1.0, 2.0, 4.0}) {
    const std::vector<Entry> curve = power_law(order, {1e-1, 1e-2, 1e-3});
    for (const double step : {0.07, 1e-2, 2.3e-3}) {
      const auto cost = cost_of_error(curve, 3.0 * std::pow(step, order) * (1.0 + 1e-12), 0.0);
      ASSERT_TRUE(cost);
      EXPECT_NEAR(cost->value * step * 1e3 / 20.0, 1.0, 1e-11);  // the slack of the target
      EXPECT_FALSE(cost->at_most);
    }
    EXPECT_FALSE(cost_of_error(curve, 2.9 * std::pow(1e-3, order), 0.0)) << "not reached";
    EXPECT_TRUE(cost_of_error(curve, 1e3, 0.0)->at_most);
  }
}

TEST(CostOfError, DoesNotTrustErrorsBelowTheReference) {
  const std::vector<Entry> curve = power_law(2.0, {1e-1, 1e-2, 1e-3});  // 3e-2, 3e-4, 3e-6
  EXPECT_TRUE(cost_of_error(curve, 1e-4, 0.5e-5));
  EXPECT_FALSE(cost_of_error(curve, 1e-4, 2e-5)) << "ten times the gap is above the target";
}

TEST(CostOfError, TakesTheNextStepAfterOneThatBrokeOff) {
  std::vector<Entry> curve = power_law(2.0, {1e-1, 1e-2, 1e-3});
  curve[0].error = kInfinity;
  EXPECT_DOUBLE_EQ(cost_of_error(curve, 1e-3, 0.0)->value, curve[1].cost());
}

TEST(Median, OfNothingAndOfUnreachedTargets) {
  EXPECT_TRUE(std::isnan(median({})));
  EXPECT_EQ(median({5.0, 1.0, kInfinity}), 5.0);
  EXPECT_DOUBLE_EQ(median({2.0, 8.0}), 4.0);
  EXPECT_EQ(median({3.0, kInfinity}), 3.0);
  EXPECT_EQ(median({0.0, kInfinity}), 0.0);
}

TEST(Precision, DoesNotDependOnThreadsNorOnBeingStopped) {
  testing::TemporaryFolder alone, many;
  const Precision first = measure(alone.path(), 1);
  ASSERT_EQ(first.entries.size(), 2u * 2u * 3u * 3u);
  EXPECT_EQ(untimed(first), untimed(measure(many.path(), 4)));
  EXPECT_EQ(to_csv(bench_table(first)), to_csv(bench_table(measure(alone.path(), 2))))
      << "all, the times too, comes from the store";
  int removed = 0;
  for (const auto& file : fs::directory_iterator(many.path()))
    if (std::hash<std::string>()(file.path().filename().string()) % 2 == 0)
      removed += fs::remove(file.path()) ? 1 : 0;
  ASSERT_GT(removed, 3);
  EXPECT_EQ(untimed(first), untimed(measure(many.path(), 1)));
}

TEST(Precision, ScenesReachTheirAmplitudeAndErrorsFallWithTheOrder) {
  testing::TemporaryFolder folder;
  const Precision precision = measure(folder.path(), 2);
  for (std::size_t i = 0; i < precision.scenes.size(); ++i) {
    const Scene& scene = precision.scenes[i];
    ASSERT_TRUE(precision.measured(i)) << scene.trouble << precision.references[i].trouble;
    EXPECT_EQ(precision.references[i].horizon, 20);
    // By another method and step than those that found the scale; their own errors are below 1 %.
    RunSpec spec = scene.run("verlet", 1e-4);
    spec.watched = scene.subject->watched;
    EXPECT_NEAR(run_sampled(spec).largest / scene.subject->size / scene.amplitude, 1.0, 0.02);
    for (const Entry& entry : precision.curve(i, "newmark")) EXPECT_GT(entry.microseconds, 0.0);
  }
  // Resolved (h omega_max < 0.3), second order: (0.3 / 0.1)^2 = 9; a tenth for the higher terms.
  const Scene& scene = precision.scenes.front();
  const auto entries = measure_errors(scene, precision.references.front(), "verlet", {3e-4, 1e-4},
                                      *Store::open(folder.path()));
  EXPECT_NEAR(entries.at(0).error / entries.at(1).error, 9.0, 0.9);
}

TEST(Precision, AReferenceMeasuredAgainstItselfIsBelowTheReference) {
  testing::TemporaryFolder folder;
  const Precision precision = measure(folder.path(), 2);
  const ReferenceMethod method = reference_methods().front();
  const auto entries =
      measure_errors(precision.scenes.front(), precision.references.front(), method.integrator,
                     {method.step}, *Store::open(folder.path()));
  EXPECT_LT(entries.front().error, 1e-9);  // the solve's tolerance, where there is one
  EXPECT_TRUE(entries.front().below_reference);
}

TEST(Stability, AnExplicitMethodDiesAboveItsLimitAndSurvivesBelow) {
  testing::TemporaryFolder folder;
  Options options = small_options();
  options.integrators = {"verlet", "newmark"};
  options.stability_scales = {0.01};
  options.stability_steps_ms = {6, 0.5};  // the limit at 150 Hz is 2.1 ms
  options.stability_duration = 3.0;
  const std::vector<Subject> subjects = {make_subject(small_sample())};
  const auto cells = measure_stability(options, subjects, *Store::open(folder.path()));
  ASSERT_EQ(cells.size(), 4u);
  EXPECT_EQ(cells[0].outcome, Outcome::kDies);
  EXPECT_LT(cells[0].reached, 1.0);
  for (std::size_t i = 1; i < 4; ++i) {
    EXPECT_EQ(cells[i].outcome, Outcome::kSurvives) << i;
    EXPECT_NEAR(cells[i].reached, 3.0, 1e-9);
  }
}

TEST(Options, NamesAndValuesAreChecked) {
  const auto kind = [](auto change) {
    Options options = small_options();
    change(options);
    const Status status = settle(options);
    return status ? 0 : exit_code(status.error());
  };
  EXPECT_EQ(kind([](Options&) {}), 0);
  EXPECT_EQ(kind([](Options& o) { o.integrators = {"euler"}; }), 2);
  EXPECT_EQ(kind([](Options& o) { o.integrators = {"verlet", "verlet"}; }), 2);
  EXPECT_EQ(kind([](Options& o) { o.loads = {"constant"}; }), 2);
  EXPECT_EQ(kind([](Options& o) { o.only = "both"; }), 2);
  for (const double bad : {0.0, -1.0, kInfinity, std::nan("")}) {
    EXPECT_EQ(kind([&](Options& o) { o.steps_ms = {3, bad}; }), 3) << bad;
    EXPECT_EQ(kind([&](Options& o) { o.amplitudes = {bad}; }), 3) << bad;
    EXPECT_EQ(kind([&](Options& o) { o.duration = bad; }), 3) << bad;
  }
  EXPECT_EQ(kind([](Options& o) { o.steps_ms = {4}; }), 3) << "does not divide 6 ms";
  EXPECT_EQ(kind([](Options& o) { o.steps_ms = {12}; }), 3);
}

}  // namespace
}  // namespace tremolo::bench
