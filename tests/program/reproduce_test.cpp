#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "formats/file/input_file.h"
#include "runtime/apps/tremolo/output/statistics.h"
#include "runtime/body.h"
#include "tests/lab/reproduce/long_run.h"
#include "tests/lab/reproduce/orbit.h"
#include "tests/lab/reproduce/runs.h"
#include "tests/lab/samples/sample_models.h"
#include "tests/lab/samples/thesis.h"
#include "tests/lab/work/failure.h"
#include "tests/support/dynamics.h"
#include "tests/support/sample_basis.h"
#include "tests/support/temporary_folder.h"

namespace tremolo::reproduce {
namespace {

using testing::fresh_folder;

// ---- the thesis's numbers ----

const thesis::Thesis& printed() {
  static const thesis::Thesis all = thesis::read_thesis(TREMOLO_SOURCE_DIR "/assets/published");
  return all;
}

TEST(ThesisNumbers, EveryOfTheThirtySixRunsIsThereOnce) {
  std::set<std::string> seen;
  for (const double alpha : thesis::kAlphas)
    for (const SignalKind load : thesis::kLoads)
      for (const std::string_view model : thesis::kModels) {
        const thesis::Run* run = printed().run(model, load, alpha);
        ASSERT_NE(run, nullptr) << model;
        seen.insert(std::string(model) + std::string(thesis::load_name(load)) +
                    std::to_string(alpha) + std::to_string(run->table));
      }
  EXPECT_EQ(seen.size(), thesis::kRuns);
  EXPECT_EQ(printed().run("cow", SignalKind::kSine, 0.0), nullptr);
}

// Added up by hand from the thesis's appendix 3, table by table: IMEXv seconds, Newmark seconds.
TEST(ThesisNumbers, ColumnsAddUpToThePrintedOnes) {
  struct Sum {
    int table;
    double imexv, newmark;
  };
  for (const Sum& sum : {Sum{5, 17.88, 32.83}, Sum{6, 17.88, 32.83}, Sum{7, 19.93, 32.83},
                         Sum{8, 17.25, 37.04}, Sum{9, 30.53, 47.64}, Sum{10, 39.94, 57.15}}) {
    Sum ours{sum.table, 0.0, 0.0};
    for (const thesis::Run& run : printed().runs)
      if (run.table == sum.table)
        ours.imexv += run.imexv_seconds, ours.newmark += run.newmark_seconds;
    EXPECT_NEAR(ours.imexv, sum.imexv, 1e-9) << sum.table;  // sums of two decimals
    EXPECT_NEAR(ours.newmark, sum.newmark, 1e-9) << sum.table;
  }
}

TEST(ThesisNumbers, TheSpeedUpIsTheRatioOfTheSeconds) {
  for (const thesis::Run& run : printed().runs)
    // Two decimals of a quotient of numbers with two decimals; one printed value is off by 0.02.
    EXPECT_NEAR(run.speedup, run.newmark_seconds / run.imexv_seconds, 0.021)
        << run.table << " " << run.model;
}

TEST(ThesisNumbers, ThreeRunsBreakOffAndTableFiveRepeatsTableSix) {
  int failed = 0;
  for (const thesis::Run& run : printed().runs) failed += run.reached < thesis::kDuration ? 1 : 0;
  EXPECT_EQ(failed, 3);
  EXPECT_DOUBLE_EQ(printed().run("beam", SignalKind::kSine, 0.0)->reached, 6.86);
  EXPECT_DOUBLE_EQ(printed().run("beam", SignalKind::kSine, 0.3)->reached, 7.12);
  EXPECT_DOUBLE_EQ(printed().run("tower", SignalKind::kSine, 0.0)->reached, 10.53);
  for (const std::string_view model : thesis::kModels) {
    const thesis::Run &five = *printed().run(model, SignalKind::kImpulse, 0.0),
                      &six = *printed().run(model, SignalKind::kSquare, 0.0);
    EXPECT_EQ(five.imexv_seconds, six.imexv_seconds) << model;
    EXPECT_EQ(five.speedup, six.speedup) << model;
  }
}

TEST(ThesisNumbers, LowAndHighModesAddUp) {
  for (const std::string_view model : thesis::kModels) {
    const thesis::Modes* modes = printed().modes_of(model);
    ASSERT_NE(modes, nullptr);
    EXPECT_EQ(modes->low + modes->high, modes->r) << model;
  }
}

// The message that reading the thesis's files gives after `change` of one of them.
std::string message_after(const std::string& file,
                          const std::function<std::string(std::string)>& change) {
  namespace fs = std::filesystem;
  const std::string folder = fresh_folder() + "/published";
  fs::copy(TREMOLO_SOURCE_DIR "/assets/published", folder);
  const std::string path = folder + "/" + file;
  const std::string text = change(*read_whole_file(path));
  fs::remove(path);
  if (!text.empty()) std::ofstream(path, std::ios::binary) << text;
  try {
    thesis::read_thesis(folder);
  } catch (const Failure& failure) {
    EXPECT_EQ(failure.error.kind, text.empty() ? ErrorKind::kSystem : ErrorKind::kContent);
    EXPECT_NE(failure.error.message.find(file), std::string::npos) << failure.error.message;
    return failure.error.message;
  }
  return "nothing is wrong";
}

TEST(ThesisNumbers, AFileThatIsMissingOrDamagedIsNamedWithItsLine) {
  const auto replaced = [](const char* what, const char* with) {
    return [=](std::string text) {
      const std::size_t at = text.find(what);
      EXPECT_NE(at, text.npos) << what;
      return text.replace(at, std::string(what).size(), with);
    };
  };
  const auto holds = [](const std::string& message, const char* part) {
    EXPECT_NE(message.find(part), std::string::npos) << message;
  };
  const std::string runs = "thesis-runs.csv";
  holds(message_after(runs, [](std::string) { return std::string(); }), "--published");
  holds(message_after(runs, replaced("2.62,", "2.6x,")), "line 9");
  holds(message_after(runs, replaced("basket,2.62", "cow,2.62")), "unknown model cow");
  holds(message_after(runs, replaced("basket,2.62", "beam,2.62")), "there twice");
  holds(message_after(runs, replaced(",1.87,30\n", ",1.87\n")), "seconds reached");
  holds(message_after(runs, replaced(",1.87,30\n", ",1.87,30,7\n")), "more values");
  holds(message_after(runs, replaced("2.62,", "-2.62,")), "at least 0");
  holds(message_after(runs, replaced("alpha,load", "load,alpha")), "line 7");
  holds(message_after(runs, [](std::string text) { return text.substr(0, text.find("10,0.3")); }),
        "missing");
  holds(message_after(runs, [](std::string text) { return text.substr(0, text.size() - 1); }),
        "cut off");
  holds(message_after("thesis-modes.csv", replaced("15,9,6", "15,9,7")), "add up");
  holds(message_after("thesis-long-run.csv", replaced("total", "sum")), "'total'");
}

// ---- windows ----

TEST(Windows, CutASeriesIntoMeansAndKeepItsEnds) {
  Windows windows;
  windows.length = 3;
  windows.count = 8;
  for (int i = 1; i <= 8; ++i) windows.take(i);
  EXPECT_EQ(windows.means, (std::vector<double>{2.0, 5.0}));
  EXPECT_EQ(windows.first, (std::vector<double>{1.0, 2.0, 3.0}));
  EXPECT_EQ(windows.last, (std::vector<double>{6.0, 7.0, 8.0}));
}

TEST(Windows, ALineHasItsSlopeAndNoErrorOfIt) {
  // 2, 5, 8, 11 at 0, 10, 20, 30: mean 6.5, slope 0.3, variance (2 (4.5^2 + 1.5^2))/3 = 15.
  const Fit fit = fit_line({2.0, 5.0, 8.0, 11.0}, 10.0);
  EXPECT_DOUBLE_EQ(fit.mean, 6.5);
  EXPECT_DOUBLE_EQ(fit.scatter, std::sqrt(15.0));
  EXPECT_DOUBLE_EQ(fit.slope, 0.3);
  EXPECT_NEAR(fit.slope_error, 0.0, 1e-15);  // rounding of residuals of order 1
  EXPECT_DOUBLE_EQ(fit.explained, 1.0);
}

TEST(Windows, ScatterAroundALineIsTheSlopesError) {
  // 1, -1, -1, 1 at 0..3: slope 0; residuals' sum of squares 4, over n - 2 = 2 and xx = 5.
  const Fit fit = fit_line({1.0, -1.0, -1.0, 1.0}, 1.0);
  EXPECT_DOUBLE_EQ(fit.slope, 0.0);
  EXPECT_DOUBLE_EQ(fit.slope_error, std::sqrt(4.0 / 2.0 / 5.0));
  EXPECT_DOUBLE_EQ(fit.explained, 0.0);
}

TEST(Windows, TooFewValuesAreNoFit) {
  EXPECT_TRUE(std::isnan(fit_line({}, 1.0).mean));
  EXPECT_TRUE(std::isnan(fit_line({1.0}, 1.0).slope));
  EXPECT_TRUE(std::isnan(fit_line({1.0, 2.0}, 1.0).slope_error));
}

// ---- the long run ----

Model::Pointer long_model() {
  // 8 to 300 rad/s at 3 ms: low and high coordinates, well inside the stable range.
  return testing::make_model(
      testing::random_strain_model(testing::spread_omega(5, 8.0, 300.0), 0.3, 4));
}

LongRunSpec long_spec(const std::string& integrator) {
  LongRunSpec spec;
  spec.model = long_model();
  spec.integrator = integrator;
  spec.steps = 2050;
  spec.sample_every = 10;
  spec.window = 40;
  spec.segment = 300;
  spec.low = 3;
  return spec;
}

LongRun uninterrupted(const LongRunSpec& spec) {
  LongRun run = start_long_run(spec);
  while (!is_over(spec, run)) advance(spec, run);
  return run;
}

class LongRunOf : public ::testing::TestWithParam<const char*> {};

TEST_P(LongRunOf, StoppedAfterEverySegmentItGivesTheSameBits) {
  const LongRunSpec spec = long_spec(GetParam());
  const LongRun whole = uninterrupted(spec);
  ASSERT_EQ(whole.exit_code, 0) << whole.reason;
  LongRun run = start_long_run(spec);
  while (!is_over(spec, run)) {
    // Through text, as in a file.
    run = long_run_from_json(nlohmann::json::parse(to_json(run).dump()));
    advance(spec, run);
  }
  EXPECT_EQ(to_json(run).dump(), to_json(whole).dump());
  EXPECT_EQ(run.done, 2050);
  EXPECT_EQ(run.total.taken, 205);
  EXPECT_EQ(run.total.means.size(), 5U);
}

TEST_P(LongRunOf, TheImpulseIsWholeWhenTheCountingStarts) {
  // The kick of an impulse J is J^2/2, whatever the method: 3 ms are short for all frequencies here
  // but the highest. A method that hands on half of a step's load with the next step must have done
  // so before the first body is left behind; half a kick would be a quarter of the energy.
  const LongRunSpec spec = long_spec(GetParam());
  LongRun run = start_long_run(spec);
  const Eigen::VectorXd force = *reduce_load(*spec.model, spec.model->default_load());
  const double kick = 0.5 * (3e-3 * force).squaredNorm();
  EXPECT_NEAR(run.reference, kick, 0.25 * kick);
  advance(spec, run);
  EXPECT_NEAR(run.total.first.front(), kick, 0.25 * kick);
}

INSTANTIATE_TEST_SUITE_P(Reproduce, LongRunOf,
                         ::testing::Values("imexv", "imexv-thesis", "newmark", "ep4"),
                         [](const auto& test) {
                           std::string name = test.param;
                           std::erase(name, '-');
                           return name;
                         });

TEST(LongRunCheckpoint, OfAnotherRunOrDamagedIsNotUsed) {
  const LongRunSpec spec = long_spec("newmark");
  const LongRun whole = uninterrupted(spec);
  const std::string path = fresh_folder() + "/run.checkpoint";
  LongRun half = start_long_run(spec);
  advance(spec, half);
  half.drift = 123.0;  // to see that it was read
  const nlohmann::json state = to_json(half);
  const nlohmann::json key{{"run", 1}};
  const auto write = [&](const std::string& sum) {
    std::ofstream(path) << nlohmann::json{{"key", key}, {"run", state}, {"checksum", sum}}.dump();
  };
  const auto no_report = [](const LongRun&) {};

  write(checksum(state.dump()));
  EXPECT_EQ(run_to_end(spec, path, key, no_report).drift, 123.0);
  EXPECT_EQ(run_to_end(spec, path, {{"run", 2}}, no_report).drift, whole.drift);
  write("0000000000000000");
  EXPECT_EQ(run_to_end(spec, path, key, no_report).drift, whole.drift);
  std::ofstream(path) << "{\"key\": ";
  EXPECT_EQ(run_to_end(spec, path, key, no_report).drift, whole.drift);
}

TEST(LongRunJson, SomethingElseIsRefused) {
  EXPECT_THROW(long_run_from_json(nlohmann::json::array()), Failure);
  EXPECT_THROW(long_run_from_json({{"done", "many"}}), Failure);
}

// ---- one run ----

TEST(Orbit, BreaksOffWithACodeWhereTheSplitIsTooBold) {
  OrbitSpec spec;
  spec.model = long_model();
  spec.integrator = "verlet";
  spec.step = 0.05;  // h omega = 15: explicit, hopeless
  const Orbit orbit = run_orbit(spec);
  EXPECT_FALSE(orbit.finished());
  EXPECT_LT(orbit.reached, spec.duration);
  EXPECT_FALSE(orbit.reason.empty());
}

TEST(Orbit, ComesBackFromItsJson) {
  OrbitSpec spec;
  spec.model = long_model();
  spec.integrator = "newmark";
  spec.duration = 0.3;
  const Orbit orbit = run_orbit(spec);
  const nlohmann::json json = fields_to_json(orbit);
  EXPECT_EQ(fields_to_json(fields_from_json<Orbit>(json)), json);
  EXPECT_EQ(orbit.steps, 100);
  EXPECT_EQ(orbit.total.t.size(), 101U);
}

// ---- names ----

// The error with which `call` fails.
Error error_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const Failure& failure) {
    return failure.error;
  }
  ADD_FAILURE() << "nothing failed";
  return {};
}

