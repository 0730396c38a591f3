// Warnings of a run, and the step that sound needs.
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "formats/basis/basis_writer.h"
#include "runtime/apps/tremolo/output/sound.h"
#include "runtime/apps/tremolo/output/warnings.h"
#include "runtime/apps/tremolo/run/simulate.h"
#include "runtime/bodies/reduced/integrators/dispersion.h"
#include "tests/support/frames/corner_cube.h"
#include "tests/support/run_program.h"
#include "tests/support/temporary_folder.h"

namespace tremolo {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

// A bar of 290 Hz at the default step is warned of; at the step that the warning names it is not.
TEST(StepWarning, NamesAStepThatFollowsTheMode) {
  const std::string warning = step_warning(290.0, 3e-3, "the ", "--step ");
  EXPECT_NE(warning.find("290 Hz"), std::string::npos) << warning;
  const std::size_t at = warning.find("--step ");
  ASSERT_NE(at, std::string::npos) << warning;
  const double step = std::stod(warning.substr(at + 7));
  EXPECT_NEAR(step, 1.0 / (20.0 * 290.0), 1e-3 * step);  // four digits
  EXPECT_EQ(step_warning(290.0, step, "the ", "--step "), "");
  EXPECT_EQ(step_warning(10.0, 3e-3, "the ", "--step "), "");
  // These errors determined the number of steps per period.
  EXPECT_NEAR(1.0 - std::cos(std::numbers::pi / kStepsAPeriod), 0.012, 5e-4);
  EXPECT_NEAR(frequency_error("midpoint", kTurn / kStepsAPeriod, {}), 0.008, 5e-4);
}

TEST(StepWarning, ARunKnowsItsFirstMode) {
  const testing::TemporaryFolder folder;
  const std::string path = folder.file("cube.tremolo");
  ASSERT_TRUE(write_basis(path, testing::corner_cube_data(kTurn * 290.0, kTurn * 500.0)));
  RunOptions options;
  options.model = path;
  options.duration = 0.03;
  options.load = "none";
  options.start = "5=0,0,0.001";
  const Result<BodyScene> scene = body_scene(options);
  ASSERT_TRUE(scene) << scene.error().message;
  const Result<RunReport> report = simulate(*scene);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_NEAR(report->first_frequency, 290.0, 1e-9);
  EXPECT_NE(step_warning(report->first_frequency, report->step, "the ", ""), "");
}

TEST(Pace, IsNeverZeroTimes) {
  EXPECT_EQ(pace_text(600.4), "600 times faster than real time");
  EXPECT_EQ(pace_text(1.0 / 28.0), "28 times slower than real time");
  EXPECT_EQ(pace_text(2.54), "2.5 times faster than real time");
  EXPECT_EQ(pace_text(1e-5), "100000 times slower than real time");
  EXPECT_EQ(pace_text(std::nan("")), "");
}

// The least number of steps with which the bound holds, for methods of which it is known.
TEST(SoundStep, IsTheLongestWithTheFrequenciesWithinTheBound) {
  constexpr double kRate = 48'000.0;
  struct Known {
    const char* method;
    double highest;  // Hz
    int steps;
  };
  // 0.3 % at h omega = 1.14, 2.41 and 0.19.
  for (const auto& [method, highest, steps] :
       {Known{"ep4", 8'000.0, 1}, Known{"ep4", 20'000.0, 3}, Known{"ep2", 18'000.0, 1},
        Known{"ep2", 23'000.0, 2}, Known{"midpoint", 1'400.0, 1}, Known{"avf", 20'000.0, 14}}) {
    const Model::Pointer model = testing::corner_cube(kTurn * 300.0, kTurn * highest);
    EXPECT_EQ(steps_a_sample(*model, method, {.step = 1.0 / kRate}, kRate), steps)
        << method << " " << highest;
    EXPECT_LE(fit_of_sound(*model, method, {.step = 1.0 / (kRate * steps)}, kRate).worst,
              kSoundError);
    if (steps > 1) {
      EXPECT_GT(fit_of_sound(*model, method, {.step = 1.0 / (kRate * (steps - 1))}, kRate).worst,
                kSoundError);
    }
  }
  // Modes that the file cannot hold do not count, but an explicit method must be stable with them.
  const Model::Pointer high = testing::corner_cube(kTurn * 300.0, kTurn * 30'000.0);
  EXPECT_EQ(fit_of_sound(*high, "verlet", {.step = 1.0 / kRate}, kRate).worst,
            std::numeric_limits<double>::infinity());
  const Model::Pointer bell = testing::corner_cube(kTurn * 300.0, kTurn * 3'843.0);
  EXPECT_NE(sound_warning(*bell, "ep4", {.step = 1.0 / 8'000.0}, 8'000.0).find("3843 Hz sound at"),
            std::string::npos);
  EXPECT_EQ(sound_warning(*high, "ep4", {.step = 1.0 / 400'000.0}, 48'000.0), "");
}

// The amplitude of a sine of the frequency f in the samples.
double strength(const std::vector<double>& sound, double rate, double f) {
  double re = 0.0, im = 0.0;
  for (std::size_t k = 0; k < sound.size(); ++k) {
    const double t = static_cast<double>(k) / rate;
    const double window =
        1.0 - std::cos(kTurn * static_cast<double>(k) / static_cast<double>(sound.size()));
    re += window * sound[k] * std::cos(kTurn * f * t);
    im += window * sound[k] * std::sin(kTurn * f * t);
  }
  return std::hypot(re, im) / static_cast<double>(sound.size());
}

TEST(SoundStep, AnEarNeedsASound) {
  const testing::TemporaryFolder folder;
  const std::string path = folder.file("cube.tremolo");
  ASSERT_TRUE(write_basis(path, testing::corner_cube_data(kTurn * 2'000.0, kTurn * 20'000.0, 0.1)));
  RunOptions options;
  options.model = path;
  options.listen = "5";
  const Result<BodyScene> scene = body_scene(options);
  ASSERT_FALSE(scene);
  EXPECT_NE(scene.error().message.find("add --wav"), std::string::npos) << scene.error().message;
}

// A body of four modes, the highest of 20 kHz, which ep4 steps: in the file each is where it
// belongs, where at one step a sample the highest was 11 % too low.
TEST(SoundStep, TheFileHasTheFrequenciesOfTheModel) {
  const testing::TemporaryFolder folder;
  const std::string path = folder.file("cube.tremolo"), wav = folder.file("cube.wav");
  // Motions of a micrometre: linear.
  ASSERT_TRUE(write_basis(path, testing::corner_cube_data(kTurn * 2'000.0, kTurn * 20'000.0, 0.1)));
  RunOptions options;
  options.model = path;
  options.duration = 0.1;
  options.load = "none";
  options.start = "5=1e-6,1e-6,1e-6";
  options.wav = wav;
  options.listen = "5";
  options.step = kSoundStep;
  options.sound_steps = 0;
  const Result<BodyScene> scene = body_scene(options);
  ASSERT_TRUE(scene) << scene.error().message;
  const Result<RunReport> report = simulate(*scene);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_DOUBLE_EQ(report->step, kSoundStep / 3.0);
  EXPECT_EQ(report->sound_warning, "");
  const std::string bytes = testing::slurp(wav);
  std::vector<double> sound;
  for (std::size_t at = 44; at + 1 < bytes.size(); at += 2)
    sound.push_back(static_cast<std::int16_t>(
        static_cast<unsigned char>(bytes[at]) |
        static_cast<unsigned>(static_cast<unsigned char>(bytes[at + 1])) << 8));
  ASSERT_EQ(sound.size(), 4'800U - 1U);
  const Result<Model::Pointer> model = Model::load(path);
  ASSERT_TRUE(model);
  int found = 0;
  for (const double mode : (*model)->frequencies_hz()) {
    const double here = strength(sound, 48'000.0, mode * (1.0 - 1.5e-3));
    // 20 Hz wide peaks of a tenth of a second, the bound of 0.3 % next to them.
    double best = 0.0, loudest = 0.0;
    for (double f = 0.9 * mode; f < 1.1 * mode; f += 2.0)
      if (const double now = strength(sound, 48'000.0, f); now > loudest) {
        loudest = now;
        best = f;
      }
    EXPECT_GE(loudest, here);
    EXPECT_NEAR(best, mode, kSoundError * mode + 2.0);
    ++found;
  }
  EXPECT_EQ(found, 4);
}

}  // namespace
}  // namespace tremolo
