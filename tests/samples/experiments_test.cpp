// `tremolo bench` and `tremolo reproduce` as a user starts them, on the sample models.
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "runtime/integrator.h"
#include "tests/support/run_program.h"

namespace tremolo {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

class Experiments : public ::testing::Test {
 protected:
  testing::ProgramResult tremolo(const std::string& words) {
    return testing::run_program(folder_.path(), TREMOLO_BIN_DIR "/tremolo " + words);
  }
  std::string at(const std::string& name) { return folder_.path() + "/" + name; }

  testing::TemporaryFolder folder_;
};

// A fraction of a second of one scene: everything that the whole bench does, once.
const std::string kSmallBench =
    "bench --models beam --models-dir '" TREMOLO_MODEL_DIR
    "' --loads square --amplitudes 0.05 --integrators ep4,newmark,verlet --steps-ms 6,3,1.5 "
    "--duration 0.36 --only precision --threads 2 --json --out small";

TEST_F(Experiments, BenchWritesItsPageAndRemembersWhatItHasDone) {
  const auto first = tremolo(kSmallBench);
  ASSERT_TRUE(first.code == 0 || first.code == 6) << first.err;  // 6: a bound was missed
  const Json report = Json::parse(first.out);
  EXPECT_FALSE(report.at("criteria").empty());
  for (const char* file : {"index.html", "report.json", "bench.csv", "cost.csv", "scenes.csv"})
    EXPECT_TRUE(fs::exists(at("small/") + file)) << file;
  const std::string rows = testing::slurp(at("small/bench.csv"));
  EXPECT_NE(rows.find("beam,square,0.05"), std::string::npos) << rows;
  const auto second = tremolo(kSmallBench);
  EXPECT_EQ(second.code, first.code);
  EXPECT_EQ(testing::slurp(at("small/bench.csv")), rows) << "a second start measured again";
}

TEST_F(Experiments, BenchOnAFullDiskSaysSoAndItsOldPageStays) {
  const auto first = tremolo(kSmallBench);
  ASSERT_TRUE(first.code == 0 || first.code == 6) << first.err;
  const std::string page = testing::slurp(at("small/index.html"));
  // A limit on the size of a file simulates a full disk.
  const auto second = testing::run_program(
      folder_.path(), "ulimit -f 32; " TREMOLO_BIN_DIR "/tremolo " + kSmallBench);
  EXPECT_EQ(second.code, 1) << second.err;
  EXPECT_NE(second.err.find("small/"), std::string::npos) << second.err;
  EXPECT_EQ(testing::slurp(at("small/index.html")), page);
}

TEST_F(Experiments, BenchRefusesWhatItDoesNotKnow) {
  const std::string models = " --models-dir '" TREMOLO_MODEL_DIR "'";
  const auto unknown = tremolo("bench --integrators leapfrog" + models);
  EXPECT_EQ(unknown.code, 2);
  for (const std::string_view name : integrator_names())
    EXPECT_NE(unknown.err.find(name), std::string::npos) << name << " is not listed";
  // A name that is no sample is that of a file in the same folder.
  const auto missing = tremolo("bench --models giraffe" + models);
  EXPECT_EQ(missing.code, 1);
  EXPECT_NE(missing.err.find("giraffe.tremolo: there is no such file"), std::string::npos);
  EXPECT_EQ(tremolo("bench --steps-ms 0" + models).code, 3);
  EXPECT_EQ(tremolo("bench --amplitudes nan" + models).code, 3);
  EXPECT_EQ(tremolo("bench --models beam --models-dir nowhere").code, 1);
  EXPECT_FALSE(fs::exists(at("build")));
}

TEST_F(Experiments, ReproduceRefusesWhatItDoesNotKnow) {
  EXPECT_EQ(tremolo("reproduce --models giraffe").code, 2);
  const auto missing = tremolo("reproduce --models-dir nowhere");
  EXPECT_EQ(missing.code, 1);
  EXPECT_NE(missing.err.find("demo"), std::string::npos) << missing.err;
}

TEST_F(Experiments, ReproduceNamesThePublishedFileThatIsMissingOrDamaged) {
  const std::string words = "reproduce --models beam --models-dir '" TREMOLO_MODEL_DIR "'";
  const auto missing = tremolo(words);
  EXPECT_EQ(missing.code, 1);
  EXPECT_NE(missing.err.find("assets/published/thesis-modes.csv"), std::string::npos)
      << missing.err;
  fs::copy(TREMOLO_SOURCE_DIR "/assets/published", at("published"));
  std::ofstream(at("published/thesis-modes.csv"), std::ios::app) << "cow,1,1,0\n";
  const auto damaged = tremolo(words + " --published published");
  EXPECT_EQ(damaged.code, 3);
  EXPECT_NE(damaged.err.find("thesis-modes.csv, line 11: unknown model cow"), std::string::npos)
      << damaged.err;
  EXPECT_FALSE(fs::exists(at("build")));
}

}  // namespace
}  // namespace tremolo
