// `tremolo-precompute reference` from the user's side: its outputs, exit codes and messages, and
// its agreement with `tremolo run` on the same reduced model.
#include <cmath>
#include <filesystem>
#include <map>
#include <sstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "formats/basis/basis_reader.h"
#include "formats/basis/basis_writer.h"
#include "tests/support/programs.h"

namespace tremolo {
namespace {

const std::string kBin = TREMOLO_BIN_DIR;

class ReferenceProgram : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fresh_folder();
    testing::write_veg(folder_ + "/block.veg", testing::box_mesh({4, 2, 2}, {0.4, 0.15, 0.2}));
  }
  ProgramResult reference(const std::string& arguments) {
    return run_program(folder_,
                       kBin + "/tremolo-precompute reference block.veg --threads 1 " + arguments);
  }
  ProgramResult precompute(const std::string& arguments) {
    return run_program(folder_, kBin + "/tremolo-precompute block.veg --threads 1 " + arguments);
  }
  void expect_failure(const std::string& arguments, int code, const std::string& words) {
    const ProgramResult result = reference(arguments);
    EXPECT_EQ(result.code, code) << arguments << "\n" << result.err;
    EXPECT_NE(result.err.find(words), std::string::npos) << result.err;
  }
  // Each list of arguments ends with the exit code and the words next to it.
  void expect_failure(std::initializer_list<std::tuple<std::string, int, std::string>> rows) {
    for (const auto& [arguments, code, words] : rows) expect_failure(arguments, code, words);
  }

  static constexpr const char* kBody = "--fix 'x<0.001' --load-at 'x>0.399' --load-force 0,0,-90 ";
  std::string folder_;
};

// The last row of a CSV as numbers, by column name.
std::map<std::string, double> last_row(const std::string& csv) {
  std::istringstream stream(csv);
  std::string names, line, row;
  std::getline(stream, names);
  while (std::getline(stream, line)) row = line;
  std::map<std::string, double> values;
  std::istringstream name_stream(names), value_stream(row);
  for (std::string name, value;
       std::getline(name_stream, name, ',') && std::getline(value_stream, value, ',');)
    values[name] = std::stod(value);
  return values;
}

TEST_F(ReferenceProgram, MotionIsReportedAndRecorded) {
  const ProgramResult result =
      reference(std::string(kBody) +
                "--load square --step 0.004 --duration 0.48 --probe 14 --out made --json");
  ASSERT_EQ(result.code, 0) << result.err;
  const auto report = nlohmann::json::parse(result.out);
  EXPECT_EQ(report["steps"], 120);
  EXPECT_EQ(report["integrator"], "avf");
  EXPECT_LE(report["energy_drift_max"], 1e-7);
  EXPECT_EQ(report["exit_code"], 0);
  const auto row = last_row(slurp(folder_ + "/made/run.csv"));
  EXPECT_NEAR(row.at("t"), 0.48, 1e-12);
  EXPECT_NEAR(row.at("total"), report["energy_final"], 1e-9 * row.at("total"));
  EXPECT_NEAR(row.at("u14z"), report["probes"][0]["displacement"][2], 1e-6);
}

TEST_F(ReferenceProgram, TheReducedModelAlongsideIsThatOfTremoloRun) {
  ASSERT_EQ(precompute(std::string(kBody) + "--linear-modes 4 --modes 8 -o block.tremolo").code, 0);
  const std::string scene = "--load square --step 0.002 --duration 0.2 --probe 14 --out ";
  const ProgramResult result =
      reference(std::string(kBody) + scene + "full --compare block.tremolo --json");
  ASSERT_EQ(result.code, 0) << result.err;
  const ProgramResult run =
      run_program(folder_, kBin + "/tremolo run block.tremolo --integrator avf --tolerance 1e-10 " +
                               scene + "reduced");
  ASSERT_EQ(run.code, 0) << run.err;
  const auto ours = last_row(slurp(folder_ + "/full/run.csv"));
  const auto theirs = last_row(slurp(folder_ + "/reduced/run.csv"));
  EXPECT_NEAR(ours.at("reduced_total"), theirs.at("total"), 1e-6 * theirs.at("total"));
  for (const char axis : {'x', 'y', 'z'})
    EXPECT_NEAR(ours.at(std::string("r14") + axis), theirs.at(std::string("u14") + axis), 1e-7);
  const auto comparison = nlohmann::json::parse(result.out)["comparison"];
  EXPECT_EQ(comparison["modes"], 8);
  EXPECT_GE(comparison["error_of_largest"], comparison["projection_of_largest"]);
  EXPECT_GT(comparison["load_unseen"], 0.0);
  EXPECT_LT(comparison["load_unseen"], 1.0);
}

