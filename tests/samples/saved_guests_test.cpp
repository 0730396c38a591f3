// `tremolo run --save` and `--restore` of worlds with bodies of tetrahedra and cloths: a run that
// is divided at a random step, in the middle of contact, writes what the undivided one does from
// there on, byte for byte.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/programs.h"

namespace tremolo {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr int kGuestSteps = 100;
constexpr double kGuestStep = 0.002;

// Measurements of a run, from its own start on ("Saving and restoring a run" in
// docs/reference.md).
const std::vector<std::string> kOfTheRun = {"energy_max",
                                            "energy_balance_error",
                                            "linear_momentum_initial",
                                            "angular_momentum_initial",
                                            "energies_initial",
                                            "elements_inverted_most",
                                            "momentum_error",
                                            "elastic_momentum_error",
                                            "linear_momentum_lost",
                                            "angular_momentum_lost",
                                            "files"};
// Of reduced and rigid bodies.
const std::vector<std::string> kOfOthers = {"position_initial",
                                            "quaternion_initial",
                                            "largest_displacement",
                                            "largest_displacement_share",
                                            "largest_displacement_vertex",
                                            "largest_displacement_at",
                                            "slip_max",
                                            "penetration_surface_max",
                                            "rebound"};

bool is_guest(const json& body) {
  return body["kind"] == "tets" || body["kind"] == "cloth";
}

class SavedGuests : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    models_ = testing::fresh_folder();
    TetMesh mesh = box_mesh({2, 2, 2}, {0.1, 0.1, 0.1});
    for (Eigen::Vector3d& x : mesh.vertices) x -= Eigen::Vector3d::Constant(0.05);
    write_veg(models_ + "/cube.veg", mesh);
    for (const char* what :
         {"tets cube.veg --young 1e5 --poisson 0.3 --density 1000 --fix none -o cube.tets",
          "cube.veg --young 2e5 --poisson 0.3 --density 1000 --fix none --linear-modes 6 --modes 9 "
          "--order 1 -o cube.tremolo"}) {
      const ProgramResult made = run_program(models_, kPrecompute + what);
      ASSERT_EQ(made.code, 0) << made.err;
    }
  }

  void SetUp() override { folder_ = fresh_folder(); }

  static std::string body(const std::string& name, const std::string& kind,
                          const std::string& keys) {
    std::string text = "[[bodies]]\nname = \"" + name + "\"\nkind = \"" + kind + "\"\n";
    if (kind == "tets") text += "model = \"" + models_ + "/cube.tets\"\n";
    if (kind == "free")
      text += "model = \"" + models_ +
              "/cube.tremolo\"\nshape = \"box\"\nhalf-extents = [0.05, 0.05, 0.05]\n";
    if (kind == "rigid") text += "mass = 1\nshape = \"box\"\nhalf-extents = [0.05, 0.05, 0.05]\n";
    if (kind == "cloth")
      text +=
          "columns = 7\nrows = 7\nwidth = 0.18\nheight = 0.18\ndensity = 0.2\nthickness = 0.004\n"
          "structural = [200, 0.02]\nshear = [60, 0.02]\nbend = [2, 0.002]\n";
    return text + keys;
  }

  ProgramResult run(const std::string& flags, int steps = kGuestSteps) {
    return run_program(folder_, kTremolo + "run scene.toml " +
                                    fmt::format(" --json --step {} --duration {} ", kGuestStep,
                                                steps * kGuestStep) +
                                    flags);
  }
  std::string text_of(const std::string& name) { return slurp(folder_ + "/" + name); }

  void same_files(const std::string& name, int cut) {
    std::string tail = text_of("rest/" + name + "/run.csv");
    tail.erase(0, tail.find('\n') + 1);
    EXPECT_EQ(std::count(tail.begin(), tail.end(), '\n'), kGuestSteps - cut + 1) << name;
    EXPECT_TRUE(text_of("whole/" + name + "/run.csv").ends_with(tail)) << name;
    int count = 0;
    for (const auto& entry : fs::directory_iterator(folder_ + "/rest/" + name)) {
      const std::string file = entry.path().filename().string();
      if (!file.starts_with("surface-")) continue;
      ++count;
      EXPECT_EQ(text_of("whole/" + name + "/" + file), text_of("rest/" + name + "/" + file))
          << name << file;
    }
    EXPECT_EQ(count, 5 - 5 * cut / kGuestSteps) << name;
  }

  // Divides the run of a scene after `cut` steps.
  void divide(const std::string& scene, int cut) {
    SCOPED_TRACE(scene + fmt::format("\ndivided after step {}", cut));
    std::ofstream(folder_ + "/scene.toml") << "gravity = [0, 0, -9.81]\n" + scene;
    const ProgramResult whole = run("--out whole --surfaces 5 --save whole.saved");
    ASSERT_EQ(whole.code, 0) << whole.err;
    const ProgramResult part = run("--save cut.saved --threads 2", cut);
    ASSERT_EQ(part.code, 0) << part.err;
    const ProgramResult rest =
        run("--out rest --surfaces 5 --restore cut.saved --save rest.saved --threads 2");
    ASSERT_EQ(rest.code, 0) << rest.err;
    EXPECT_EQ(text_of("whole.saved"), text_of("rest.saved"));
    json one = json::parse(whole.out)["bodies"], other = json::parse(rest.out)["bodies"];
    ASSERT_EQ(one.size(), other.size());
    int touched = 0;
    for (std::size_t i = 0; i < one.size(); ++i) {
      same_files(one[i]["body"].get<std::string>(), cut);
      const bool guest = is_guest(one[i]);
      if (guest) touched += one[i]["contacts"].get<int>();
      for (json* report : {&one[i], &other[i]}) {
        for (const std::string& key : kOfTheRun) report->erase(key);
        for (const std::string& key : kOfOthers)
          if (!guest) report->erase(key);
      }
      EXPECT_EQ(one[i], other[i]);
    }
    EXPECT_GT(touched, 0);
    for (const char* folder : {"/whole", "/rest"}) fs::remove_all(folder_ + folder);
  }

  int cut() {
    return std::uniform_int_distribution<int>(kGuestSteps / 3, kGuestSteps - 5)(random_);
  }

  static inline std::string models_;
  std::string folder_;
  std::mt19937 random_{7};
};

