// tremolo-precompute on several ranks: input that is wrong, or not the same on all of them, ends
// all with one message; correct input gives the model of one rank.

#include <filesystem>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "formats/basis/basis_reader.h"
#include "tests/support/meshes/joined_mesh.h"
#include "tests/support/meshes/symmetric_mesh.h"
#include "tests/support/programs.h"
#include "tests/support/same_model.h"

namespace tremolo {
namespace {

const std::string kProgram = TREMOLO_BIN_DIR "/tremolo-precompute";
const std::string kGood =
    " -o out.tremolo --fix 'x<0.001' --linear-modes 4 --modes 8 --threads 1 --order 1";

class Ranks : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fresh_folder();
    write_veg(folder_ + "/block.veg", block_);
  }

  // RANK in the arguments becomes the number of the rank. A run that hangs has code 124.
  // environment: NAME=VALUE ..., of the program alone.
  ProgramResult run(int ranks, const std::string& arguments, const std::string& environment = "") {
    std::ofstream(folder_ + "/one_rank.sh")
        << "RANK=$OMPI_COMM_WORLD_RANK\nexec env " << environment << " " << kProgram << " "
        << replaced(arguments) << "\n";
    // As root, or with more ranks than cores, Open MPI needs explicit permission.
    return run_program(folder_,
                       "OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 timeout 60 "
                       "mpiexec --oversubscribe -n " +
                           std::to_string(ranks) + " sh one_rank.sh");
  }

  static std::string replaced(std::string text) {
    for (std::size_t at = 0; (at = text.find("RANK", at)) != std::string::npos; at += 7)
      text.replace(at, 4, "${RANK}");
    return text;
  }

  // One line of the program's says `words`; Open MPI's own follow.
  static void expect_told_once(const ProgramResult& result, int code, const std::string& words) {
    EXPECT_EQ(result.code, code) << result.err;
    const std::string start = "tremolo-precompute: ";
    const std::size_t at = result.err.find(start);
    ASSERT_NE(at, std::string::npos) << result.err;
    EXPECT_EQ(result.err.find(start, at + 1), std::string::npos) << result.err;
    EXPECT_NE(result.err.find(words, at), std::string::npos) << result.err;
  }

  TetMesh block_ = box_mesh({4, 2, 2}, {0.4, 0.15, 0.2});
  std::string folder_;
};

TEST_F(Ranks, MoreThanThereIsWorkAreRefused) {
  TetMesh two;
  two.vertices = {{0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0}, {0, 0, 0.1}, {0.1, 0.1, 0.1}};
  two.tetrahedra = {{0, 1, 2, 3}, {1, 2, 4, 3}};
  write_veg(folder_ + "/two.veg", two);
  expect_told_once(run(3, "two.veg -o out.tremolo --fix none"), 3, "3 ranks for 2 tetrahedra");
  write_veg(folder_ + "/cube.veg", box_mesh({1, 1, 1}, {0.1, 0.1, 0.1}));
  expect_told_once(run(5, "cube.veg" + kGood), 3, "5 ranks for 4 free vertices");
  const ProgramResult most = run(4, "cube.veg" + kGood);
  EXPECT_EQ(most.code, 0) << most.err;
}

TEST_F(Ranks, WithAnotherMeshAreToldWhatDiffers) {
  write_veg(folder_ + "/mesh0.veg", block_);
  write_veg(folder_ + "/mesh1.veg", block_);
  EXPECT_EQ(run(2, "meshRANK.veg" + kGood).code, 0) << "the content counts, not the path";
  TetMesh other = block_;
  other.vertices[7].x() += 1e-9;
  write_veg(folder_ + "/mesh1.veg", other);
  expect_told_once(run(2, "meshRANK.veg" + kGood), 3,
                   "rank 1: the ranks do not agree on the mesh: here 45 vertices");
}

TEST_F(Ranks, WithOtherOptionsAreToldWhichOne) {
  expect_told_once(run(2, "block.veg" + kGood + " --density 100RANK"), 3,
                   "rank 1: the ranks do not agree on --density: here 1001, on rank 0 1000");
  expect_told_once(run(2, "block.veg" + kGood + " -- -eps_max_it 10RANK"), 3, "PETSc's options");
  for (int rank : {0, 1})
    std::ofstream(folder_ + "/config" + std::to_string(rank) + ".toml")
        << "young = 1e" << 5 + rank << "\n";
  expect_told_once(run(2, "block.veg --config configRANK.toml" + kGood), 3, "on --young: here 1e6");
}

TEST_F(Ranks, OfWhichOneCannotReadItsMeshAllEnd) {
  write_veg(folder_ + "/mesh0.veg", block_);
  expect_told_once(run(2, "meshRANK.veg" + kGood), 1, "rank 1: mesh1.veg");
  std::ofstream(folder_ + "/mesh1.veg") << testing::slurp(folder_ + "/mesh0.veg").substr(0, 700);
  expect_told_once(run(2, "meshRANK.veg" + kGood), 3, "rank 1: mesh1.veg");
  expect_told_once(run(2, "missing.veg" + kGood), 1, "precompute: missing.veg");
}

