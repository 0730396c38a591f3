// Every sample model, held nowhere, falls on a floor with all that a scene does not say left at its
// default: with and without damping.
#include <algorithm>
#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "runtime/model.h"
#include "tests/support/programs.h"

namespace tremolo {
namespace {

using nlohmann::json;

class DroppedSample : public ::testing::TestWithParam<const char*> {};

TEST_P(DroppedSample, EndsWellAndBalances) {
  const std::string name = GetParam(), folder = fresh_folder();
  const std::string assets = TREMOLO_SOURCE_DIR "/assets/";
  const ProgramResult made = run_program(
      folder, kMayBeRoot + kPrecompute + assets + "meshes/" + name + ".msh --config " + assets +
                  "models/" + name + ".toml --fix none --order 1 --linear-modes 6 --modes 12 " +
                  "-o free.tremolo");
  ASSERT_EQ(made.code, 0) << made.err;
  const Result<Model::Pointer> model = Model::load(folder + "/free.tremolo");
  ASSERT_TRUE(model) << model.error().message;
  double lowest = 0.0;
  for (const Eigen::Vector3d& x : (*model)->surface().rest) lowest = std::min(lowest, x.z());
  for (const char* damping : {"", "alpha = 0.5\nbeta = 0.001\n"}) {
    std::ofstream(folder + "/scene.toml")
        << "duration = 1\ngravity = [0, 0, -9.81]\n[[bodies]]\nname = \"" << name
        << "\"\nmodel = \"free.tremolo\"\nkind = \"free\"\nposition = [0, 0, " << 0.1 - lowest
        << "]\n"
        << damping << "[[colliders]]\nname = \"floor\"\nshape = \"plane\"\n";
    const ProgramResult result = run_program(folder, kTremolo + "run scene.toml --json");
    ASSERT_EQ(result.code, 0) << result.err;
    const json report = json::parse(result.out);
    const json& body = report["bodies"][0];
    EXPECT_LE(report["energy_balance_error"].get<double>(), 1e-8) << damping;
    EXPECT_GT(body["contacts"].get<int>(), 0) << damping;
    // A point goes by half a margin at most beyond the surface, 0.25 % of the size, if the step
    // resolves the impact; not by ten times that.
    EXPECT_LT(body["penetration_max"].get<double>(), 0.025) << damping;
    EXPECT_LT(body["largest_displacement_share"].get<double>(), 0.5) << damping;
  }
}

INSTANTIATE_TEST_SUITE_P(Samples, DroppedSample,
                         ::testing::Values("beam", "basket", "bridge", "horse", "tower", "heart"),
                         [](const auto& sample) { return std::string(sample.param); });

}  // namespace
}  // namespace tremolo
