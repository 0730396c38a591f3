// tremolo-precompute --checkpoint and --resume: a run that was ended at any time continues to the
// same basis file, byte for byte. Files that cannot be written or used do no harm.
#include <chrono>
#include <filesystem>
#include <functional>
#include <optional>
#include <random>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "formats/basis/basis_reader.h"
#include "formats/file/checkpoint_file.h"
#include "tests/support/meshes/symmetric_mesh.h"
#include "tests/support/programs.h"

namespace tremolo {
namespace {

namespace fs = std::filesystem;

const std::string kFew = "bar.veg -o a.tremolo --linear-modes 4 --modes 8 --order 1 ";
const std::string kHeld = "--fix 'x<0.001' ";
// In the order in which they are finished.
const std::vector<std::string> kStages = {"modes", "derivatives", "certificate", "basis",
                                          "coefficients"};

// A folder with bar.veg.
class Resume : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::canonical(fresh_folder()).string();
    write_veg(folder_ + "/bar.veg", box_mesh({12, 3, 3}, {0.4, 0.05, 0.06}));
  }

  ProgramResult run(const std::string& arguments, const std::string& before = "") {
    return run_program(folder_, before + kPrecompute + arguments);
  }

  // The Nth call of its kind in the checkpoint's folder, or at the position `at`, fails; came()
  // returns whether it happened.
  ProgramResult run_with(const std::string& fault, int number, const std::string& arguments,
                         const std::string& launcher = "", const std::string& at = "") {
    fs::remove(folder_ + "/came");
    return run(arguments, launcher +
                              "env LD_PRELOAD=" TREMOLO_FAULTY_IO
                              " ASAN_OPTIONS=verify_asan_link_order=0 TREMOLO_FAULT_AT=" +
                              (at.empty() ? checkpoint() + "/" : at) + " TREMOLO_FAULT=" + fault +
                              ":" + std::to_string(number) + " TREMOLO_FAULT_MARK=" + folder_ +
                              "/came ");
  }
  bool came() const { return fs::exists(folder_ + "/came"); }

  // Ends a run when it has kept so many stages.
  void end_after(int stages, const std::string& arguments) {
    const ProgramResult result = run_with("rename-kill", stages + 1, arguments + " --checkpoint");
    ASSERT_EQ(result.code, 137) << result.err;
    ASSERT_FALSE(fs::exists(output()));
  }

  void expect_same(const ProgramResult& result, const std::string& bytes, const std::string& what) {
    EXPECT_EQ(result.code, 0) << what << "\n" << result.err;
    EXPECT_TRUE(slurp(output()) == bytes) << what << ": another file\n" << result.err;
    EXPECT_FALSE(fs::exists(checkpoint())) << what << ": the folder stays";
    fs::remove(output());
  }

  std::string undisturbed(const std::string& arguments) {
    const ProgramResult result = run(arguments);
    EXPECT_EQ(result.code, 0) << result.err;
    std::string bytes = slurp(output());
    fs::remove(output());
    return bytes;
  }

  std::string output() const { return folder_ + "/a.tremolo"; }
  std::string checkpoint() const { return output() + ".checkpoint"; }
  std::string stage(const std::string& name) const { return checkpoint() + "/" + name + ".0"; }

  std::string folder_;
};

TEST_F(Resume, AnUndisturbedRunWithCheckpointsGivesTheSameFileAndLeavesNothing) {
  const std::string bytes = undisturbed(kFew + kHeld);
  expect_same(run(kFew + kHeld + "--checkpoint"), bytes, "--checkpoint");
  const ProgramResult result = run(kFew + kHeld + "--resume");
  EXPECT_NE(result.err.find("nothing to resume"), std::string::npos) << result.err;
  expect_same(result, bytes, "--resume of nothing");
}

#ifdef TREMOLO_LONG_TESTS
constexpr bool kLongForm = true;
#else
constexpr bool kLongForm = false;
#endif

