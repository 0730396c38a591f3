// A folder in which tests start tremolo-precompute, with a mesh and an older output in it.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/programs.h"

namespace tremolo {

inline const std::string kOld = "an older file that must survive";

// A folder with block.veg and an existing out.tremolo.
class PrecomputeFolder : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fresh_folder();
    write_veg(folder_ + "/block.veg", block_);
    std::ofstream(folder_ + "/out.tremolo") << kOld;
  }

  ProgramResult run(const std::string& arguments) {
    return run_program(folder_, kPrecompute + arguments);
  }

  // The JSON that a run prints that succeeds.
  nlohmann::json report_of(const std::string& arguments) {
    const ProgramResult result = run(arguments + " --json");
    EXPECT_EQ(result.code, 0) << result.err;
    return nlohmann::json::parse(result.out, nullptr, false);
  }

  // Writes a changed block and runs on it.
  ProgramResult run_on(const TetMesh& mesh, const std::string& arguments = kGood) {
    write_veg(folder_ + "/changed.veg", mesh);
    return run("changed.veg " + arguments);
  }

  void expect_failure(const ProgramResult& result, int code, const std::string& words) {
    EXPECT_EQ(result.code, code) << result.err;
    EXPECT_NE(result.err.find(words), std::string::npos) << result.err;
    EXPECT_EQ(slurp(folder_ + "/out.tremolo"), kOld) << "the old output was touched";
    for (const auto& entry : std::filesystem::directory_iterator(folder_))
      EXPECT_EQ(entry.path().string().find(".partial"), std::string::npos) << entry.path();
  }

  static constexpr const char* kGood =
      "-o out.tremolo --fix 'x<0.001' --linear-modes 4 --modes 8 --threads 1";
  const std::string kBlock = std::string("block.veg ") + kGood;
  TetMesh block_ = box_mesh({4, 2, 2}, {0.4, 0.15, 0.2});
  std::string folder_;
};

}  // namespace tremolo
