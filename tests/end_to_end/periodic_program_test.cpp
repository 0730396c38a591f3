// `tremolo response` and `tremolo backbone` as a user starts them, on a small model in closed form.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "formats/basis/basis_writer.h"
#include "runtime/tremolo.h"
#include "tests/support/programs.h"
#include "tests/support/sample_basis.h"

namespace tremolo {
namespace {

using Json = nlohmann::json;

// Three coordinates from 1 to 5 rad/s, small amplitudes; vertex 0 is fixed, the load is at 3.
class PeriodicProgram : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fresh_folder();
    BasisData data = testing::sample_basis(
        testing::random_strain_model(testing::spread_omega(3, 6.0, 30.0), 0.3, 3));
    ASSERT_TRUE(write_basis(folder_ + "/small.tremolo", data));
  }
  ProgramResult run(const std::string& arguments) {
    return run_program(folder_, kTremolo + arguments);
  }
  Json json_of(const std::string& arguments, int code = 0) {
    const ProgramResult result = run(arguments + " --json");
    EXPECT_EQ(result.code, code) << arguments << "\n" << result.err;
    EXPECT_TRUE(result.out.starts_with("{\n  \"schema\": 1")) << result.out.substr(0, 80);
    return Json::parse(result.out, nullptr, false);
  }
  void refused(const std::string& arguments, int code, const std::string& word) {
    const ProgramResult result = run(arguments);
    EXPECT_EQ(result.code, code) << arguments << "\n" << result.err;
    EXPECT_NE(result.err.find(word), std::string::npos) << arguments << "\n" << result.err;
  }
  std::string folder_;
};

const std::string kResponse =
    "response small.tremolo --load-scale 0.2 --damping-ratio 2% --from 0.6 --to 1.5";

TEST_F(PeriodicProgram, AResponseHasTheKeysOfTheReference) {
  const Json json = json_of(kResponse + " --probe 3 --harmonics 4");
  for (const char* key : {"points", "folds", "bifurcations", "seconds", "peak", "end"})
    EXPECT_TRUE(json.contains(key)) << key;
  EXPECT_EQ(json["probe"], 3);
  EXPECT_EQ(json["end"], "done");
  ASSERT_GT(json["points"].size(), 20U);
  double largest = 0.0;
  for (const Json& point : json["points"]) {
    EXPECT_TRUE(point["stable"].is_boolean());
    EXPECT_GE(point["harmonics"].get<int>(), 4);
    EXPECT_EQ(point["harmonic_amplitudes"].size(), point["harmonics"].get<std::size_t>() + 1);
    largest = std::max(largest, point["amplitude"].get<double>());
  }
  EXPECT_EQ(json["peak"]["amplitude"], largest);
  EXPECT_NEAR(json["points"].front()["frequency_hz"].get<double>(), 0.6, 1e-12);
  // The end is sought until it is within 1e-11.
  EXPECT_NEAR(json["points"].back()["frequency_hz"].get<double>(), 1.5, 3e-11);
}

TEST_F(PeriodicProgram, OfALinearModelPhaseAndAmplitudeAreThoseOfOneOscillatorNearResonance) {
  const double omega = 6.0, zeta = 0.02;
  const Json json = json_of(
      "response small.tremolo --linear --modes 1 --load-scale 1e-3 --damping-ratio 2% --from 0.5 "
      "--to 2");
  const double peak = json["peak"]["amplitude"];
  const double static_amplitude = peak * 2.0 * zeta * std::sqrt(1.0 - zeta * zeta);
  for (const Json& point : json["points"]) {
    const double x = 2.0 * std::acos(-1.0) * point["frequency_hz"].get<double>() / omega;
    const double lag = std::atan2(2.0 * zeta * x, 1.0 - x * x) * 180.0 / std::acos(-1.0);
    EXPECT_NEAR(point["phase_deg"].get<double>(), lag, 1e-8);
    const double gain = 1.0 / std::hypot(1.0 - x * x, 2.0 * zeta * x);
    // The peak lies between two points.
    EXPECT_NEAR(point["amplitude"].get<double>(), static_amplitude * gain, 0.01 * peak);
  }
}