TEST_F(Resume, ARunKilledAtRandomMomentsGivesTheSameBytes) {
  constexpr int kTrials = kLongForm ? 20 : 8;
  write_veg(folder_ + "/bar.veg", box_mesh({30, 7, 7}, {0.4, 0.05, 0.06}));
  const std::string arguments =
      "bar.veg -o a.tremolo --order 1 --linear-modes 12 --modes 24 " + kHeld;
  const auto start = std::chrono::steady_clock::now();
  const std::string bytes = undisturbed(arguments);
  const std::chrono::duration<double> whole = std::chrono::steady_clock::now() - start;
  std::mt19937 random(20);
  std::uniform_real_distribution<double> moment(0.0, whole.count());
  int kept = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const double seconds = moment(random) + 1e-3;
    const ProgramResult ended =
        run(arguments + "--checkpoint", "timeout -s KILL " + std::to_string(seconds) + " ");
    EXPECT_TRUE(ended.code == 137 || ended.code == 0) << ended.err;
    const ProgramResult resumed = run(arguments + "--resume");
    kept += resumed.err.find("from the checkpoint") != std::string::npos ? 1 : 0;
    expect_same(resumed, bytes, "killed after " + std::to_string(seconds) + " s");
  }
  EXPECT_GT(kept, 0) << "no run had kept anything";
}

// Each of them is tried in the long form, else every third.
TEST_F(Resume, ARunKilledInAnyWriteFlushOrRenameOfACheckpointGivesTheSameBytes) {
  const std::string bytes = undisturbed(kFew + kHeld);
  for (const std::string fault : {"write-kill", "fsync-kill", "rename-kill"}) {
    int number = 1;
    for (;; number += kLongForm ? 1 : 3) {
      const ProgramResult ended = run_with(fault, number, kFew + kHeld + "--checkpoint");
      if (!came()) break;
      const std::string what = fault + " " + std::to_string(number);
      EXPECT_EQ(ended.code, 137) << what;
      expect_same(run(kFew + kHeld + "--resume"), bytes, what);
    }
    EXPECT_GT(number, static_cast<int>(kStages.size())) << fault << " does not reach the stages";
  }
}

// From every stage in the long form, else each variant from one, a different one from the variant
// before it.
TEST_F(Resume, EveryWayOfSolvingGoesOnFromItsStages) {
  int way = 0;
  for (const auto& [options, stages] : std::vector<std::pair<std::string, int>>{
           {"--fix none", 5},
           {"--fix none --mass lumped --material 'x<0.2: young=1e7, density=2000, poisson=0.3'", 5},
           {kHeld + "--point-mass 'x>0.399=0.1' --no-certify --encoding compact", 4},
           {kHeld + "--linear", 3},
           {kHeld + "-- -eps_type krylovschur", 5},
           {"--fix none -- -eps_type krylovschur", 5},
           {kHeld + "--solver iterative", 4},
           {"--fix none --solver iterative", 4},
           {kHeld + "--order 2", 5},
           {kHeld + "--solver mumps", 5}}) {
    const std::string modes = options.find("--linear") == std::string::npos ? "--modes 8 " : "";
    const std::string order = options.find("--order") == std::string::npos ? "--order 1 " : "";
    const std::string arguments = "bar.veg -o a.tremolo --linear-modes 4 " + modes + order;
    const std::size_t dashes = options.find("-- ");
    const auto with = [&](const std::string& more) {
      return dashes == std::string::npos
                 ? arguments + options + more
                 : arguments + options.substr(0, dashes) + more + " " + options.substr(dashes);
    };
    const std::string bytes = undisturbed(with(""));
    const int first = kLongForm ? 0 : way++ % stages, end = kLongForm ? stages : first + 1;
    for (int stage = first; stage < end; ++stage) {
      const ProgramResult ended = run_with("rename-kill", stage + 1, with(" --checkpoint"));
      ASSERT_EQ(ended.code, 137) << options << ended.err;
      expect_same(run(with(" --resume")), bytes, options + " after " + std::to_string(stage));
    }
    run_with("rename-kill", stages + 1, with(" --checkpoint"));
    EXPECT_FALSE(came()) << options << " has more stages";
    fs::remove(output());
  }
}