TEST_F(ReferenceProgram, StaticsUnderGravityInPlaneStrain) {
  const ProgramResult result = reference(
      "--fix 'x<0.001' --fix-z 'x>=0%' --gravity 0,-9.81,0 --young 3e5 --static --probe "
      "near:0.4,0,0 --json");
  ASSERT_EQ(result.code, 0) << result.err;
  const auto report = nlohmann::json::parse(result.out);
  EXPECT_LE(report["residual"], 1e-9);
  EXPECT_LT(report["probes"][0]["displacement"][1], -1e-3);
  EXPECT_EQ(report["probes"][0]["displacement"][2], 0.0);
}

// Its elements are those of the precompute, and as stiff.
TEST_F(ReferenceProgram, LayersAcrossWallsAreTold) {
  testing::write_veg(folder_ + "/block.veg", testing::box_mesh({12, 12, 1}, {0.4, 0.4, 0.01}));
  const ProgramResult result = reference(
      "--fix 'x<0.001' --load-at 'x>0.399' --load-force 0,0,-1e-3 --static --order 1 --json");
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_NE(result.err.find("the thinnest walls, 0.01 m, are 1 layer"), std::string::npos)
      << result.err;
  const auto report = nlohmann::json::parse(result.out);
  EXPECT_NEAR(report["locking"]["layers"].get<double>(), 1.0, 0.01);
  EXPECT_GT(report["locking"]["frequency_excess"].get<double>(), 0.03);
}

TEST_F(ReferenceProgram, WrongValuesAreRefusedWithTheirName) {
  const std::string good = kBody;
  expect_failure({
      {good + "--step 0", 3, "--step must be positive"},
      {good + "--duration -1", 3, "--duration must be positive"},
      {good + "--alpha -0.1", 3, "--alpha must not be negative"},
      {good + "--beta -1e-4", 3, "--beta must not be negative"},
      {good + "--tolerance 0", 3, "--tolerance"},
      {good + "--every 0", 3, "--every"},
      {good + "--scale nan", 3, "--scale"},
      {good + "--gravity 1,2", 2, "--gravity 1,2: expected three numbers"},
      {good + "--gravity 0 0 -9.81", 2,
       "--gravity takes one word, X,Y,Z with commas: --gravity 0,0,-9.81"},
      {"--gravity 0, 0, -9.81 " + good, 2, "commas: --gravity 0,0,-9.81"},
      {good + "--gravity inf,0,0", 3, "--gravity must be finite"},
      {good + "--load drum", 2, "unknown load 'drum'"},
      {good + "--integrator euler", 2, "--integrator"},
      {good + "--probe vertex:9999", 3, "9999"},
      {good + "--modes 3", 2, "--compare"},
      {good + "--compare none.tremolo", 1, "none.tremolo"},
      {"--fix 'x<0.001'", 2, "nothing loads the body"},
      {"--fix 'x<0.001' --load square", 2, "--load needs a default load"},
      {"--fix-z 'x>=0%' --gravity 0,-1,0", 3, "3 rigid motions are left"},
      {"--fix none --fix-z 'x>=0%' --gravity 0,-1,0", 2, "contradict"},
      {"--fix 'x<0.001' --fix-z 'x>=0%' --load-at 'x>0.39' --load-force 0,0,1", 3,
       "held components only"},
  });
}