TEST_F(PeriodicProgram, SeveralLevelsAreACurveEachAndFilesHoldThem) {
  const Json json = json_of(
      "response small.tremolo --load-scale 0.05,0.1,0.2 --damping-ratio 3% --from 0.6 --to "
      "1.5 --out made --csv table.csv");
  ASSERT_EQ(json["curves"].size(), 3U);
  double before = 0.0;
  std::size_t points = 0;
  for (const Json& curve : json["curves"]) {
    EXPECT_GT(curve["peak"]["amplitude"].get<double>(), before);
    before = curve["peak"]["amplitude"];
    points += curve["points"].size();
  }
  const std::string table = slurp(folder_ + "/table.csv");
  EXPECT_EQ(static_cast<std::size_t>(std::count(table.begin(), table.end(), '\n')), points + 1);
  EXPECT_EQ(table, slurp(folder_ + "/made/response.csv"));
  EXPECT_EQ(Json::parse(slurp(folder_ + "/made/response.json"))["curves"].size(), 3U);
  const std::string page = slurp(folder_ + "/made/response.html");
  EXPECT_NE(page.find("load x 0.05"), std::string::npos);
  EXPECT_EQ(page.find("https://"), std::string::npos);
}

TEST_F(PeriodicProgram, ABackboneBeginsAtTheModesFrequencyAndEndsAtTheAmplitude) {
  for (const std::string mode : {"1", "2"}) {
    const Json json =
        json_of("backbone small.tremolo --mode " + mode + " --to-amplitude 5% --page b.html");
    EXPECT_EQ(json["end"], "done");
    const double linear = json["linear_frequency_hz"];
    EXPECT_NEAR(json["points"].front()["frequency_hz"].get<double>(), linear, 1e-5 * linear);
    EXPECT_NEAR(json["points"].back()["amplitude"].get<double>(), 0.05 * json["size"].get<double>(),
                1e-9);
    for (const Json& point : json["points"]) EXPECT_GT(point["energy"].get<double>(), 0.0);
  }
}

// f / f_0 of a clamped beam of rectangular section whose ends cannot approach (Woinowsky-Krieger),
// vibrating in its first mode, by the amplitude in the middle relative to the height: the elliptic
// integral for q'' + w^2 q + g q^3 = 0, g = E A / (2 L) (int phi'^2)^2.
double clamped_beam(double amplitude_to_height) {
  const double be = 4.730040744862704;
  const double s = (std::cosh(be) - std::cos(be)) / (std::sinh(be) - std::sin(be));
  const auto phi = [&](double x) {
    return std::cosh(be * x) - std::cos(be * x) - s * (std::sinh(be * x) - std::sin(be * x));
  };
  const auto slope = [&](double x) {
    return be * (std::sinh(be * x) + std::sin(be * x) - s * (std::cosh(be * x) - std::cos(be * x)));
  };
  constexpr int kParts = 2000;
  double mass = 0.0, stretch = 0.0;
  for (int i = 0; i < kParts; ++i) {
    const double x = (i + 0.5) / kParts;
    mass += std::pow(phi(x), 2) / kParts;
    stretch += std::pow(slope(x), 2) / kParts;
  }
  // g a^2 / w^2 = (12 / 2) (A / h)^2 (int phi'^2)^2 / (phi(1/2)^2 beta^4 int phi^2).
  const double ratio =
      6.0 * std::pow(amplitude_to_height * stretch / (phi(0.5) * be * be), 2) / mass;
  double a = 1.0, b = std::sqrt(1.0 - 0.5 * ratio / (1.0 + ratio));
  for (int i = 0; i < 40; ++i) {
    const double mean = 0.5 * (a + b);
    b = std::sqrt(a * b);
    a = mean;
  }
  return std::sqrt(1.0 + ratio) * a;
}