// A default number of modes that is raised so as not to cut a pair.
TEST_F(Resume, AnExtendedNumberOfModesIsFoundAgain) {
  write_veg(folder_ + "/bar.veg", testing::symmetric_box({8, 2, 2}, {0.4, 0.1, 0.1}));
  const std::string arguments = "bar.veg -o a.tremolo --order 1 --modes 29 --fix 'x<-0.19' ";
  const std::string bytes = undisturbed(arguments);
  for (int done = 1; done < 5; ++done) {
    end_after(done, arguments);
    const ProgramResult result = run(arguments + "--resume");
    EXPECT_NE(result.err.find("21 linear modes, not 20"), std::string::npos) << result.err;
    expect_same(result, bytes, std::to_string(done));
  }
  end_after(2, arguments);
  const ProgramResult asked = run(arguments + "--resume --linear-modes 20");
  EXPECT_EQ(asked.code, 3);
  EXPECT_NE(asked.err.find("linear modes (20 or more there, 20 here)"), std::string::npos)
      << asked.err;
}

// The free memory may differ between runs; the user's setting is always respected.
TEST_F(Resume, TheSolverIsThatOfTheStages) {
  const std::string arguments = kFew + kHeld;
  end_after(1, arguments + "--solver iterative");
  const ProgramResult refused = run(arguments + "--resume --solver cholmod");
  EXPECT_EQ(refused.code, 3);
  EXPECT_NE(refused.err.find("solver (iterative there, cholmod here)"), std::string::npos)
      << refused.err;
  const ProgramResult result = run(arguments + "--resume");
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_NE(result.err.find("from the checkpoint"), std::string::npos) << result.err;
  const auto data = read_basis(output());
  ASSERT_TRUE(data);
  EXPECT_NE(data->provenance.find("multigrid"), std::string::npos);
}

TEST_F(Resume, AResumedRunComputesNoStageThatIsThere) {
  for (int done = 1; done < 5; ++done) {
    end_after(done, kFew + kHeld);
    const ProgramResult result = run(kFew + kHeld + "--resume --json");
    ASSERT_EQ(result.code, 0) << result.err;
    const auto stages = nlohmann::json::parse(result.out)["stages"];
    for (const auto& stage : stages) {
      const auto place =
          std::find(kStages.begin(), kStages.end(), stage["name"].get<std::string>()) -
          kStages.begin();
      if (place == 5) continue;
      EXPECT_EQ(stage["detail"].get<std::string>().ends_with("from the checkpoint"), place < done)
          << stage["name"] << " of " << done;
    }
    fs::remove(output());
  }
}

// Options that affect only the end of the run may change, and so may the threads of a small mesh.
TEST_F(Resume, WhatShapesNoStageMayBeAnotherAtTheResume) {
  for (const std::string other : {"--load-at 'x>0.399' --load-force 0,0,-1", "--encoding compact",
                                  "--no-certify", "--threads 3", "--limits"}) {
    const std::string bytes = undisturbed(kFew + kHeld + other);
    end_after(3, kFew + kHeld);
    const ProgramResult result = run(kFew + kHeld + other + " --resume");
    EXPECT_NE(result.err.find("from the checkpoint"), std::string::npos) << other << result.err;
    expect_same(result, bytes, other);
  }
}

