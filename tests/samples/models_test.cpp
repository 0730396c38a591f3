// The six sample models through the whole chain: committed mesh -> basis file -> motion.
#include <cmath>
#include <fstream>
#include <numbers>
#include <regex>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "common/mesh/mesh_check.h"
#include "common/mesh/mesh_quality.h"
#include "formats/basis/basis_reader.h"
#include "formats/mesh/mesh_reader.h"
#include "runtime/body.h"
#include "tests/support/run_program.h"

namespace tremolo {
namespace {

constexpr double kStep = 3e-3;  // the thesis's h, s

// Coordinates and split of the thesis's table 1.
struct Sample {
  const char* name;
  int r, low, high;
};
constexpr Sample kSamples[] = {{"beam", 15, 9, 6},  {"basket", 20, 15, 5}, {"bridge", 15, 13, 2},
                               {"horse", 15, 9, 6}, {"tower", 20, 11, 9},  {"heart", 30, 27, 3}};

std::string basis_path(const Sample& sample) {
  return std::string(TREMOLO_MODEL_DIR "/") + sample.name + ".tremolo";
}

class SampleModel : public ::testing::TestWithParam<Sample> {};

INSTANTIATE_TEST_SUITE_P(Six, SampleModel, ::testing::ValuesIn(kSamples),
                         [](const auto& sample) { return std::string(sample.param.name); });

TEST_P(SampleModel, HasAMeshOfRealisticSizeWithoutSlivers) {
  auto file =
      read_tet_mesh(std::string(TREMOLO_SOURCE_DIR "/assets/meshes/") + GetParam().name + ".msh");
  ASSERT_TRUE(file) << file.error().message;
  const auto report = check_mesh(file->mesh);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->flipped, 0u);
  EXPECT_EQ(report->unreferenced_vertices, 0u);
  EXPECT_EQ(report->parts, 1u);
  EXPECT_GE(file->mesh.tetrahedra.size(), 5000u);
  EXPECT_LE(file->mesh.tetrahedra.size(), 40000u);
  const MeshQuality quality = mesh_quality(file->mesh);
  std::printf("%-7s %6zu tets, dihedral %.1f to %.1f deg, radius ratio %.2f at worst\n",
              GetParam().name, file->mesh.tetrahedra.size(), quality.min_dihedral_deg,
              quality.max_dihedral_deg, quality.min_radius_ratio);
  EXPECT_GE(quality.min_dihedral_deg, 8.0);
}

TEST_P(SampleModel, SplitsAsInTheThesisWithAGapAtTheBoundary) {
  const auto model = Model::load(basis_path(GetParam()));
  ASSERT_TRUE(model) << model.error().message;
  ASSERT_EQ((*model)->modes(), GetParam().r);
  const auto split = choose_split((*model)->lambda(), kStep, {});
  ASSERT_TRUE(split);
  EXPECT_EQ(split->low, GetParam().low);
  EXPECT_EQ(split->high, GetParam().high);
  const double below = std::sqrt((*model)->lambda()[GetParam().low - 1]);
  const double above = std::sqrt((*model)->lambda()[GetParam().low]);
  std::printf("%-7s h w: %.3f | %.3f\n", GetParam().name, kStep * below, kStep * above);
  EXPECT_NEAR(kStep * std::sqrt(below * above), 1.8, 0.01);  // the material has three digits
  EXPECT_GE(above / below, 1.1);
}

TEST_P(SampleModel, MeetsTheResidualsThatItsFileClaims) {
  auto reader = BasisReader::open(basis_path(GetParam()));
  ASSERT_TRUE(reader) << reader.error().message;
  ASSERT_TRUE(reader->verify_all());
  const auto provenance = nlohmann::json::parse(*reader->text(basis_layout::kProvenance));
  EXPECT_LE(provenance["mass_orthonormality_error"], 1e-10);
  EXPECT_LE(provenance["polynomial_error"], 1e-12);
  EXPECT_TRUE(provenance["modes"]["certified_by_inertia"]);
  for (double residual : provenance["modes"]["residuals"]) EXPECT_LE(residual, 1e-8);
}

TEST_P(SampleModel, VibratesForThirtySecondsInItsOwnScene) {
  const std::string scene =
      std::string(TREMOLO_SOURCE_DIR "/assets/scenes/") + GetParam().name + ".toml";
  const std::string folder = testing::fresh_folder();
  const auto result = testing::run_program(
      folder, std::string(TREMOLO_BIN_DIR "/tremolo run ") + scene + " --json");
  ASSERT_EQ(result.code, 0) << result.err;
  const auto report = nlohmann::json::parse(result.out);
  EXPECT_EQ(report["integrator"], "imexv");
  EXPECT_EQ(report["steps"], 10000);
  EXPECT_EQ(report["low_modes"], GetParam().low);
  EXPECT_GT(report["energy_reference"], 0);
  std::printf("%-7s %.2f us a step, %.0f x real time, drift %.1e\n", GetParam().name,
              report["microseconds_per_step"].get<double>(),
              report["real_time_factor"].get<double>(), report["energy_drift_max"].get<double>());
}

TEST_P(SampleModel, MovesVisiblyUnderItsDefaultLoad) {
  const auto model = Model::load(basis_path(GetParam()));
  ASSERT_TRUE(model);
  ASSERT_EQ((*model)->default_load().vertices.size(), 1u);
  auto body = Body::create(*model, "imexv", {});
  ASSERT_TRUE(body);
  ASSERT_TRUE(body->add_default_load(*parse_signal("square")));
  const VertexId vertex = (*model)->default_load().vertices.front();
  double largest = 0;
  for (int step = 0; step < 1000; ++step) {
    ASSERT_TRUE(body->step().converged);
    largest = std::max(largest, body->displacement(vertex)->norm());
  }
  BoundingBox box = bounding_box((*model)->surface().rest);
  std::printf("%-7s largest deflection of the loaded vertex %.1f %% of the size\n", GetParam().name,
              100 * largest / box.diagonal());
  EXPECT_GE(largest, 0.01 * box.diagonal());
  EXPECT_LE(largest, 0.3 * box.diagonal());
}

// The strength of a frequency in the sound, by a Hann window.
double strength(const std::vector<double>& sound, double rate, double frequency) {
  const double turn = 2.0 * std::numbers::pi * frequency / rate;
  const double window = 2.0 * std::numbers::pi / static_cast<double>(sound.size());
  double re = 0.0, im = 0.0;
  for (std::size_t k = 0; k < sound.size(); ++k) {
    const double t = static_cast<double>(k);
    const double value = sound[k] * (1.0 - std::cos(window * t));
    re += value * std::cos(turn * t);
    im += value * std::sin(turn * t);
  }
  return std::hypot(re, im);
}

// The samples of a file of --wav from `from` seconds on.
std::vector<double> sound_of(const std::string& path, double from) {
  const std::string bytes = testing::slurp(path);
  std::vector<double> sound;
  for (std::size_t at = 44 + 2 * static_cast<std::size_t>(48'000.0 * from); at + 1 < bytes.size();
       at += 2)
    sound.push_back(static_cast<std::int16_t>(
        static_cast<unsigned char>(bytes[at]) |
        static_cast<unsigned>(static_cast<unsigned char>(bytes[at + 1])) << 8));
  return sound;
}

// The sound has a peak within 1 Hz of the model's frequency that is nearest to `near`.
void expect_ringing(const std::vector<double>& sound, const Model& model, double near) {
  double mode = 0.0, best = 0.0, loudest = 0.0;
  for (const double f : model.frequencies_hz())
    if (std::abs(f - near) < std::abs(mode - near)) mode = f;
  ASSERT_NEAR(mode, near, 0.5);
  for (double f = mode - 4.0; f <= mode + 4.0; f += 0.125) {
    const double here = strength(sound, 48'000.0, f);
    if (here > loudest) {
      loudest = here;
      best = f;
    }
  }
  EXPECT_NEAR(best, mode, 1.0);
  EXPECT_GT(loudest, 5.0 * strength(sound, 48'000.0, mode + 8.0)) << mode;
}

// A bell and a bar that are struck ring with their frequencies, within 1 Hz.
TEST(Sound, RingsWithTheModes) {
  struct Ring {
    const char* name;
    const char* flags;
    std::vector<double> heard;  // modes that the blow excites, Hz, near the model's
  };
  const Ring rings[] = {{"bell",
                         "--at near:100%,50%,20% --force 0,0,2 --listen near:0%,50%,20%",
                         {55.4, 94.2, 242.6, 417.5, 993.5}},
                        {"beam", "--scale 0.05 --listen near:100%,50%,100%", {9.66, 47.25}}};
  const testing::TemporaryFolder folder;
  for (const Ring& ring : rings) {
    SCOPED_TRACE(ring.name);
    const std::string path = std::string(TREMOLO_MODEL_DIR "/") + ring.name + ".tremolo";
    const auto model = Model::load(path);
    ASSERT_TRUE(model) << model.error().message;
    const testing::ProgramResult ran = testing::run_program(
        folder.path(), std::string(TREMOLO_BIN_DIR "/tremolo run ") + path + " " + ring.flags +
                           " --signal " TREMOLO_SOURCE_DIR
                           "/assets/scenes/hammer.csv "
                           "--duration 1.5 --wav sound.wav");
    ASSERT_EQ(ran.code, 0) << ran.err;
    const std::vector<double> sound = sound_of(folder.file("sound.wav"), 0.01);
    ASSERT_GT(sound.size(), 70'000U);
    for (const double near : ring.heard) expect_ringing(sound, **model, near);
  }
}

// The bench reports times; its motions must come to an end, and points must push on the plane.
TEST(Bench, MeasuresBodiesInAWorld) {
  const testing::TemporaryFolder folder;
  const testing::ProgramResult ran =
      testing::run_program(folder.path(), TREMOLO_BIN_DIR
                           "/tremolo bench --only frames --json --models-dir " TREMOLO_MODEL_DIR);
  ASSERT_EQ(ran.code, 0) << ran.err;
  const std::regex pushing("([0-9.]+) of 300 points push");
  std::size_t planes = 0;
  for (std::sregex_iterator found(ran.out.begin(), ran.out.end(), pushing), end; found != end;
       ++found, ++planes) {
    EXPECT_GT(std::stod((*found)[1]), 5.0);
    EXPECT_LT(std::stod((*found)[1]), 60.0);
  }
  EXPECT_EQ(planes, 2U);
}

// The horse's default load acts at a vertex inside; the nearest one outside is heard.
TEST(Sound, OfADefaultLoadInsideIsHeardOutside) {
  const testing::TemporaryFolder folder;
  const testing::ProgramResult ran = testing::run_program(
      folder.path(), TREMOLO_BIN_DIR "/tremolo run " TREMOLO_MODEL_DIR
                                     "/horse.tremolo --duration 0.1 --wav horse.wav");
  ASSERT_EQ(ran.code, 0) << ran.err;
  EXPECT_GT(sound_of(folder.file("horse.wav"), 0.0).size(), 700U);
}

// No blow is given here: three balls fly at the bells, contact strikes them.
TEST(Sound, BellsOfASceneRingWhenBallsHitThem) {
  const testing::TemporaryFolder folder;
  const auto model = Model::load(TREMOLO_MODEL_DIR "/bell.tremolo");
  ASSERT_TRUE(model) << model.error().message;
  const std::string command = TREMOLO_BIN_DIR "/tremolo run " TREMOLO_SOURCE_DIR
                                              "/assets/scenes/bells.toml --duration 0.8 ";
  const testing::ProgramResult bells = testing::run_program(
      folder.path(), command + "--wav bells.wav --listen bell:near:0%,50%,20%");
  ASSERT_EQ(bells.code, 0) << bells.err;
  const std::vector<double> sound = sound_of(folder.file("bells.wav"), 0.3);
  ASSERT_EQ(sound.size(), 24'000U - 1U);
  for (const double near : {55.5, 94.2}) expect_ringing(sound, **model, near);
  const testing::ProgramResult nobody =
      testing::run_program(folder.path(), command + "--wav all.wav --listen drum:near:0%,50%,20%");
  EXPECT_EQ(nobody.code, 2) << nobody.err;
  EXPECT_NE(nobody.err.find("drum"), std::string::npos) << nobody.err;
  const testing::ProgramResult slow =
      testing::run_program(folder.path(), command + "--wav all.wav --step 0.001");
  EXPECT_EQ(slow.code, 3) << slow.err;
  EXPECT_NE(slow.err.find("samples a second"), std::string::npos) << slow.err;
}

}  // namespace
}  // namespace tremolo