TEST_F(PeriodicProgram, AClampedBeamHardensAsWoinowskyKriegersDoes) {
  write_veg(folder_ + "/beam.veg", box_mesh({60, 1, 1}, {1.0, 0.02, 0.01}));
  const ProgramResult made = run_program(
      folder_, kMayBeRoot + kPrecompute +
                   "beam.veg --young 1e9 --poisson 0 --density 1000 --fix 'x<0.00001' --fix "
                   "'x>0.99999' --order 2 --linear-modes 8 --modes 24 --threads 1 -o beam.tremolo");
  ASSERT_EQ(made.code, 0) << made.err;
  const Json json =
      json_of("backbone beam.tremolo --to-amplitude 0.01m --probe near:0.5,0.01,0.005");
  const double linear = json["linear_frequency_hz"];
  for (const Json& point : json["points"]) {
    const double to_height = point["amplitude"].get<double>() / 0.01;
    // Its own change of shape, which the closed form leaves out, is 0.1 % at an amplitude of h.
    EXPECT_NEAR(point["frequency_hz"].get<double>() / linear, clamped_beam(to_height), 2e-3);
  }
  EXPECT_GT(json["points"].back()["frequency_hz"].get<double>(), 1.2 * linear);
}

TEST_F(PeriodicProgram, TimeSteppingSettlesOntoTheStablePoints) {
  const Json json = json_of(kResponse + " --by-stepping");
  const Json& stepped = json["by_stepping"];
  std::size_t stable = 0;
  for (const Json& point : json["points"]) stable += point["stable"].get<bool>() ? 1 : 0;
  EXPECT_EQ(stepped["points"], stable);
  EXPECT_EQ(stepped["points_elsewhere"], 0);
  // Settled to 1e-4 with steps that are good for 1e-4; harmonics hold all but 1e-3 of a motion, of
  // which the amplitude has the smaller part.
  EXPECT_GT(stepped["largest_difference"].get<double>(), 0.0);
  EXPECT_LE(stepped["largest_difference"].get<double>(), 1e-3);
  EXPECT_GT(stepped["periods"].get<double>(), 10.0 * static_cast<double>(stable));
  EXPECT_GT(stepped["ratio"].get<double>(), 0.0);
}

TEST_F(PeriodicProgram, AnOrbitIsAFileOfOnePeriod) {
  const Json json = json_of(
      "backbone small.tremolo --to-amplitude 5% --orbit o.glb --orbit o.pc2 --orbit s.ply "
      "--orbit-at 3% --orbit-frames 16 --orbit-seconds 2");
  const Json& orbit = json["orbit"];
  EXPECT_NEAR(orbit["amplitude"].get<double>(), 0.03 * json["size"].get<double>(), 1e-12);
  EXPECT_EQ(orbit["frames"], 17);
  EXPECT_NEAR(orbit["period"].get<double>() * orbit["frequency_hz"].get<double>(), 1.0, 1e-12);
  EXPECT_TRUE(slurp(folder_ + "/o.glb").starts_with("glTF"));
  // A surface for each frame; the last is the first again, and the one between is another.
  EXPECT_EQ(slurp(folder_ + "/s-0000.ply"), slurp(folder_ + "/s-0016.ply"));
  EXPECT_NE(slurp(folder_ + "/s-0000.ply"), slurp(folder_ + "/s-0008.ply"));
  // PC2: a head of 32 bytes with the number of vertices at 16, then x, y, z of every vertex.
  const std::string cache = slurp(folder_ + "/o.pc2");
  std::int32_t vertices = 0;
  std::memcpy(&vertices, cache.data() + 16, sizeof(vertices));
  ASSERT_EQ(cache.size(), 32U + 17U * 12U * static_cast<std::size_t>(vertices));
  const auto at = [&](int frame, int number) {
    float value = 0.0f;
    std::memcpy(&value, cache.data() + 32 + 4 * (3 * frame * vertices + number), sizeof(value));
    return static_cast<double>(value);
  };
  // The probe is among the vertices: no other one moves farther than its amplitude twice, and the
  // turning points of the cosine are frames 0 and 8.
  double most = 0.0;
  for (int v = 0; v < vertices; ++v) {
    double square = 0.0;
    for (int axis = 0; axis < 3; ++axis)
      square += std::pow(at(0, 3 * v + axis) - at(8, 3 * v + axis), 2);
    most = std::max(most, std::sqrt(square));
  }
  EXPECT_GT(most, 1.5 * orbit["amplitude"].get<double>());
  EXPECT_LT(most, 2.5 * orbit["amplitude"].get<double>());
  // Of a response by its frequency, and its largest one.
  const Json peak = json_of(kResponse + " --orbit p.html");
  EXPECT_EQ(peak["orbit"]["amplitude"], peak["peak"]["amplitude"]);
  const Json there = json_of(kResponse + " --orbit p.usda --orbit-at 0.8Hz");
  EXPECT_NEAR(there["orbit"]["frequency_hz"].get<double>(), 0.8, 0.05);
}