TEST_F(Resume, AnotherMeshOrOtherOptionsAreRefusedWithWhatDiffers) {
  end_after(2, kFew + kHeld);
  const std::string kept = slurp(stage("modes"));
  write_veg(folder_ + "/other.veg", box_mesh({12, 3, 3}, {0.4, 0.05, 0.07}));
  const std::string few = "-o a.tremolo --linear-modes 4 --modes 8 ";
  for (const auto& [arguments, difference] : std::vector<std::pair<std::string, std::string>>{
           {"other.veg " + few + kHeld, "the mesh ("},
           {"bar.veg " + few + "--fix 'x>0.399'", "the fixed vertices ("},
           {"bar.veg " + few + "--fix none", "the fixed vertices ("},
           {"bar.veg " + few + kHeld + "--young 2e6", "the materials ("},
           {"bar.veg " + few + kHeld + "--density 900", "the materials ("},
           {"bar.veg " + few + kHeld + "--point-mass 'x>0.399=0.1'", "the point masses (0, "},
           {"bar.veg " + few + kHeld + "--mass lumped", "mass (consistent there, lumped here)"},
           {"bar.veg -o a.tremolo --linear-modes 5 --modes 8 " + kHeld,
            "linear modes (4 there, 5 here)"},
           {"bar.veg -o a.tremolo --linear-modes 4 --modes 9 " + kHeld,
            "coordinates (8 there, 9 here)"},
           {"bar.veg -o a.tremolo --linear-modes 4 --modes 4 --linear " + kHeld,
            "derivatives (3 there, no here)"}}) {
    const ProgramResult result = run(arguments + " --resume");
    EXPECT_EQ(result.code, 3) << arguments << result.err;
    EXPECT_NE(result.err.find(difference), std::string::npos) << difference << "\n" << result.err;
    EXPECT_NE(result.err.find("start again with --checkpoint"), std::string::npos) << result.err;
    EXPECT_EQ(slurp(stage("modes")), kept);
  }
  const ProgramResult petsc = run(kFew + kHeld + "--resume -- -eps_type krylovschur");
  EXPECT_EQ(petsc.code, 3);
  EXPECT_NE(petsc.err.find("PETSc options (none there, -eps_type krylovschur"), std::string::npos)
      << petsc.err;
  // Anew, and nothing of the old run is found.
  const std::string bytes = undisturbed("other.veg " + few + kHeld);
  expect_same(run("other.veg " + few + kHeld + "--checkpoint"), bytes, "from the start");
}

TEST_F(Resume, ADamagedStageIsToldAndComputedAgain) {
  const std::string bytes = undisturbed(kFew + kHeld);
  for (std::size_t done = 1; done < kStages.size(); ++done)
    for (std::size_t damaged = 0; damaged < done; ++damaged)
      for (const std::string what : {"cut in two", "a bit of its numbers", "its last byte"}) {
        end_after(static_cast<int>(done), kFew + kHeld);
        const std::string path = stage(kStages[damaged]);
        if (!fs::exists(path)) continue;  // the derivatives, once there is a basis
        std::string contents = slurp(path);
        const std::size_t half = contents.size() / 2;  // inside the largest array, where one is
        if (what == "cut in two")
          contents.resize(half);
        else
          contents[what == "its last byte" ? contents.size() - 1 : half] ^= 1;
        std::ofstream(path, std::ios::binary) << contents;
        const ProgramResult result = run(kFew + kHeld + "--resume");
        const bool needed = kStages[damaged] != "derivatives" || done < 4;
        EXPECT_EQ(result.err.find("the stage is computed again") != std::string::npos, needed)
            << result.err;
        expect_same(result, bytes, kStages[damaged] + " of " + std::to_string(done) + ": " + what);
      }
}

// Its checksums are right: somebody made it.
TEST_F(Resume, AStageOfOddArraysIsToldAndComputedAgain) {
  const std::string bytes = undisturbed(kFew + kHeld);
  for (const std::string odd : {"together", "vectors", "solves", "residuals"}) {
    end_after(1, kFew + kHeld);
    {
      const auto file = CheckpointFile::open(stage("modes"));
      ASSERT_TRUE(file);
      std::vector<NamedArray> arrays = file->arrays();
      for (NamedArray& array : arrays)
        if (array.name == odd) array = {array.name, array.type, 0, 1, {}};
      ASSERT_TRUE(write_checkpoint_file(stage("modes"), arrays));
    }
    const ProgramResult result = run(kFew + kHeld + "--resume");
    EXPECT_NE(result.err.find("modes.0: "), std::string::npos) << odd << result.err;
    EXPECT_NE(result.err.find("the stage is computed again"), std::string::npos) << result.err;
    expect_same(result, bytes, odd);
  }
}

