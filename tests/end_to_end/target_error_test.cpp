// --target-error: `tremolo-precompute reference` confirms the promised error.
#include <cmath>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "formats/basis/basis_reader.h"
#include "tests/support/programs.h"

namespace tremolo {
namespace {

using nlohmann::json;

const std::string kTargetCommand = TREMOLO_BIN_DIR "/tremolo-precompute";
const std::string kAssets = TREMOLO_SOURCE_DIR "/assets";

class TargetError : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fresh_folder();
    testing::write_veg(folder_ + "/block.veg", testing::box_mesh({10, 3, 2}, {0.5, 0.1, 0.08}));
  }
  ProgramResult precompute(const std::string& body, const std::string& more) {
    return run_program(folder_,
                       kTargetCommand + " " + body + " --threads 1 -o made.tremolo --json " + more);
  }
  // Makes the file, has the reference measure it under the same load, and compares the two. Returns
  // the precomputation's JSON.
  json keep_promise(const std::string& body, double target, const std::string& more = "") {
    const ProgramResult made = precompute(body, more + " --target-error " + std::to_string(target));
    EXPECT_EQ(made.code, 0) << made.err;
    if (made.code != 0) return {};
    const ProgramResult found =
        run_program(folder_, kTargetCommand + " reference " + body +
                                 " --threads 1 --static --compare made.tremolo --json");
    EXPECT_EQ(found.code, 0) << found.err;
    if (found.code != 0) return {};
    const json promise = json::parse(made.out)["target_error"];
    const json comparison = json::parse(found.out)["comparison"];
    const double error = comparison["error_of_largest"];
    EXPECT_LE(error, target) << body;
    EXPECT_GT(error, 0.0);
    const auto agree = [](double a, double b) { EXPECT_NEAR(a, b, 1e-5 * b + 1e-9); };
    agree(promise["reached"]["displacement"], error);
    agree(promise["reached"]["tip"], comparison["tip_error_of_largest"]);
    agree(promise["reached"]["projection"], comparison["projection_of_largest"]);
    agree(promise["reached"]["unseen"], comparison["load_unseen"]);
    EXPECT_EQ(promise["reached"]["modes"], comparison["modes"]);
    const Result<BasisData> file = read_basis(folder_ + "/made.tremolo");
    EXPECT_TRUE(file);
    if (!file) return {};
    const json kept = json::parse(file->provenance)["target_error"];
    EXPECT_EQ(kept["asked"], target);
    EXPECT_EQ(kept["reached"], promise["reached"]);
    return promise;
  }
  void expect_failure(const std::string& arguments, int code, const std::string& words) {
    const ProgramResult result = precompute("block.veg", arguments);
    EXPECT_EQ(result.code, code) << arguments << "\n" << result.err;
    EXPECT_NE(result.err.find(words), std::string::npos) << result.err;
    EXPECT_FALSE(std::filesystem::exists(folder_ + "/made.tremolo")) << arguments;
  }

  static constexpr const char* kLoad = " --load-at 'x>0.499' --load-force 0,0,-40 ";
  std::string folder_;
};

std::string sample(const std::string& name) {
  return kAssets + "/meshes/" + name + ".msh --config " + kAssets + "/models/" + name + ".toml";
}

TEST_F(TargetError, IsKeptOnAClampedBlockByAsFewCoordinatesAsItTakes) {
  const std::string body =
      "block.veg --fix 'x<0.001' --load-at 'x>0.499' "
      "--load-force 0,0,-15";
  const json loose = keep_promise(body, 0.1, "--linear-modes 4"),
             tight = keep_promise(body, 0.003, "--linear-modes 4");
  EXPECT_LE(loose["reached"]["modes"], tight["reached"]["modes"]);
  // From the chosen one on all keep the target, and the one before it does not.
  const int chosen = tight["reached"]["modes"];
  double before = -1;
  for (const json& row : tight["measured"]) {
    if (row["modes"] < chosen)
      before = row["displacement"];
    else
      EXPECT_LE(row["displacement"], 0.003);
  }
  EXPECT_GT(before, 0.003);
}

