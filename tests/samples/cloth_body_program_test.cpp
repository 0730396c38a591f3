// `tremolo run` of scenes in which cloth meets bodies of other kinds: known answers and refusals,
// as a user meets them.
#include <cmath>
#include <fstream>
#include <sstream>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/samples/shipped_scene.h"
#include "tests/support/programs.h"

namespace tremolo {
namespace {

using nlohmann::json;

constexpr double kGravity = 9.81;

class ClothBodyProgram : public ::testing::Test {
 protected:
  void SetUp() override { folder_ = fresh_folder(); }

  ProgramResult run(const std::string& scene, const std::string& flags = "--json") {
    std::ofstream(folder_ + "/scene.toml") << scene;
    return run_program(folder_, kTremolo + "run scene.toml " + flags);
  }

  std::string folder_;
};

std::string sheet(const std::string& name, const std::string& keys) {
  return "[[bodies]]\nname = \"" + name +
         "\"\nkind = \"cloth\"\ncolumns = 9\nrows = 9\nwidth = 0.16\nheight = 0.16\n"
         "structural = [200, 0.02]\nshear = [60, 0.02]\nbend = [2, 0.002]\ndensity = 0.2\n"
         "thickness = 0.004\n" +
         keys;
}

std::string box(const std::string& name, const std::string& keys) {
  return "[[bodies]]\nname = \"" + name +
         "\"\nkind = \"rigid\"\nmass = 1\nshape = \"box\"\nhalf-extents = [0.1, 0.1, 0.1]\n" + keys;
}

const std::string kFloor =
    "[[colliders]]\nname = \"floor\"\nshape = \"plane\"\nfriction = 0.5\nrestitution = 0\n";

TEST_F(ClothBodyProgram, ASheetRestsWithItsWeightOnARigidBox) {
  const ProgramResult result =
      run("step = 0.002\nduration = 0.8\ngravity = [0, 0, -9.81]\n" +
          box("table", "position = [0, 0, 0.1003]\nrestitution = 0\nfriction = 0.5\n") +
          sheet("sheet", "corner = [-0.08, -0.08, 0.2043]\nfriction = 0.5\n") + kFloor);
  ASSERT_EQ(result.code, 0) << result.err;
  const json report = json::parse(result.out);
  const json& cloth = report["bodies"][1];
  EXPECT_EQ(cloth["kind"], "cloth");
  const double weight = kGravity * 0.2 * 0.16 * 0.16;
  EXPECT_NEAR(cloth["contact_force_final"][2].get<double>(), weight, 1e-3 * weight);
  EXPECT_EQ(cloth["penetration_max"].get<double>(), 0.0);
  EXPECT_EQ(cloth["contact_points_final"].get<int>(), 81);
  EXPECT_LE(report["momentum_error"].get<double>(), 1e-10);
  EXPECT_LE(report["energy_balance_error"].get<double>(), 1e-8);
}

// At rest on flat distances of a file the path of a particle in a step is near its rounding error,
// which must not turn normals.
TEST_F(ClothBodyProgram, ASheetRestsOnAFlatColliderOfAFileAtEveryStep) {
  {
    std::ofstream plate(folder_ + "/plate.obj");
    for (const double z : {-0.05, 0.05})
      for (const double y : {-0.4, 0.4})
        for (const double x : {-0.4, 0.4}) plate << "v " << x << ' ' << y << ' ' << z << '\n';
    plate << "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
  }
  const ProgramResult made =
      run_program(folder_, kPrecompute + "collider plate.obj -o plate.collider");
  ASSERT_EQ(made.code, 0) << made.err;
  for (const char* step : {"0.0166667", "0.004", "0.002"}) {
    SCOPED_TRACE(step);
    const ProgramResult result =
        run(std::string("step = ") + step +
            "\nduration = 0.6\ngravity = [0, 0, -9.81]\n[[bodies]]\nname = \"sheet\"\nkind = "
            "\"cloth\"\ncolumns = 9\nrows = 9\nwidth = 0.2\nheight = 0.2\ncorner = [-0.1, -0.1, "
            "0.006]\n[[colliders]]\nname = \"plate\"\nshape = \"mesh\"\nfile = "
            "\"plate.collider\"\nposition = [0, 0, -0.05]\n");
    ASSERT_EQ(result.code, 0) << result.err;
    const json report = json::parse(result.out);
    const json& cloth = report["bodies"][0];
    const double weight = kGravity * 0.2 * 0.2 * 0.2;
    EXPECT_NEAR(cloth["contact_force_final"][2].get<double>(), weight, 1e-3 * weight);
    EXPECT_EQ(cloth["cut_steps"].get<int>(), 0);
  }
}

TEST_F(ClothBodyProgram, ASheetThatHitsARigidBoxKeepsBothMomentaAndTheEnergy) {
  const ProgramResult result =
      run("step = 0.001\nduration = 0.1\n" +
          box("box", "position = [0, 0, 0]\nvelocity = [0, 0, 0.2]\nspin = [0.3, 0.5, -1]\n") +
          sheet("sheet",
                "corner = [-0.06, -0.09, 0.12]\nvelocity = [0.3, 0.1, -1.5]\nfriction = 0.5\n"
                "restitution = 0.5\nintegrator = \"energy\"\ndrag = 0\n"));
  ASSERT_EQ(result.code, 0) << result.err;
  const json report = json::parse(result.out);
  for (const char* which : {"linear_momentum", "angular_momentum"})
    for (int axis = 0; axis < 3; ++axis) {
      double change = 0.0;
      for (const json& body : report["bodies"])
        change += body[which + std::string("_final")][axis].get<double>() -
                  body[which + std::string("_initial")][axis].get<double>();
      // Of momenta of 0.2 kg m/s and 0.01 N m s.
      EXPECT_LE(std::abs(change), 1e-10) << which << axis;
    }
  EXPECT_LE(report["momentum_error"].get<double>(), 1e-10);
  double contact = 0.0;
  for (const json& body : report["bodies"])
    contact += body["energy_by_cause"]["contact"].get<double>();
  EXPECT_LE(std::abs(contact), 1e-10);
  const json& cloth = report["bodies"][1];
  EXPECT_GT(cloth["contacts"].get<int>(), 0);
  EXPECT_LT(cloth["energy_by_cause"]["friction"].get<double>(), 0.0);
  // The method closes the balance by itself.
  EXPECT_LE(cloth["energy_balance_error"].get<double>(), 1e-6);
}

TEST_F(ClothBodyProgram, ASheetWithoutOtherBodiesHangsFromItsPinsAndWritesItsSurfaces) {
  const ProgramResult result =
      run("step = 0.005\nduration = 0.05\ngravity = [[0, 0, 0, -9.81], [1, 0, 0, 0]]\n"
          "wind = [0.5, 2, 0]\ngust = 0.2\n" +
              sheet("flag", "pins = \"left\"\nalong = [1, 0, 0]\nacross = [0, 0, 1]\n"),
          "--out out --surfaces 2 --json");
  ASSERT_EQ(result.code, 0) << result.err;
  const json report = json::parse(result.out);
  ASSERT_EQ(report["bodies"].size(), 1U);
  EXPECT_GT(report["bodies"][0]["energy_by_cause"]["wind"].get<double>(), 0.0);
  for (const char* file : {"run.csv", "frames.csv"})
    EXPECT_TRUE(std::ifstream(folder_ + "/out/flag/" + file).good()) << file;
  const ProgramResult inspected = run_program(folder_, kTremolo + "inspect scene.toml --json");
  EXPECT_EQ(inspected.code, 0) << inspected.err;
  EXPECT_EQ(json::parse(inspected.out)["bodies"].size(), 1U);
}

TEST_F(ClothBodyProgram, RefusesByNameWhatAClothCannotDo) {
  const std::string start = "step = 0.002\nduration = 0.02\n" + box("other", "");
  struct Refusal {
    std::string scene, flags, words;
    int code;
  };
  const std::string cloth = sheet("sheet", "corner = [0, 0, 0.3]\n");
  for (const Refusal& refusal :
       {Refusal{start + cloth + "[[hands]]\nbody = \"sheet\"\nat = \"row:9\"\nstiffness = 10\n", "",
                "'row:9' is no place of particles", 3},
        {start + cloth + "contact-margin = 0.01\n", "", "`thickness`", 3},
        {start + cloth + "model = \"a.tremolo\"\n", "", "model", 3},
        {start + cloth + "integrator = \"newmark\"\n", "", "newmark", 3},
        {start + cloth + cloth, "", "cloths-pass", 3},
        {"cloths-pass = true\n" + start + cloth + cloth, "", "two bodies", 3},
        {"cloths-pass = true\n" + start, "", "cloths-pass", 3},
        {start + sheet("sheet", "corner = [-0.08, -0.08, 0.05]\n"), "", "inside body 'other'", 3},
        {start + sheet("sheet", "thickness = 0\n"), "", "thickness", 3},
        {start + sheet("sheet", "density = -1\n"), "", "density", 3},
        {start + cloth, "--integrator energy", "--integrator", 2}}) {
    const ProgramResult result = run(refusal.scene, refusal.flags);
    EXPECT_EQ(result.code, refusal.code) << refusal.words << result.err;
    EXPECT_NE(result.err.find(refusal.words), std::string::npos) << refusal.words << result.err;
  }
}

TEST_F(ClothBodyProgram, ATableclothCarriesAHeart) {
  const ProgramResult result = run(testing::shipped_scene("tablecloth"), "--json --duration 0.1");
  ASSERT_EQ(result.code, 0) << result.err;
  const json report = json::parse(result.out);
  EXPECT_LE(report["energy_balance_error"].get<double>(), 1e-8);
  const json& cloth = report["bodies"][1];
  EXPECT_GT(cloth["contacts"].get<int>(), 0);
  EXPECT_LE(cloth["penetration_max"].get<double>(), cloth["thickness"].get<double>());
}

// The blanket lies still on the horse before the horse rocks, and is compressed where it folds.
TEST_F(ClothBodyProgram, AHorseWearsABlanketAtRestAndWhenItRocks) {
  const ProgramResult result = run(testing::shipped_scene("blanket"), "--json --duration 0.75");
  ASSERT_EQ(result.code, 0) << result.err;
  const json report = json::parse(result.out);
  EXPECT_LE(report["momentum_error"].get<double>(), 1e-10);
  EXPECT_LE(report["energy_balance_error"].get<double>(), 1e-8);
  const json& blanket = report["bodies"][2];
  ASSERT_EQ(blanket["body"], "blanket");
  EXPECT_LE(blanket["penetration_max"].get<double>(), blanket["thickness"].get<double>());
  EXPECT_GT(blanket["contact_points_final"].get<int>(), 100);
  // The ball has left its place at -0.108 m: a hoof has struck it.
  EXPECT_LT(report["bodies"][1]["position_final"][0].get<double>(), -0.13);
  // It hangs on the horse as a whole: the horse carries its weight.
  const double weight = kGravity * 0.4 * 0.1 * 0.14;
  EXPECT_NEAR(blanket["contact_force_final"][2].get<double>(), weight, 0.2 * weight);
}

// Steps that are not solved are subdivided while the horse is driven.
TEST_F(ClothBodyProgram, TheBlanketIsSolvedByTheEnergyMethodWhileTheHorseRocks) {
  std::string scene = testing::shipped_scene("blanket");
  const std::string kind = "kind = \"cloth\"\n";
  const std::size_t at = scene.find(kind);
  ASSERT_NE(at, std::string::npos);
  scene.insert(at + kind.size(), "integrator = \"energy\"\n");
  const ProgramResult result = run(scene, "--json --duration 0.36");
  ASSERT_EQ(result.code, 0) << result.err;
  const json report = json::parse(result.out);
  EXPECT_LE(report["momentum_error"].get<double>(), 1e-10);
  EXPECT_LE(report["energy_balance_error"].get<double>(), 1e-8);
  EXPECT_GT(report["bodies"][0]["halved_steps"].get<int>(), 0);
}

}  // namespace
}  // namespace tremolo