TEST_F(ReferenceProgram, TremoloPlotsItsEnergyBesideThatOfTremoloRun) {
  ASSERT_EQ(reference(std::string(kBody) + "--step 0.004 --duration 0.04 --out whole").code, 0);
  const auto plot = [this](const std::string& arguments) {
    return run_program(folder_, kBin + "/tremolo plot " + arguments);
  };
  ProgramResult result = plot("whole -o one.html");
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_NE(slurp(folder_ + "/one.html").find("total energy"), std::string::npos);
  // The band is the reduced model's alone.
  EXPECT_EQ(slurp(folder_ + "/one.html").find("high band"), std::string::npos);
  ASSERT_EQ(precompute(std::string(kBody) + "--linear-modes 3 -o block.tremolo").code, 0);
  const ProgramResult reduced = run_program(
      folder_, kBin + "/tremolo run block.tremolo --step 0.004 --duration 0.04 --out reduced");
  ASSERT_EQ(reduced.code, 0) << reduced.err;
  result = plot("whole reduced -o both.html");
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_NE(slurp(folder_ + "/both.html").find("high band"), std::string::npos);
}

TEST_F(ReferenceProgram, TheLastStepIsRecordedWhateverTheOthers) {
  ASSERT_EQ(precompute(std::string(kBody) + "--linear-modes 4 --modes 8 -o block.tremolo").code, 0);
  const ProgramResult result = reference(
      std::string(kBody) +
      "--step 0.002 --duration 0.02 --every 1000 --compare block.tremolo --out made --json");
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_NEAR(last_row(slurp(folder_ + "/made/run.csv")).at("t"), 0.02, 1e-12);
  const auto comparison = nlohmann::json::parse(result.out)["comparison"];
  EXPECT_GT(comparison["error_of_largest"], 0.0);
  EXPECT_LT(comparison["mac_least"], 1.0);
}

TEST_F(ReferenceProgram, WhatIsNotMeasuredIsNull) {
  ASSERT_EQ(
      precompute("--fix 'x<0.001' --young 3e5 --linear-modes 4 --modes 8 -o block.tremolo").code,
      0);
  const ProgramResult result = reference(
      "--fix 'x<0.001' --young 3e5 --gravity 0,0,-9.81 --static --compare block.tremolo --json");
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_NE(result.err.find("the watched vertices by not measured"), std::string::npos)
      << result.err;
  const auto comparison = nlohmann::json::parse(result.out)["comparison"];
  EXPECT_TRUE(comparison["tip_error_of_largest"].is_null());
  EXPECT_GT(comparison["error_of_largest"], 0.0);
}

TEST_F(ReferenceProgram, AFailureIsInTheJson) {
  const ProgramResult result =
      reference(std::string(kBody) + "--static --scale 1e9 --max-iterations 3 --json");
  EXPECT_EQ(result.code, 4) << result.err;
  const auto report = nlohmann::json::parse(result.out);
  EXPECT_EQ(report["exit_code"], 4);
  EXPECT_NE(report["reason"].get<std::string>().find("did not converge"), std::string::npos);
}

TEST_F(ReferenceProgram, AReducedModelThatBreaksOffTakesNothingWithIt) {
  ASSERT_EQ(precompute(std::string(kBody) + "--linear-modes 4 --modes 8 -o good.tremolo").code, 0);
  auto data = read_basis(folder_ + "/good.tremolo");
  ASSERT_TRUE(data);
  // Without a bottom: far out the force points outwards.
  for (double& q : data->quartic) q *= -1e4;
  ASSERT_TRUE(write_basis(folder_ + "/bad.tremolo", *data));
  for (const bool statics : {true, false}) {
    const std::string how = statics ? "--static" : "--load constant --step 0.004 --duration 0.08";
    const ProgramResult result =
        reference(std::string(kBody) + "--scale 20 " + how +
                  " --compare bad.tremolo --compare good.tremolo --out made --json");
    EXPECT_EQ(result.code, 4) << result.err;
    EXPECT_NE(result.err.find("tremolo-precompute: bad.tremolo: "), std::string::npos)
        << result.err;
    const auto report = nlohmann::json::parse(result.out);
    EXPECT_EQ(report["exit_code"], 4);
    EXPECT_TRUE(report["comparisons"][0]["reason"].is_string());
    EXPECT_TRUE(report["comparisons"][1]["reason"].is_null());
    EXPECT_GT(report["comparisons"][1]["error_of_largest"], 0.0);
    const auto row = last_row(slurp(folder_ + "/made/run.csv"));
    EXPECT_TRUE(std::isnan(row.at("norm")));
    EXPECT_GT(row.at("norm_2"), 0.0);
  }
}