TEST_F(Ranks, WithAnotherRenderSurfaceAreToldSo) {
  const auto write_triangle = [&](int number, const char* corner) {
    std::ofstream(folder_ + "/render" + std::to_string(number) + ".obj")
        << "v 0 0 0\nv 0.4 0 0\nv " << corner << "\nf 1 2 3\n";
  };
  write_triangle(0, "0.2 0.1 0.1");
  write_triangle(1, "0.2 0.1 0.1");
  const std::string arguments = "block.veg --render renderRANK.obj" + kGood;
  const ProgramResult same = run(2, arguments);
  EXPECT_EQ(same.code, 0) << same.err;
  write_triangle(1, "0.4 0.1 0.2");
  expect_told_once(run(2, arguments), 3,
                   "rank 1: the ranks do not agree on the render surface: here 3 vertices");
  expect_told_once(run(2, "block.veg $(test RANK = 1 && echo --render render1.obj)" + kGood), 3,
                   "the render surface: here 3 vertices");
}

#ifdef TREMOLO_FAULTY_MALLOC
// In the midst of the work, while a factor is shared by all: to give that back takes all ranks.
TEST_F(Ranks, OfWhichOneRunsOutOfMemoryAllEnd) {
  const TetMesh bar = box_mesh({200, 2, 2}, {2.0, 0.05, 0.06});
  write_veg(folder_ + "/bar.veg", bar);
  // As large is the space of the eigensolver; a thin body's factor is small.
  const std::size_t bytes = 8 * 200 * 3 * (bar.vertices.size() / 2 - 30);
  const std::string arguments =
      "bar.veg -o out.tremolo --fix 'x<0.001' --linear-modes 20 --modes 30 --threads 1 --order 1";
  const auto with = [&](int rank, std::size_t limit) {
    return run(2, arguments,
               "LD_PRELOAD=" TREMOLO_FAULTY_MALLOC " TREMOLO_FAULT_RANK=" + std::to_string(rank) +
                   " TREMOLO_FAULT_BYTES=" + std::to_string(limit));
  };
  EXPECT_EQ(with(1, 100 * bytes).code, 0);
  for (const int rank : {0, 1}) {
    const ProgramResult result = with(rank, bytes);
    expect_told_once(result, 1, "out of memory");
    EXPECT_NE(result.err.find("dofs, "), std::string::npos) << "too early: " << result.err;
    EXPECT_EQ(result.err.find("coordinates, |U"), std::string::npos) << "too late: " << result.err;
  }
}
#endif

TEST_F(Ranks, AnOutputThatRankZeroRefusesEndsAll) {
  expect_told_once(run(2, "block.veg --modes-vtu out.tremolo" + kGood), 2, "two outputs");
}

TEST_F(Ranks, ALoosePieceIsNamed) {
  const TetMesh cube = box_mesh({1, 1, 1}, {0.2, 0.2, 0.2});
  TetMesh edge = cube;
  testing::join(edge, cube, {0.2, 0.2, 0});
  write_veg(folder_ + "/edge.veg", edge);
  expect_told_once(run(2, "edge.veg" + kGood), 3, "moves without strain: piece 2 of 2");
}

TEST_F(Ranks, AnUnusedPetscOptionIsToldAlsoWhenTheRunFails) {
  const std::string warning = "no solver asked for the PETSc option -typo";
  const ProgramResult good = run(2, "block.veg" + kGood + " -- -typo 3");
  EXPECT_EQ(good.code, 0);
  EXPECT_NE(good.err.find(warning), std::string::npos) << good.err;
  const ProgramResult bad = run(2, "block.veg" + kGood + " -- -typo 3 -eps_ncv 5");
  expect_told_once(bad, 4, "");
  EXPECT_NE(bad.err.find(warning), std::string::npos) << bad.err;
  const ProgramResult alone =
      run_program(folder_, kProgram + " block.veg" + kGood + " -- -typo 3 -eps_ncv 5");
  expect_told_once(alone, 4, warning);
}

BasisRows all_rows(const BasisData& data) {
  BasisRows rows(data.surface.rows.rows() + data.interior.rows.rows(), data.lambda.size());
  rows << data.surface.rows, data.interior.rows;
  return rows;
}

TEST_F(Ranks, MakeTheSameModelOfASymmetricBody) {
  write_veg(folder_ + "/beam.veg", testing::symmetric_box({8, 2, 2}, {0.4, 0.1, 0.1}));
  for (const char* counts : {"--linear-modes 6 --modes 12", "--linear-modes 1 --modes 1"}) {
    const std::string rest = std::string("beam.veg --fix 'x<-0.199' ") + counts;
    ASSERT_EQ(run(1, rest + " -o one.tremolo").code, 0);
    const auto one = read_basis(folder_ + "/one.tremolo");
    for (int ranks : {2, 3}) {
      const ProgramResult several = run(ranks, rest + " -o several.tremolo");
      ASSERT_EQ(several.code, 0) << several.err;
      const auto other = read_basis(folder_ + "/several.tremolo");
      ASSERT_TRUE(one && other);
      // Another factorisation's rounding; without a choice in pairs they would be off by 1.
      EXPECT_LE((all_rows(*one) - all_rows(*other)).norm(), 1e-8 * all_rows(*one).norm());
      for (std::size_t i = 0; i < one->quartic.size(); ++i)
        EXPECT_NEAR(one->quartic[i], other->quartic[i], 1e-8 * std::abs(one->quartic[0]));
    }
  }
}

}  // namespace

// tremolo-precompute on several ranks: the same model, for every division of the work.

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
