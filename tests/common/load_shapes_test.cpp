// Chirps and ramps hand on their exact impulse, whatever the step.
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "common/load_signal.h"

namespace tremolo {
namespace {

double impulse_of(const Signal& signal, double step, int steps) {
  double sum = 0.0;
  for (int k = 0; k < steps; ++k) sum += step * sample_signal(signal, k * step, step).average;
  return sum;
}

// The integral of the signal's own formula by Simpson's rule on very short pieces.
double simpson(double (*value)(double), double end, int pieces) {
  const double h = end / pieces;
  double sum = 0.0;
  for (int k = 0; k < pieces; ++k)
    sum += h / 6 * (value(k * h) + 4 * value((k + 0.5) * h) + value((k + 1) * h));
  return sum;
}

TEST(Chirps, PassThroughTheirFrequenciesEvenly) {
  // From 2 to 8 Hz in 3 s: the phase in turns is 2 t + t^2.
  const Signal chirp{
      .kind = SignalKind::kChirp, .duration = 3.0, .frequency = 2.0, .last_frequency = 8.0};
  const auto value = [](double t) { return std::sin(2 * std::numbers::pi * (2 * t + t * t)); };
  for (const double t : {0.3, 1.0, 2.4})
    EXPECT_NEAR(sample_signal(chirp, t, 1e-3).start, value(t), 1e-12);
  // Simpson's error on 30 000 pieces is below 1e-13.
  const double whole = simpson(value, 3.0, 30'000);
  for (const int steps : {3, 7, 50, 1000})
    EXPECT_NEAR(impulse_of(chirp, 3.0 / steps, steps), whole, 1e-12) << steps;
  EXPECT_EQ(sample_signal(chirp, 3.0, 0.1).average, 0.0);
  EXPECT_EQ(signal_end(chirp), 3.0);
}

TEST(Chirps, MayFallAndBeFarFasterThanTheStep) {
  const Signal falling{
      .kind = SignalKind::kChirp, .duration = 1.0, .frequency = 5.0, .last_frequency = 1.0};
  EXPECT_NEAR(sample_signal(falling, 0.5, 0.01).start,
              std::sin(2 * std::numbers::pi * (5 * 0.5 - 2 * 0.25)), 1e-12);
  const Signal fast{
      .kind = SignalKind::kChirp, .duration = 1.0, .frequency = 1e12, .last_frequency = 1e15};
  EXPECT_TRUE(std::isfinite(sample_signal(fast, 0.0, 0.1).average));
}

TEST(Ramps, RiseEvenlyAndStay) {
  const Signal ramp{.kind = SignalKind::kRamp, .start = 0.5, .duration = 2.0};
  EXPECT_EQ(sample_signal(ramp, 0.0, 0.5).average, 0.0);
  EXPECT_NEAR(sample_signal(ramp, 1.0, 0.5).start, 0.25, 1e-15);
  EXPECT_NEAR(sample_signal(ramp, 1.0, 0.5).average, 0.375, 1e-15);
  EXPECT_EQ(sample_signal(ramp, 7.0, 0.5).average, 1.0);
  EXPECT_TRUE(std::isinf(signal_end(ramp)));
  // One second of the rise and 1.5 s at full height, in steps that meet neither kink.
  for (const int steps : {1, 7, 90}) EXPECT_NEAR(impulse_of(ramp, 4.0 / steps, steps), 2.5, 1e-13);
}

TEST(SignalShapes, ApplyToTheirOwnKindAlone) {
  Signal sine{.kind = SignalKind::kSine}, chirp{.kind = SignalKind::kChirp}, none;
  EXPECT_TRUE(shape_signal({.frequency = 5.0, .sweep = "", .duration = 2.0}, sine));
  EXPECT_EQ(sine.frequency, 5.0);
  EXPECT_EQ(signal_end(sine), 2.0);
  EXPECT_TRUE(shape_signal({.frequency = {}, .sweep = "1,20", .duration = {}}, chirp));
  EXPECT_EQ(chirp.frequency, 1.0);
  EXPECT_EQ(chirp.last_frequency, 20.0);
  const auto kind_of = [](const SignalShape& shape, Signal signal) {
    const Status status = shape_signal(shape, signal);
    return status ? ErrorKind::kSystem : status.error().kind;
  };
  EXPECT_EQ(kind_of({.frequency = 5.0, .sweep = "", .duration = {}}, chirp), ErrorKind::kUsage);
  EXPECT_EQ(kind_of({.frequency = {}, .sweep = "1,2", .duration = {}}, sine), ErrorKind::kUsage);
  EXPECT_EQ(kind_of({.frequency = {}, .sweep = "", .duration = 1.0}, none), ErrorKind::kUsage);
  for (const char* text : {"1", "1,", ",2", "1,2,3", "a,b"})
    EXPECT_EQ(kind_of({.frequency = {}, .sweep = text, .duration = {}}, chirp), ErrorKind::kUsage)
        << text;
  EXPECT_EQ(kind_of({.frequency = {}, .sweep = "0,5", .duration = {}}, chirp), ErrorKind::kContent);
  EXPECT_EQ(kind_of({.frequency = -1.0, .sweep = "", .duration = {}}, sine), ErrorKind::kContent);
  EXPECT_EQ(kind_of({.frequency = {}, .sweep = "", .duration = 0.0}, sine), ErrorKind::kContent);
}

}  // namespace
}  // namespace tremolo