TEST(SampleModels, UnknownNamesAreUsageAndListTheKnown) {
  const Error error = error_of([] { load_sample_models("nowhere", {"cow"}); });
  EXPECT_EQ(error.kind, ErrorKind::kUsage);
  EXPECT_NE(error.message.find("basket"), std::string::npos);
  EXPECT_EQ(error_of([] {
              load_sample_models("nowhere", {"beam", "beam"});
            }).kind,
            ErrorKind::kUsage);
}

TEST(SampleModels, AMissingFileNamesTheDemo) {
  const Error error = error_of([] { load_sample_models(fresh_folder(), {"beam"}); });
  EXPECT_EQ(error.kind, ErrorKind::kSystem);
  EXPECT_NE(error.message.find("./demo"), std::string::npos);
}

TEST(SampleModels, AreNotWhereAReportWouldBeWritten) {
  namespace fs = std::filesystem;
  const std::string folder = fresh_folder();
  fs::create_directories(folder + "/models");
  fs::create_directories(folder + "/out/data");
  std::ofstream(folder + "/models/horse.tremolo") << "a model";
  std::ofstream(folder + "/out/index.html") << "a page";
  EXPECT_NO_THROW(keep_models_apart(folder + "/out", folder + "/models", {}));
  EXPECT_NO_THROW(keep_models_apart(folder + "/none", folder + "/models", {}));
  fs::create_symlink(folder + "/models/horse.tremolo", folder + "/out/data/speed.csv");
  const Error error = error_of([&] { keep_models_apart(folder + "/out", folder + "/models", {}); });
  EXPECT_EQ(error.kind, ErrorKind::kUsage);
  EXPECT_NE(error.message.find("horse.tremolo"), std::string::npos) << error.message;
  EXPECT_NO_THROW(keep_models_apart(folder + "/out", folder + "/models", {"beam"}));
}

TEST(RunNames, DifferentRunsHaveDifferentNames) {
  std::set<std::string> names;
  for (const SignalKind load : thesis::kLoads)
    for (const double alpha : thesis::kAlphas)
      for (const double multiple : {1.0, 3.0})
        for (const double step : {3e-3, 1e-3})
          for (const double duration : {30.0, 1.0})
            names.insert(RunName{"beam", "ep4", load, alpha, multiple, step, duration}.text());
  EXPECT_EQ(names.size(), 48U);
}

TEST(LoadFactors, OnlyTheSineOfBeamAndTowerIsPushedHarder) {
  for (const std::string_view model : thesis::kModels)
    for (const SignalKind load : thesis::kLoads) {
      const bool harder = load == SignalKind::kSine && (model == "beam" || model == "tower");
      EXPECT_EQ(load_factor(model, load) > 1.0, harder) << model;
    }
}

}  // namespace
}  // namespace tremolo::reproduce
