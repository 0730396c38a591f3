// Materials and point masses as a user of tremolo-precompute and tremolo inspect meets them.
#include <cmath>
#include <filesystem>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "formats/basis/basis_reader.h"
#include "tests/support/programs.h"

namespace tremolo {
namespace {

using Json = nlohmann::json;

const std::string kInspect = TREMOLO_BIN_DIR "/tremolo inspect ";

// A block whose left half (x < 0.2) is the region "grip" and whose right half is "blade": as an MSH
// file with physical volumes, and as a .veg that brings materials of its own.
class Materials : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fresh_folder();
    std::ofstream msh(folder_ + "/block.msh");
    msh << "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n3 1 \"grip\"\n3 2 \"blade\"\n"
           "$EndPhysicalNames\n$Nodes\n"
        << block_.vertices.size() << "\n";
    for (std::size_t v = 0; v < block_.vertices.size(); ++v)
      msh << v + 1 << " " << block_.vertices[v].transpose() << "\n";
    msh << "$EndNodes\n$Elements\n" << block_.tetrahedra.size() << "\n";
    for (std::size_t t = 0; t < block_.tetrahedra.size(); ++t) {
      msh << t + 1 << " 4 2 " << (is_grip(t) ? 1 : 2) << " 1";
      for (VertexId v : block_.tetrahedra[t]) msh << " " << v + 1;
      msh << "\n";
    }
    msh << "$EndElements\n";
    testing::write_veg(folder_ + "/block.veg", block_);
    std::ofstream veg(folder_ + "/block.veg", std::ios::app);
    veg << "*MATERIAL grip\nENU, 1100, 2e7, 0.4\n*MATERIAL blade\nORTHOTROPIC_N3G3, 600, 11e9, "
           "0.9e9, 0.5e9, 0.37, 0.47, 0.02, 0.75e9, 0.04e9, 0.7e9\n*SET left\n";
    for (std::size_t t = 0; t < block_.tetrahedra.size(); ++t)
      if (is_grip(t)) veg << t + 1 << ",\n";
    veg << "*REGION\nallElements, blade\n*REGION\nleft, grip\n";
  }

  bool is_grip(std::size_t t) const {
    double x = 0;
    for (VertexId v : block_.tetrahedra[t]) x += 0.25 * block_.vertices[v].x();
    return x < 0.2;
  }

  ProgramResult run(const std::string& arguments) {
    return run_program(folder_, kPrecompute + arguments + kRest);
  }
  Json good(const std::string& arguments) {
    const ProgramResult result = run(arguments + " --json");
    EXPECT_EQ(result.code, 0) << result.err;
    last_err_ = result.err;
    return result.code == 0 ? Json::parse(result.out) : Json();
  }
  void expect_failure(const std::string& arguments, int code, const std::string& words) {
    const ProgramResult result = run(arguments);
    EXPECT_EQ(result.code, code) << arguments << "\n" << result.err;
    EXPECT_NE(result.err.find(words), std::string::npos) << result.err;
    EXPECT_FALSE(std::filesystem::exists(folder_ + "/out.tremolo"));
  }

  static constexpr const char* kRest =
      " -o out.tremolo --fix 'x<0.001' --linear-modes 4 --modes 8 --threads 1";
  TetMesh block_ = box_mesh({4, 2, 2}, {0.4, 0.15, 0.2});
  std::string folder_;
  std::string last_err_;
};

constexpr double kHalf = 0.2 * 0.15 * 0.2;  // m^3

const std::string kGripAndBlade =
    "--material 'grip: young=2e7, poisson=0.4, density=1100' "
    "--material 'blade: E1=11e9, E2=0.9e9, E3=0.5e9, nu12=0.37, nu23=0.47, nu31=0.02, "
    "G12=0.75e9, G23=0.04e9, G31=0.7e9, density=600' ";

TEST_F(Materials, OfRegionsAreUsedAndToldInReportAndFile) {
  const Json report = good("block.msh " + kGripAndBlade);
  EXPECT_NEAR(report["total_mass_kg"], kHalf * (1100 + 600), 1e-9);
  EXPECT_LE(report["polynomial_error"], 1e-12);
  EXPECT_LE(report["mass_orthonormality_error"], 1e-10);
  ASSERT_EQ(report["materials"].size(), 2u);
  EXPECT_EQ(report["materials"][0]["region"], "grip");
  EXPECT_EQ(report["materials"][0]["tetrahedra"], 48);
  EXPECT_EQ(report["materials"][1]["young_123_pa"], Json({11e9, 0.9e9, 0.5e9}));
  EXPECT_NE(last_err_.find("blade: 48 tetrahedra"), std::string::npos) << last_err_;
  const ProgramResult inspect = run_program(folder_, kInspect + "out.tremolo --json");
  ASSERT_EQ(inspect.code, 0) << inspect.err;
  EXPECT_EQ(Json::parse(inspect.out)["provenance"]["materials"], report["materials"]);
}