const std::string kRoughFloor =
    "[[colliders]]\nname = \"floor\"\nshape = \"plane\"\nfriction = 0.4\n";

// The cube falls on a rigid and a reduced body, or on the floor, and turns.
TEST_F(SavedGuests, OfTetrahedraByEachMethodAndDegreeGoOnWithTheSameBytes) {
  const std::string below =
      body("box", "rigid", "position = [-0.051, 0, 0.0503]\nrestitution = 0\n") +
      body("soft", "free", "position = [0.051, 0, 0.0503]\nbeta = 0.001\n");
  const std::string above = "position = [0.01, 0.005, 0.157]\nspin = [0.5, 1, 0.5]\n";
  const std::string aside =
      "position = [1, 0.005, 0.07]\nspin = [1, 2, 0.5]\ndegree = \"adaptive\"\n";
  for (const std::string& keys :
       {above + "integrator = \"newmark\"\ndegree = \"quadratic\"\n",
        above + "integrator = \"midpoint\"\ndegree = \"quadratic\"\nrestitution = 0.9\n",
        above + "integrator = \"bdf2\"\ndegree = \"linear\"\nfriction = 0.8\n",
        above + "integrator = \"bdf2\"\ndegree = \"quadratic\"\nrotation-law = \"corners\"\n",
        above + "integrator = \"implicit-euler\"\ndegree = \"quadratic\"\n",
        aside + "integrator = \"newmark\"\nlook-every = 1\nleast-steps = 25\n",
        aside + "integrator = \"midpoint\"\nbeta = 0.0005\n",
        aside + "integrator = \"bdf2\"\nleast-steps = 25\nlook-every = 1\n",
        aside + "integrator = \"implicit-euler\"\nfriction = 0.8\n"})
    divide(below + body("cube", "tets", keys) + kRoughFloor, cut());
}

// While its edges change their degree, each not before it has had one for some steps.
TEST_F(SavedGuests, OfTetrahedraWhoseEdgesChangeGoOnWithTheSameBytes) {
  for (const int after : {42, 61, 65})
    divide(body("box", "rigid", "position = [3, 0, 0.0503]\n") +
               body("cube", "tets",
                    "position = [1, 0.005, 0.07]\nspin = [1, 2, 0.5]\ndegree = \"adaptive\"\n"
                    "integrator = \"bdf2\"\nleast-steps = 25\nlook-every = 1\nerror = 0.4\n") +
               kRoughFloor,
           after);
}

// In the air, where newmark has an acceleration, and the energy of both methods is guarded.
TEST_F(SavedGuests, OfTetrahedraInTheAirGoOnWithTheSameBytes) {
  for (const std::string method : {"newmark", "midpoint"})
    for (const int after : {7, 16, 31})
      divide(body("box", "rigid", "position = [1, 0, 0.0503]\n") +
                 body("cube", "tets",
                      "position = [0, 0, 0.2]\nspin = [40, 250, 10]\ndegree = \"quadratic\"\n"
                      "integrator = \"" +
                          method + "\"\n") +
                 kRoughFloor,
             after);
}