TEST_F(PeriodicProgram, WrongOrbitsAreNamed) {
  refused(kResponse + " --orbit o.stl", 2, ".stl");
  refused(kResponse + " --orbit-at 0.8Hz", 2, "--orbit");
  refused(kResponse + " --orbit o.glb --orbit-at soon", 2, "soon");
  refused(kResponse + " --orbit o.glb --orbit-at -1Hz", 3, "positive");
  refused(kResponse + " --orbit o.glb --orbit-frames 2", 3, "--orbit-frames");
  refused(kResponse + " --orbit o.glb --orbit-seconds -1", 3, "--orbit-seconds");
  refused(kResponse + " --orbit o.glb --orbit-at 9Hz", 3, "0.6 to 1.5");
  refused(kResponse + " --orbit o.glb --orbit-at 90%", 3, "largest");
  // A motion that is not on the curve leaves no file of the command.
  refused(kResponse + " --out off --csv off.csv --page off.html --orbit o.glb --orbit-at 90%", 3,
          "largest");
  for (const char* name : {"off", "off.csv", "off.html", "o.glb"})
    EXPECT_FALSE(std::filesystem::exists(folder_ + "/" + name)) << name;
  refused(kResponse + " --orbit nowhere/o.glb", 1, "nowhere");
  refused(kResponse + " --by-stepping --no-stability", 2, "--no-stability");
  refused(kResponse + " --by-stepping --load-harmonic 2:1", 2, "--load-harmonic");
  refused("response small.tremolo --from 0.6 --to 0.8 --by-stepping", 2, "damping");
}

// The curve of the C interface has the points of the report.
void same_points(const tremolo_curve* curve, const Json& report) {
  ASSERT_EQ(tremolo_curve_points(curve), report["points"].size());
  std::size_t i = 0;
  for (const Json& expected : report["points"]) {
    tremolo_curve_point point;
    ASSERT_EQ(tremolo_curve_point_at(curve, i++, &point), TREMOLO_OK);
    EXPECT_EQ(point.frequency_hz, expected["frequency_hz"].get<double>());
    EXPECT_EQ(point.amplitude, expected["amplitude"].get<double>());
    EXPECT_EQ(point.energy, expected["energy"].get<double>());
    const Json stable = point.stable < 0 ? Json(nullptr) : Json(point.stable == 1);
    EXPECT_EQ(stable, expected["stable"]);
    if (expected.contains("load_scale")) {
      EXPECT_EQ(point.load_scale, expected["load_scale"].get<double>());
    }
  }
}