TEST_F(Materials, OfAVegFileAreTakenWhenAskedFor) {
  const Json table = good("block.msh " + kGripAndBlade);
  const Json file = good("block.veg --material file");
  ASSERT_EQ(file["frequencies_hz"].size(), 8u);
  for (std::size_t i = 0; i < 8; ++i) {
    const double f = table["frequencies_hz"][i];
    EXPECT_NEAR(file["frequencies_hz"][i], f, 1e-6 * f);  // the MSH file has six digits
  }
  const Json unused = good("block.veg");
  EXPECT_NE(last_err_.find("are not used"), std::string::npos) << last_err_;
  EXPECT_EQ(unused["materials"].size(), 1u);
  EXPECT_EQ(unused["materials"][0]["young_pa"], 1e6);
  good("block.msh");
  EXPECT_NE(last_err_.find("`grip`, `blade`: all of one material"), std::string::npos) << last_err_;
  // A later entry decides.
  const Json lighter = good("block.veg --material file --material 'grip: density=100'");
  EXPECT_NEAR(lighter["total_mass_kg"], kHalf * (100 + 600), 1e-9);
}

TEST_F(Materials, OfAVegFileTurnWithTheMesh) {
  const std::string modes = " --linear-modes 4 --modes 8 --threads 1 --json --material file";
  const auto frequencies = [&](const std::string& arguments) {
    const ProgramResult result =
        run_program(folder_, kPrecompute + "block.veg -o turned.tremolo " + arguments + modes);
    EXPECT_EQ(result.code, 0) << result.err;
    return Json::parse(result.out)["frequencies_hz"];
  };
  const Json plain = frequencies("--fix 'y<0.001'");
  const Json turned = frequencies("--up y --fix 'z<0.001'");
  for (std::size_t i = 0; i < 8; ++i)
    EXPECT_NEAR(turned[i], plain[i].get<double>(), 1e-6 * plain[i].get<double>());
}

TEST_F(Materials, ComeFromAConfigFileAsAList) {
  std::ofstream(folder_ + "/config.toml")
      << "density = 500\nmaterial = [\"grip: young=2e7, poisson=0.4, density=1100\", \"blade: "
         "E1=11e9, E2=0.9e9, E3=0.5e9, nu12=0.37, nu23=0.47, nu31=0.02, G12=0.75e9, G23=0.04e9, "
         "G31=0.7e9, density=600\"]\npoint-mass = [\"x>0.39=0.5\", \"vertex:3=0.25\"]\n";
  const Json report = good("block.msh --config config.toml");
  EXPECT_NEAR(report["total_mass_kg"], kHalf * (1100 + 600) + 0.75, 1e-9);
  EXPECT_EQ(report["materials"], good("block.msh " + kGripAndBlade)["materials"]);
}

TEST_F(Materials, WithoutAnEntryAreTheUsualOneAndSelectorsStandForRegions) {
  const Json report = good(
      "block.msh --density 900 --material 'blade: density=300' "
      "--material 'box:-1,-1,-1,0.11,1,1: young=5e6, density=1200'");
  // The box holds the vertices of the first of four columns of cells.
  EXPECT_NEAR(report["total_mass_kg"], kHalf * (0.5 * 1200 + 0.5 * 900 + 300), 1e-9);
  ASSERT_EQ(report["materials"].size(), 3u);
  EXPECT_EQ(report["materials"][0]["region"], "default");
  EXPECT_EQ(report["materials"][2]["tetrahedra"], 24);
}

TEST_F(Materials, ThatAreAllAlikeGiveTheModelOfOne) {
  const Json one = good("block.msh --young 3e6 --poisson 0.3 --density 800");
  const Json two = good(
      "block.msh --material 'grip: young=3e6, poisson=0.3, density=800' --material 'blade: "
      "young=3e6, poisson=0.3, density=800'");
  for (std::size_t i = 0; i < 8; ++i) {
    const double f = one["frequencies_hz"][i];
    EXPECT_NEAR(two["frequencies_hz"][i], f, 1e-9 * f);  // another order of the same sums
  }
}

TEST_F(Materials, OfAFreeBodyWithASoftHingeAreSolved) {
  // The regions differ ten thousand times in stiffness: the shift is below the softest.
  const ProgramResult result = run_program(
      folder_, kPrecompute +
                   "block.msh -o free.tremolo --fix none --linear-modes 4 --modes 8 --json "
                   "--material 'grip: young=1e5, poisson=0.3' --material 'blade: young=1e9' "
                   "--point-mass 'x>0.39=40'");
  ASSERT_EQ(result.code, 0) << result.err;
  const Json report = Json::parse(result.out);
  EXPECT_EQ(report["rigid_modes"], 6);
  EXPECT_TRUE(report["certified_by_inertia"]);
  EXPECT_LE(report["polynomial_error"], 1e-9);
}

