// tremolo-precompute on several ranks: the same model, for every division of the work.
#include <filesystem>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "formats/basis/basis_reader.h"
#include "tests/support/meshes/joined_mesh.h"
#include "tests/support/programs.h"
#include "tests/support/same_model.h"

namespace tremolo {
namespace {

using testing::difference;
using testing::ModelDifference;

constexpr double kDensity = 1000;  // the default
constexpr double kSame = 1e-10;

class RanksAgree : public ::testing::Test {
 protected:
  void SetUp() override { folder_ = fresh_folder(); }

  ProgramResult run(int ranks, const std::string& arguments) {
    const std::string launcher =
        "OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 "
        "mpiexec --oversubscribe -n " +
        std::to_string(ranks) + " ";
    return run_program(folder_, launcher + TREMOLO_BIN_DIR "/tremolo-precompute " + arguments);
  }

  BasisData model(int ranks, const std::string& arguments) {
    const std::string file = "of" + std::to_string(ranks) + ".tremolo";
    const ProgramResult result = run(ranks, arguments + " --order 1 --threads 1 -o " + file);
    EXPECT_EQ(result.code, 0) << result.err;
    auto data = read_basis(folder_ + "/" + file);
    EXPECT_TRUE(data) << data.error().message;
    return std::move(*data);
  }

  void expect_same(const TetMesh& mesh, const std::string& arguments) {
    write_veg(folder_ + "/mesh.veg", mesh);
    const BasisData one = model(1, "mesh.veg " + arguments);
    for (const int ranks : {2, 4}) {
      const BasisData several = model(ranks, "mesh.veg " + arguments);
      const ModelDifference apart = difference(one, several, mesh, kDensity);
      EXPECT_LE(apart.frequency, kSame) << ranks;
      EXPECT_LE(apart.subspace, kSame) << ranks;
      EXPECT_LE(apart.energy, kSame) << ranks;
      EXPECT_LE(apart.force, kSame) << ranks;
      EXPECT_EQ(one.surface.vertex_ids, several.surface.vertex_ids);
      EXPECT_EQ(one.interior.vertex_ids, several.interior.vertex_ids);
      EXPECT_EQ(one.triangles, several.triangles);
      EXPECT_EQ(one.total_mass, several.total_mass);
    }
  }

  std::string folder_;
};

TEST_F(RanksAgree, AHeldBody) {
  expect_same(box_mesh({12, 4, 3}, {1.0, 0.21, 0.16}),
              "--fix 'x<0.001' --linear-modes 6 --modes 12");
}

TEST_F(RanksAgree, AFreeBody) {
  expect_same(box_mesh({10, 4, 3}, {1.0, 0.34, 0.23}), "--fix none --linear-modes 5 --modes 10");
}

TEST_F(RanksAgree, PartsThatDoNotTouchAndVerticesOfNoElement) {
  TetMesh mesh = box_mesh({8, 3, 3}, {1.0, 0.21, 0.16});
  mesh.vertices.emplace_back(0.5, 0.1, 0.9);
  const TetMesh second = box_mesh({7, 3, 2}, {0.8, 0.2, 0.13});
  testing::join(mesh, second, {0, 3, 0});
  expect_same(mesh, "--fix 'x<0.001' --linear-modes 6 --modes 14");
}

// Neither factor nor threads nor ranks are in the model.
TEST_F(RanksAgree, WithoutAFactorItIsTheSameModel) {
  const TetMesh mesh = box_mesh({12, 4, 3}, {1.0, 0.21, 0.16});
  for (const std::string hold : {"'x<0.001'", "none"}) {
    write_veg(folder_ + "/mesh.veg", mesh);
    const std::string arguments =
        "mesh.veg --poisson 0.3 --linear-modes 5 --modes 10 --fix " + hold;
    const BasisData direct = model(1, arguments);
    for (const int ranks : {1, 3})
      EXPECT_LE(difference(direct, model(ranks, arguments + " --solver iterative"), mesh, kDensity)
                    .largest(),
                1e-6)
          << hold << ranks;
  }
}

TEST_F(RanksAgree, MemoryIsForetoldAndEachRankTellsItsOwn) {
  write_veg(folder_ + "/mesh.veg", box_mesh({12, 4, 3}, {1.0, 0.21, 0.16}));
  const std::string arguments = "mesh.veg --fix 'x<0.001' --linear-modes 4 --modes 8 -o a.tremolo";
  const ProgramResult little = run(1, arguments + " --memory 1MB");
  EXPECT_EQ(little.code, 1) << little.err;
  EXPECT_NE(little.err.find("not enough memory"), std::string::npos) << little.err;
  EXPECT_FALSE(std::filesystem::exists(folder_ + "/a.tremolo"));
  const ProgramResult wrong = run(2, arguments + " --solver cholmod");
  EXPECT_EQ(wrong.code, 2) << wrong.err;
  const ProgramResult two = run(2, arguments + " --json");
  ASSERT_EQ(two.code, 0) << two.err;
  EXPECT_NE(two.err.find("peak memory of each rank"), std::string::npos) << two.err;
  const auto report = nlohmann::json::parse(two.out);
  EXPECT_EQ(report["ranks"], 2);
  for (const auto& stage : report["stages_of_ranks"]) {
    ASSERT_EQ(stage["peak_bytes"].size(), 2u);
    for (const double bytes : stage["peak_bytes"]) EXPECT_GT(bytes, 1e6);
  }
}

}  // namespace
}  // namespace tremolo