TEST_F(Resume, ACheckpointThatCannotBeWrittenIsAWarningAndNoMore) {
  const std::string bytes = undisturbed(kFew + kHeld);
  for (const std::string fault : {"write-full", "open-full", "fsync-fail", "rename-fail"})
    for (const int number : {1, 2, 3}) {
      const ProgramResult result = run_with(fault, number, kFew + kHeld + "--checkpoint");
      EXPECT_TRUE(came()) << fault;
      EXPECT_NE(result.err.find("the run continues without checkpoints"), std::string::npos)
          << result.err;
      expect_same(result, bytes, fault);
    }
  for (const std::string fault : {"write-short", "write-eintr", "fsync-eintr"}) {
    const ProgramResult result = run_with(fault, 1, kFew + kHeld + "--checkpoint");
    EXPECT_EQ(result.err.find("checkpoints"), std::string::npos) << result.err;
    expect_same(result, bytes, fault);
  }
  // A file in the folder's place is left unchanged.
  std::ofstream(checkpoint()) << "a file";
  const ProgramResult result = run(kFew + kHeld + "--resume");
  EXPECT_NE(result.err.find("warning: a.tremolo.checkpoint: cannot make the folder"),
            std::string::npos)
      << result.err;
  EXPECT_EQ(result.code, 0);
  EXPECT_EQ(slurp(output()), bytes);
  EXPECT_EQ(slurp(checkpoint()), "a file");
  fs::remove(checkpoint());
  fs::remove(output());
  fs::create_symlink("a.tremolo.checkpoint", checkpoint());  // to itself
  const ProgramResult loop = run(kFew + kHeld + "--checkpoint");
  EXPECT_NE(loop.err.find("warning: a.tremolo.checkpoint: cannot make the folder"),
            std::string::npos)
      << loop.err;
  EXPECT_EQ(loop.code, 0);
  EXPECT_EQ(slurp(output()), bytes);
}

TEST_F(Resume, AnUnusedPetscOptionIsToldUnlessAStageCameFromTheCheckpoint) {
  const std::string warning = "no solver asked for the PETSc option -typo";
  const std::string typo = kFew + kHeld + "--resume -- -typo 3";
  EXPECT_NE(run(typo).err.find(warning), std::string::npos);
  fs::remove(output());
  run_with("rename-kill", 2, kFew + kHeld + "--checkpoint -- -typo 3");
  const ProgramResult resumed = run(typo);
  EXPECT_NE(resumed.err.find("from the checkpoint"), std::string::npos) << resumed.err;
  EXPECT_EQ(resumed.err.find(warning), std::string::npos);
}

TEST_F(Resume, AFailureLeavesNoHalfStageBehindAndTheFinishedOnesOfUse) {
  const std::string bytes = undisturbed(kFew + kHeld);
  // The third stage cannot be kept.
  const ProgramResult ended = run_with(
      "rename-fail", 3,
      "bar.veg -o " + output() + " --order 1 --linear-modes 4 --modes 8 --checkpoint " + kHeld, "",
      output());
  // From there on every rename fails, the output's too.
  EXPECT_EQ(ended.code, 1) << ended.err;
  EXPECT_NE(ended.err.find("the stages are kept: --resume continues from them"), std::string::npos)
      << ended.err;
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(checkpoint()))
    names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  EXPECT_EQ(names, (std::vector<std::string>{"derivatives.0", "modes.0"}));
  expect_same(run(kFew + kHeld + "--resume"), bytes, "after a failure");
}

