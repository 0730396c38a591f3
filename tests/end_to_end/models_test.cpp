// The six sample models through the whole chain: committed mesh -> basis file -> motion.
#include <cmath>
#include <fstream>
#include <numbers>

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

}  // namespace
}  // namespace tremolo