TEST_F(Materials, AMillionTimesAsStiffOnASoftGripAreARigidPart) {
  const auto lowest = [&](const std::string& young) {
    const ProgramResult result =
        run_program(folder_, kPrecompute +
                                 "block.msh -o rigid.tremolo --fix 'x<0.001' --json --material "
                                 "'grip: young=1e3, poisson=0.3' --material 'blade: young=" +
                                 young + ", poisson=0.3'");
    EXPECT_EQ(result.code, 0) << result.err;
    return result.code == 0 ? Json::parse(result.out)["frequencies_hz"][0].get<double>() : 0.0;
  };
  // The remaining effect of the blade's own strain is about a part in a hundred thousand.
  const double f = lowest("1e9");
  EXPECT_NEAR(lowest("1e8"), f, 1e-4 * f);
}

TEST_F(Materials, ThatMakeNoSenseAreRefused) {
  expect_failure("block.msh --material 'bone: young=1e9'", 2, "`grip`, `blade`");
  expect_failure("block.msh --material 'grip young=1e9'", 2, "colon");
  expect_failure("block.msh --material 'grip: yuong=1e9'", 2, "yuong");
  expect_failure("block.msh --material 'grip: young=1e9 Pa'", 2, "a number behind young");
  expect_failure("block.msh --material 'grip: young=1, young=2'", 2, "twice");
  expect_failure("block.msh --material 'grip: e1=1e9, e2=1e9'", 2, "e3=");
  expect_failure("block.msh --material 'grip: e1=1e9, young=1e9'", 2, "either");
  expect_failure("block.msh --material 'grip: young=-1'", 3, "Young's modulus");
  expect_failure(
      "block.msh --material 'grip: E1=1e9, E2=1e9, E3=1e9, nu12=1.1, nu23=0, nu31=0, "
      "G12=1e9, G23=1e9, G31=1e9'",
      3, "nu12 is 1.1");
  expect_failure(
      "block.msh --material 'grip: E1=1e9, E2=1e9, E3=1e9, nu12=0, nu23=0, nu31=0, "
      "G12=1e9, G23=1e9, G31=1e9, axis1=1 0 0, axis2=2 0 0'",
      3, "parallel");
  expect_failure("block.msh --material 'x>0.399: young=1e9'", 3, "no tetrahedron");
  expect_failure("block.msh --material file", 3, "no region a material");
}

TEST_F(Materials, OfThePointMassesAreToldAndSlowTheBodyDown) {
  const Json bare = good("block.msh --density 1000");
  const Json laden = good("block.msh --density 1000 --point-mass 'x>0.39=30'");
  EXPECT_NEAR(laden["total_mass_kg"], bare["total_mass_kg"].get<double>() + 30, 1e-9);
  EXPECT_EQ(laden["point_masses"][0]["vertices"], 9);
  EXPECT_LE(laden["mass_orthonormality_error"], 1e-10);
  // 12 kg of body, a quarter of which moves as the tip does: the tip's 30 kg slow it 3 to 4 times.
  const double slower =
      bare["frequencies_hz"][0].get<double>() / laden["frequencies_hz"][0].get<double>();
  EXPECT_GT(slower, 3.0);
  EXPECT_LT(slower, 4.0);
  const Json held = good("block.msh --density 1000 --point-mass 'x<0.001=30'");
  EXPECT_NE(last_err_.find("where a mass does nothing"), std::string::npos) << last_err_;
  EXPECT_NEAR(held["frequencies_hz"][0], bare["frequencies_hz"][0],
              1e-9 * bare["frequencies_hz"][0].get<double>());
  std::filesystem::remove(folder_ + "/out.tremolo");
  expect_failure("block.msh --point-mass 'x>0.39'", 2, "SELECTOR=KG");
  expect_failure("block.msh --point-mass 'x>0.39=-3'", 3, "positive");
  expect_failure("block.msh --point-mass 'x>7=3'", 3, "selects no vertex");
}

TEST_F(Materials, OnTwoRanksAreThoseOnOne) {
  const std::string some = "block.msh --point-mass 'x>0.39=3' " + kGripAndBlade;
  const Json one = good(some);
  const ProgramResult result = run_program(
      folder_,
      "OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 mpiexec --oversubscribe "
      "-n 2 " +
          kPrecompute + some + kRest + " --json");
  ASSERT_EQ(result.code, 0) << result.err;
  const Json two = Json::parse(result.out);
  for (std::size_t i = 0; i < 8; ++i) {
    const double f = one["frequencies_hz"][i];
    EXPECT_NEAR(two["frequencies_hz"][i], f, 1e-9 * f);  // another factorisation's rounding
  }
  EXPECT_LE(two["polynomial_error"], 1e-12);
}

}  // namespace
}  // namespace tremolo