TEST_F(ReferenceProgram, LoadNoneLeavesGravityAlone) {
  const std::string rest = "--gravity 0,0,-9.81 --static --probe 14 --json ";
  const ProgramResult none = reference(std::string(kBody) + "--load none " + rest);
  const ProgramResult without = reference("--fix 'x<0.001' " + rest);
  ASSERT_EQ(none.code, 0) << none.err;
  ASSERT_EQ(without.code, 0) << without.err;
  EXPECT_EQ(nlohmann::json::parse(none.out)["probes"],
            nlohmann::json::parse(without.out)["probes"]);
  expect_failure(std::string(kBody) + "--load none --static", 2, "nothing loads the body");
}

TEST_F(ReferenceProgram, ALoadThatDeformsNothingIsRefused) {
  const std::string words = "moves the free body as a whole and deforms nothing";
  expect_failure("--fix none --gravity 0,0,-9.81 --static", 3, words);
  expect_failure("--fix none --gravity 1,2,3", 3, words);
}

TEST_F(ReferenceProgram, AnOutputThatCannotBeWrittenIsToldBeforeTheWork) {
  std::filesystem::create_directory(folder_ + "/made");
  std::filesystem::create_directory(folder_ + "/made/run.csv");
  expect_failure(std::string(kBody) + "--out made", 1, "made/run.csv");
  EXPECT_EQ(slurp(folder_ + "/stderr.txt").find("matrices"), std::string::npos);
}

TEST_F(ReferenceProgram, ABasisOfAnotherMeshIsRefused) {
  ASSERT_EQ(precompute(std::string(kBody) + "--linear-modes 4 --modes 8 -o block.tremolo").code, 0);
  testing::write_veg(folder_ + "/block.veg", testing::box_mesh({4, 2, 2}, {0.41, 0.15, 0.2}));
  expect_failure(std::string(kBody) + "--compare block.tremolo", 3, "made of another mesh");
}

// K u of a slender bar is a small difference of large forces: its rounding is large.
TEST_F(ReferenceProgram, ASlenderBarIsTheOneItsBasisWasMadeOfAndASofterOneIsNot) {
  testing::write_veg(folder_ + "/block.veg", testing::box_mesh({400, 2, 1}, {1.0, 0.005, 0.02}));
  const std::string bar = "--poisson 0 --order 1 --fix 'x<1e-9' ";
  ASSERT_EQ(precompute(bar + "--young 1e7 --linear-modes 3 --modes 6 -o a.tremolo").code, 0);
  const std::string pushed =
      bar + "--load-at 'x>0.9999' --load-force 0,1e-3,0 --static --compare a.tremolo --young ";
  const ProgramResult same = reference(pushed + "1e7");
  EXPECT_EQ(same.code, 0) << same.err;
  expect_failure(pushed + "1.0001e7", 3, "other materials");
}

TEST_F(ReferenceProgram, WhatDoesNotConvergeEndsWithFourAndReportsHowFarItCame) {
  expect_failure(std::string(kBody) + "--static --max-iterations 1", 4, "did not converge");
  const ProgramResult result =
      reference(std::string(kBody) + "--load square --step 0.1 --max-iterations 1 --json");
  EXPECT_EQ(result.code, 4);
  const auto report = nlohmann::json::parse(result.out);
  EXPECT_EQ(report["exit_code"], 4);
  EXPECT_EQ(report["steps"], 0);
}

TEST_F(ReferenceProgram, OnlyTheReferenceHoldsSingleAxes) {
  const ProgramResult result = precompute("--fix 'x<0.001' --fix-z 'x>=0%' -o block.tremolo");
  EXPECT_EQ(result.code, 2);
  EXPECT_NE(result.err.find("--fix-z"), std::string::npos) << result.err;
  EXPECT_FALSE(std::filesystem::exists(folder_ + "/block.tremolo"));
}

}  // namespace
}  // namespace tremolo