TEST_F(TargetError, IsKeptOnAFreeBlock) {
  keep_promise("block.veg --fix none --load-at 'x>0.499' --load-force 0,0,-300", 0.02,
               "--linear-modes 6");
}

TEST_F(TargetError, IsKeptOnTheBeam) {
  keep_promise(sample("beam"), 0.02);
#ifdef TREMOLO_LONG_TESTS
  keep_promise(sample("beam") + " --fix none", 0.02);
#endif
}

TEST_F(TargetError, ALoadThatTheModesDoNotSeeBringsItsOwnResponse) {
  const json promise = keep_promise(
      "block.veg --fix 'x<0.001' --load-at near:0.25,0.1,0.08,1 "
      "--load-force 0,-30,0",
      0.02, "--linear-modes 3");
  EXPECT_EQ(promise["load_vectors"], 2);
  EXPECT_LE(std::abs(promise["reached"]["unseen"].get<double>()), 1e-9);
}

TEST_F(TargetError, MissedItEndsWithSixAndLeavesTheOldFile) {
  std::ofstream(folder_ + "/made.tremolo") << "old";
  const ProgramResult result = precompute(
      "block.veg", std::string("--fix 'x<0.001' --linear-modes 2") + kLoad + "--target-error 1e-9");
  EXPECT_EQ(result.code, 6) << result.err;
  EXPECT_NE(result.err.find("--target-error 1e-09 was missed: "), std::string::npos) << result.err;
  EXPECT_NE(result.err.find("was reached with 6 linear modes"), std::string::npos) << result.err;
  EXPECT_EQ(slurp(folder_ + "/made.tremolo"), "old");
}

TEST_F(TargetError, TheCoordinatesOfAConfigFileGiveWay) {
  std::ofstream(folder_ + "/block.toml") << "fix = [\"x<0.001\"]\nmodes = 3\nlinear-modes = 4\n"
                                            "load-at = \"x>0.499\"\nload-force = \"0,0,-40\"\n";
  keep_promise("block.veg --config block.toml", 0.05);
}

TEST_F(TargetError, WrongValuesAndCombinationsAreRefused) {
  const std::string good = std::string("--fix 'x<0.001'") + kLoad;
  for (const char* bad : {"0", "1", "-0.1", "nan", "inf"})
    expect_failure(good + "--target-error " + bad, 3, "must be between 0 and 1");
  expect_failure(good + "--target-error small", 2, "--target-error");
  expect_failure(good + "--target-error 0.02 --modes 9", 2, "leave --modes out");
  expect_failure(good + "--target-error 0.02 --linear", 2, "--linear");
  expect_failure(good + "--target-error 0.02 --solver iterative", 2, "not with --solver iterative");
  expect_failure(good + "--target-error 0.02 --linear-modes 59", 3, "at most 58");
  expect_failure("--fix 'x<0.001' --target-error 0.02", 3, "--load-at and --load-force");
  expect_failure("--fix 'x<0.001' --load-at 'x>0.499' --load-force 0,0,0 --target-error 0.02", 3,
                 "--load-force");
}

TEST_F(TargetError, SeveralRanksAreRefused) {
  const ProgramResult result =
      run_program(folder_,
                  "OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 timeout 60 mpiexec "
                  "--oversubscribe -n 2 " +
                      kTargetCommand + " block.veg --threads 1 -o made.tremolo --fix 'x<0.001'" +
                      kLoad + "--target-error 0.02");
  EXPECT_EQ(result.code, 2) << result.err;
  EXPECT_NE(result.err.find("--target-error works in one process"), std::string::npos)
      << result.err;
}

#ifdef TREMOLO_LONG_TESTS
TEST_F(TargetError, IsKeptOnTheSampleModelsClampedAndFree) {
  for (const char* name : {"horse", "heart", "basket", "tower", "bridge"})
    keep_promise(sample(name), 0.05);
  for (const char* name : {"horse", "heart"}) keep_promise(sample(name) + " --fix none", 0.05);
}
#endif

}  // namespace
}  // namespace tremolo