TEST_F(PeriodicProgram, TheCInterfaceGivesTheSameCurves) {
  const std::string span = " --damping-ratio 1% --from 0.6 --to 1.5 --load-scale 1.6";
  tremolo_model* model = nullptr;
  ASSERT_EQ(tremolo_model_load((folder_ + "/small.tremolo").c_str(), 0, &model), TREMOLO_OK);
  tremolo_curve_options options;
  tremolo_curve_options_init(&options);
  options.damping_ratio = "1%";
  options.mode = 2;
  tremolo_curve *ridge = nullptr, *response = nullptr, *folds = nullptr;
  const Json damped =
      json_of("backbone small.tremolo --mode 2 --damped --damping-ratio 1% --to-amplitude 5%");
  const double amplitude = 0.05 * damped["size"].get<double>();
  ASSERT_EQ(tremolo_damped_backbone(model, &options, amplitude, &ridge), TREMOLO_OK);
  same_points(ridge, damped);

  options.mode = 1;
  options.load_scale = 1.6;
  const tremolo_load_harmonic course[] = {{1, 0, 1.0, 0.0}, {2, 0, 0.2, 90.0}};
  options.load_harmonics = course;
  options.load_harmonic_count = 2;
  const Json forced = json_of("response small.tremolo" + span +
                              " --load-harmonic 1:1 --load-harmonic 2:0.2:90 --folds-to 2");
  ASSERT_EQ(tremolo_response(model, &options, 0.6, 1.5, &response), TREMOLO_OK);
  same_points(response, forced);
  ASSERT_FALSE(forced["fold_curves"].empty());
  std::size_t known = 0;
  for (std::size_t i = 0; i < tremolo_curve_bifurcations(response); ++i) {
    tremolo_bifurcation at;
    ASSERT_EQ(tremolo_curve_bifurcation_at(response, i, &at), TREMOLO_OK);
    if (at.kind != TREMOLO_FOLD) continue;
    ASSERT_EQ(tremolo_fold_curve(response, i, 2.0, &folds), TREMOLO_OK) << tremolo_last_error();
    same_points(folds, forced["fold_curves"][known++]);
    tremolo_curve_destroy(folds);
  }
  EXPECT_EQ(known, forced["fold_curves"].size());
  tremolo_curve_destroy(response);
  tremolo_curve_destroy(ridge);
  tremolo_model_release(model);
}

TEST_F(PeriodicProgram, WrongInputIsNamed) {
  const std::string damped = "response small.tremolo --damping-ratio 2% ";
  refused(damped + "--from 0 --to 2", 3, "zero frequency");
  refused(damped + "--from 1 --to -2", 3, "--to -2");
  refused(damped + "--from 1 --to 1", 3, "same");
  refused(damped + "--from 1", 2, "--to");
  refused(damped + "--from 1 --to 2 --probe 0", 3, "fixed");
  refused(damped + "--from 1 --to 2 --probe 99", 3, "99");
  refused(damped + "--from 1 --to 2 --harmonics 0", 3, "--harmonics");
  refused(damped + "--from 1 --to 2 --load-scale 0", 3, "--load-scale");
  refused(damped + "--from 1 --to 2 --folds-to 0", 3, "--folds-to");
  refused(damped + "--from 1 --to 2 --load-scale 1,,2", 2, "commas");
  refused(damped + "--from 1 --to 2 --load-scale 1,x", 2, "commas");
  refused(damped + "--from 1 --to 2 --load-harmonic 0:1", 3, "--static-scale");
  refused(damped + "--from 1 --to 2 --load-harmonic x", 2, "K:SCALE");
  refused(damped + "--from 1 --to 2 --alpha 1", 2, "--alpha");
  refused(damped + "--from 1 --to 2 --page page.png", 2, ".html");
  refused(damped + "--from 1 --to 2 --csv small.tremolo", 2, "small.tremolo");
  refused("response small.tremolo --damping-ratio 120% --from 1 --to 2", 3, "critical damping");
  refused("response scene.toml --from 1 --to 2", 2, "basis file");
  refused("response none.tremolo --from 1 --to 2", 1, "none.tremolo");
  refused("backbone small.tremolo --mode 4", 3, "modes 1 to 3");
  refused("backbone small.tremolo --to-amplitude x", 2, "10%");
  refused("backbone small.tremolo --to-amplitude 0%", 3, "positive");
}

// The amplitude of a free body leaves its rigid motion out, which a reader must know.
TEST_F(PeriodicProgram, AFreeBodySaysThatRigidMotionIsLeftOut) {
  BasisData data = testing::sample_basis(
      testing::random_strain_model(testing::spread_omega(3, 6.0, 30.0), 0.3, 3));
  data.rigid_mode_count = 6;
  ASSERT_TRUE(write_basis(folder_ + "/free.tremolo", data));
  const std::string command =
      "response free.tremolo --load-scale 0.1 --damping-ratio 2% --from 0.6 --to 0.8";
  const Json json = json_of(command);
  EXPECT_EQ(json["rigid_modes"], 6);
  ASSERT_FALSE(json["warnings"].empty());
  EXPECT_NE(json["warnings"][0].get<std::string>().find("a free body"), std::string::npos);
  refused(command + " --gravity 0,0,-9.81", 3, "free body");
  EXPECT_EQ(
      json_of("response small.tremolo --load-scale 0.1 --damping-ratio 2% --from 0.6 --to 0.8")
          ["rigid_modes"],
      0);
}