// In a write of a stage, when there is an unfinished file.
TEST_F(Resume, SigtermLeavesFinishedStagesOnly) {
  const std::string bytes = undisturbed(kFew + kHeld);
  int number = 1;
  for (;; number += 3) {
    const ProgramResult ended = run_with("write-term", number, kFew + kHeld + "--checkpoint");
    if (!came()) break;
    const std::string what = "SIGTERM in write " + std::to_string(number);
    EXPECT_EQ(ended.code, 143) << what << ended.err;
    for (const auto& entry : fs::directory_iterator(checkpoint()))
      EXPECT_EQ(entry.path().string().find(".partial-"), std::string::npos) << entry.path();
    expect_same(run(kFew + kHeld + "--resume"), bytes, what);
  }
  EXPECT_GT(number, 10) << "nothing was ended";
}

TEST_F(Resume, TheUsersOwnFilesInTheFolderStay) {
  fs::create_directory(checkpoint());
  std::ofstream(checkpoint() + "/modes.txt") << "mine";
  EXPECT_EQ(run(kFew + kHeld + "--checkpoint").code, 0);
  EXPECT_EQ(slurp(checkpoint() + "/modes.txt"), "mine");
  EXPECT_EQ(std::distance(fs::directory_iterator(checkpoint()), fs::directory_iterator()), 1);
}

TEST_F(Resume, TheFolderMayBeALinkToWhereThereIsRoom) {
  const std::string bytes = undisturbed(kFew + kHeld);
  const std::string room = fresh_folder();
  fs::create_directory_symlink(room, checkpoint());
  const std::string fault = "rename-kill";
  EXPECT_EQ(
      run_with(fault, 3, kFew + kHeld + "--checkpoint", "", fs::canonical(room).string() + "/")
          .code,
      137);
  EXPECT_FALSE(fs::is_empty(room));
  EXPECT_EQ(run(kFew + kHeld + "--resume").code, 0);
  EXPECT_EQ(slurp(output()), bytes);
  EXPECT_TRUE(fs::is_empty(room));
  EXPECT_TRUE(fs::is_symlink(checkpoint()));
}

// MUMPS's sums depend on which message arrives first: two runs differ in their last digits anyway.
TEST_F(Resume, SeveralRanksGoOnTogetherAndAnotherNumberIsRefused) {
  const std::string mpi =
      "OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 mpiexec -n 2 --oversubscribe ";
  end_after(1, kFew + kHeld);
  const ProgramResult of_one = run(kFew + kHeld + "--resume", mpi);
  EXPECT_EQ(of_one.code, 3) << of_one.err;
  EXPECT_NE(of_one.err.find("ranks (1 there, 2 here)"), std::string::npos) << of_one.err;
  fs::remove_all(checkpoint());
  ASSERT_EQ(run(kFew + kHeld, mpi).code, 0);
  const auto good = read_basis(output());
  ASSERT_TRUE(good) << good.error().message;
  fs::remove(output());
  for (int done = 1; done < 5; ++done) {
    EXPECT_NE(run_with("rename-kill", done + 1, kFew + kHeld + "--checkpoint", mpi).code, 0);
    if (done == 1) {
      const ProgramResult refused = run(kFew + kHeld + "--resume");
      EXPECT_EQ(refused.code, 3) << refused.err;
      EXPECT_NE(refused.err.find("ranks (2 there, 1 here)"), std::string::npos) << refused.err;
    }
    const ProgramResult result = run(kFew + kHeld + "--resume", mpi);
    ASSERT_EQ(result.code, 0) << result.err;
    EXPECT_NE(result.err.find("from the checkpoint"), std::string::npos) << result.err;
    const auto found = read_basis(output());
    ASSERT_TRUE(found) << found.error().message;
    EXPECT_TRUE(found->lambda.isApprox(good->lambda, 1e-10));
    EXPECT_TRUE(found->surface.rows.isApprox(good->surface.rows, 1e-7));
    EXPECT_FALSE(fs::exists(checkpoint()));
    fs::remove(output());
  }
}

TEST_F(Resume, AnImportHasNoStages) {
  EXPECT_EQ(run(kFew + "--import-basis a.U --import-cubic a.cub --resume").code, 2);
}

}  // namespace
}  // namespace tremolo