// A sheet falls on a box; two pins are released, wind and gravity change.
TEST_F(SavedGuests, OfClothByEachMethodGoOnWithTheSameBytes) {
  for (const std::string method : {"implicit-euler", "midpoint", "energy"}) {
    const std::string scene =
        "wind = [1, 0.5, 0]\ngust = 0.5\ngust-hz = 5\n" +
        body("box", "rigid", "position = [0, 0, 0.0503]\nvelocity = [0.1, 0, 0]\n") +
        body("sheet", "cloth",
             "corner = [-0.08, -0.09, 0.12]\nvelocity = [0, 0.1, -0.5]\nfriction = 0.5\n"
             "restitution = 0.3\npins = [{ at = \"top-left\", until = 0.11 }, { at = "
             "\"bottom-left\", until = 0.17 }]\nintegrator = \"" +
                 method + "\"\n") +
        kRoughFloor;
    for (const int after : {20, 70, cut()}) divide(scene, after);
  }
}

// Two cubes, a sheet over them, a rigid and a reduced body on that, and a collider that moves.
TEST_F(SavedGuests, OfAllKindsInOneIslandGoOnWithTheSameBytes) {
  const std::string scene =
      body("a", "tets",
           "position = [-0.053, 0, 0.0502]\nintegrator = \"midpoint\"\ndegree = \"quadratic\"\n") +
      body("b", "tets",
           "position = [0.053, 0.01, 0.0502]\nintegrator = \"newmark\"\ndegree = \"quadratic\"\n") +
      body("sheet", "cloth", "corner = [-0.09, -0.09, 0.1045]\nfriction = 0.5\n") +
      body("box", "rigid", "position = [-0.06, 0, 0.17]\nvelocity = [0, 0, -0.5]\n") +
      body("soft", "free", "position = [0.06, 0, 0.175]\nspin = [1, 0, 0]\nbeta = 0.001\n") +
      kRoughFloor + "motion = [{ kind = \"shake\", amplitude = [0.001, 0, 0], frequency = 8 }]\n";
  for (const int after : {30, cut()}) divide(scene, after);
}

// As it lies before its first step, and at its end.
TEST_F(SavedGuests, OfTheFirstAndTheLastStepAreTheSame) {
  const std::string scene = body("cube", "tets", "position = [0, 0, 0.052]\n") +
                            body("sheet", "cloth", "corner = [-0.09, -0.09, 0.12]\n") +
                            body("box", "rigid", "position = [1, 0, 0.06]\n") + kRoughFloor;
  for (const int after : {1, kGuestSteps}) divide(scene, after);
}

TEST_F(SavedGuests, OfAnotherSceneAreRefused) {
  const auto write = [this](const std::string& tets_keys, const std::string& cloth_keys,
                            const std::string& more = "") {
    std::ofstream(folder_ + "/scene.toml")
        << body("box", "rigid", "position = [1, 0, 0.06]\n") +
               body("cube", "tets", "position = [0, 0, 0.06]\n" + tets_keys) +
               body("sheet", "cloth", "corner = [-0.09, -0.09, 0.12]\n" + cloth_keys) + more;
  };
  write("", "");
  ASSERT_EQ(run("--save good.saved", 10).code, 0);
  const auto refused = [this](const std::string& words, const std::string& file = "good.saved") {
    const ProgramResult result = run("--out never --restore " + file);
    EXPECT_EQ(result.code, 3) << result.err;
    EXPECT_NE(result.err.find(words), std::string::npos) << words << result.err;
    EXPECT_FALSE(fs::exists(folder_ + "/never"));
  };
  for (const char* keys :
       {"velocity = [0, 0, 0.1]\n", "beta = 0.001\n", "degree = \"linear\"\n",
        "integrator = \"midpoint\"\n", "friction = 0.1\n", "contact-stiffness = 20\n"}) {
    write(keys, "");
    refused("another body 'cube'");
  }
  for (const char* keys :
       {"velocity = [0, 0, 0.1]\n", "integrator = \"midpoint\"\n", "friction = 0.1\n",
        "pins = [3]\n", "drag = 0\n", "contact-stiffness = 20\n", "crumple = 0.01\n"}) {
    write("", keys);
    refused("another body 'sheet'");
  }
  write("", "", body("more", "tets", "position = [0, 0, 1]\n"));
  refused("without body 'more', which is here");
  write("", "");
  const std::string good = text_of("good.saved");
  for (const std::size_t size : {good.size() - 1, good.size() / 2, std::size_t{100}}) {
    std::ofstream(folder_ + "/bad.saved") << good.substr(0, size);
    refused("bad.saved", "bad.saved");
  }
  std::string bad = good;
  bad[bad.size() / 2] = static_cast<char>(bad[bad.size() / 2] ^ 1);
  std::ofstream(folder_ + "/bad.saved") << bad;
  refused("bad.saved", "bad.saved");
  const ProgramResult again = run("--restore good.saved");
  EXPECT_EQ(again.code, 0) << again.err;
}

}  // namespace
}  // namespace tremolo