TEST_F(PeriodicProgram, AdviceNamesFlagsThatThereAre) {
  BasisData data = testing::sample_basis(
      testing::random_strain_model(testing::spread_omega(3, 6.0, 30.0), 0.3, 3));
  data.load = {};
  ASSERT_TRUE(write_basis(folder_ + "/unloaded.tremolo", data));
  const ProgramResult result = run("response unloaded.tremolo --from 1 --to 2");
  EXPECT_EQ(result.code, 2);
  EXPECT_NE(result.err.find("--at and --force"), std::string::npos) << result.err;
  EXPECT_EQ(result.err.find("--load none"), std::string::npos) << result.err;
}

// A load of which no motion is found takes nothing from the others.
TEST_F(PeriodicProgram, ACurveThatIsNotFoundLeavesTheOthers) {
  const Json json = json_of(
      "response small.tremolo --load-scale 0.05,1e9,0.1 --damping-ratio 3% --from 0.6 --to 1.5 "
      "--out made",
      4);
  ASSERT_EQ(json["curves"].size(), 3U);
  for (const int found : {0, 2}) {
    EXPECT_EQ(json["curves"][found]["end"], "done");
    EXPECT_GT(json["curves"][found]["points"].size(), 10U);
  }
  const Json& none = json["curves"][1];
  EXPECT_TRUE(none["points"].empty());
  EXPECT_EQ(none["end"], "stuck");
  EXPECT_EQ(none["exit_code"], 4);
  EXPECT_NE(none["reason"].get<std::string>().find("at 0.6 Hz"), std::string::npos);
  EXPECT_EQ(Json::parse(slurp(folder_ + "/made/response.json"))["curves"].size(), 3U);
  EXPECT_NE(slurp(folder_ + "/made/response.html").find("load x 1e+09: no point"),
            std::string::npos);
  refused(
      "response small.tremolo --load-scale 1e9 --damping-ratio 3% --from 0.6 --to 1.5 --orbit "
      "o.ply",
      4, "has no motion");
}

TEST_F(PeriodicProgram, ACuspHasTheLoadFromWhichOnTheResponseJumps) {
  const std::string command = "response small.tremolo --damping-ratio 0.5% --from 0.6 --to 1.5 ";
  const Json json = json_of(command + "--load-scale 1 --folds-to 0.01");
  ASSERT_EQ(json["fold_curves"].size(), 2U);
  for (const Json& curve : json["fold_curves"]) {
    ASSERT_EQ(curve["folds"].size(), 1U);
    ASSERT_TRUE(curve["folds"][0].contains("load_scale"));
    const double cusp = curve["folds"][0]["load_scale"];
    const auto folds = [&](double scale) {
      return json_of(command + "--load-scale " + std::to_string(scale))["folds"].size();
    };
    EXPECT_EQ(folds(0.97 * cusp), 0U);
    EXPECT_EQ(folds(1.05 * cusp), 2U);
  }
}

TEST_F(PeriodicProgram, WithoutDampingTheResponseIsReportedAsUnboundedWithItsPoints) {
  const Json json =
      json_of("response small.tremolo --linear --load-scale 0.1 --from 0.6 --to 1.5", 5);
  EXPECT_EQ(json["end"], "unbounded");
  EXPECT_GT(json["points"].size(), 10U);
  EXPECT_NE(json["reason"].get<std::string>().find("unbounded"), std::string::npos);
}

TEST_F(PeriodicProgram, TooFewHarmonicsAreReported) {
  const Json json = json_of(kResponse + " --harmonics 1 --most-harmonics 2 --harmonic-share 1e-6");
  ASSERT_EQ(json["warnings"].size(), 1U);
  EXPECT_NE(json["warnings"][0].get<std::string>().find("--most-harmonics"), std::string::npos);
}

}  // namespace
}  // namespace tremolo
