// Loads, damping and materials that a user gives without a CSV file or a new precompute.
#include <cmath>
#include <fstream>
#include <numbers>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "formats/basis/basis_reader.h"
#include "tests/support/programs.h"
#include "tests/support/row_files.h"

namespace tremolo {
namespace {

class LoadsProgram : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fresh_folder();
    write_veg(folder_ + "/bar.veg", box_mesh({6, 2, 2}, {0.6, 0.1, 0.1}));
    make("soft.tremolo", "--young 1e6 --density 1000");
  }
  void make(const std::string& out, const std::string& material) {
    const ProgramResult result =
        run_program(folder_, kMayBeRoot + kPrecompute + "bar.veg -o " + out + " " + material +
                                 " --poisson 0.3 --fix 'x<1%' --load-at 'x>99%' --load-force 0,0,1 "
                                 "--linear-modes 4 --modes 8 --threads 1");
    ASSERT_EQ(result.code, 0) << result.err;
  }
  ProgramResult run(const std::string& arguments) {
    return run_program(folder_, kTremolo + arguments);
  }
  // The probe's path along z of a run.
  std::vector<double> path(const std::string& arguments) {
    const ProgramResult result =
        run(arguments + " --probe near:0.6,0.05,0.05 --step 0.002 --out out");
    EXPECT_EQ(result.code, 0) << arguments << "\n" << result.err;
    std::ifstream file(folder_ + "/out/run.csv");
    std::string line;
    std::getline(file, line);
    std::size_t column = 0;
    for (std::size_t at = 0, n = 0; at != std::string::npos; at = line.find(',', at), ++n) {
      if (at > 0) ++at;
      const std::string name = line.substr(at, line.find(',', at) - at);
      if (name.starts_with("u") && name.ends_with("z")) column = n;
    }
    std::vector<double> values;
    while (std::getline(file, line)) {
      std::size_t at = 0;
      for (std::size_t n = 0; n < column; ++n) at = line.find(',', at) + 1;
      values.push_back(std::stod(line.substr(at)));
    }
    return values;
  }
  std::string folder_;
};

TEST_F(LoadsProgram, ASineOfAFrequencyIsTheTableOfThatSine) {
  std::ofstream csv(folder_ + "/sine.csv");
  for (int k = 0; k <= 40'000; ++k)
    csv << k * 5e-5 << "," << std::sin(2 * std::numbers::pi * 3 * k * 5e-5) << "\n";
  csv.close();
  const std::vector<double> sine = path("run soft.tremolo --load sine --frequency 3 --duration 1");
  const std::vector<double> table = path("run soft.tremolo --signal sine.csv --duration 1");
  ASSERT_EQ(sine.size(), table.size());
  ASSERT_GT(sine.size(), 100u);
  double largest = 0;
  for (const double z : sine) largest = std::max(largest, std::abs(z));
  // A chord of the table is off by (2 pi 3 5e-5)^2 / 8 = 1e-7 of the sine.
  for (std::size_t k = 0; k < sine.size(); ++k) EXPECT_NEAR(sine[k], table[k], 1e-5 * largest);
}

TEST_F(LoadsProgram, ShapesAreKeysOfScenesToo) {
  std::ofstream(folder_ + "/scene.toml") << "[bar]\nmodel = \"soft.tremolo\"\nload = \"chirp\"\n"
                                            "sweep = [1, 12]\nload-duration = 0.8\nstep = 0.002\n"
                                            "duration = 1\nprobe = \"near:0.6,0.05,0.05\"\n";
  const std::vector<double> flags =
      path("run soft.tremolo --load chirp --sweep 1,12 --load-duration 0.8 --duration 1");
  ASSERT_EQ(run("run scene.toml --out scene").code, 0);
  EXPECT_EQ(slurp(folder_ + "/scene/run.csv"), slurp(folder_ + "/out/run.csv"));
  std::ofstream(folder_ + "/world.toml")
      << "step = 0.002\nduration = 0.1\n[[bodies]]\nname = \"bar\"\nmodel = \"soft.tremolo\"\n"
         "load = \"ramp\"\nload-duration = 0.05\ndamping-ratio = \"1:0.02,30:0.05\"\n";
  EXPECT_EQ(run("run world.toml").code, 0);
}

TEST_F(LoadsProgram, ARampEndsWhereAConstantLoadRests) {
  const std::string damped = " --damping-ratio 1:0.5,50:0.5 --duration 8";
  const std::vector<double> ramp = path("run soft.tremolo --load ramp --load-duration 1" + damped);
  const std::vector<double> held = path("run soft.tremolo --load constant" + damped);
  EXPECT_NEAR(ramp.back(), held.back(), 1e-3 * std::abs(held.back()));
  EXPECT_LT(std::abs(ramp[5]), 0.1 * std::abs(held[50]));
}

// The tip, released from its deflection under a small load, swings in the first mode: its peaks
// fall by the logarithmic decrement 2 pi zeta / sqrt(1 - zeta^2). The bar's section is square, so
// the first two modes have one frequency and must have one ratio.
TEST_F(LoadsProgram, ADampingRatioIsTheDecrementOfARun) {
  const std::string start =
      "run soft.tremolo --start near:0.6,0.05,0.05=0,0,1e-4 --load none --duration 9";
  for (const std::string ratio : {"3%", "0.03,0.03,0.2", "0.1:1%,4:3%,40:30%"}) {
    const std::vector<double> z = path(start + " --damping-ratio " + ratio);
    std::vector<std::size_t> peaks;
    for (std::size_t k = 1; k + 1 < z.size(); ++k)
      if (z[k] > z[k - 1] && z[k] >= z[k + 1] && z[k] > 0) peaks.push_back(k);
    ASSERT_GT(peaks.size(), 9U) << ratio;
    // By the fourth peak the other modes have died out.
    const double periods = 5.0, frequency = periods / (0.002 * double(peaks[8] - peaks[3]));
    const double decrement = std::log(z[peaks[3]] / z[peaks[8]]) / periods;
    const double zeta = ratio.starts_with("0.1:") ? 0.01 + 0.02 * (frequency - 0.1) / 3.9 : 0.03;
    // The peaks lie between rows, (omega h/2)^2/2 = 4e-5 below each; the other modes' rest.
    EXPECT_NEAR(decrement, 2.0 * std::numbers::pi * zeta / std::sqrt(1.0 - zeta * zeta),
                0.01 * decrement)
        << ratio;
  }
}

TEST_F(LoadsProgram, AScenesDampingRatioIsThatOfTheFlag) {
  const std::string flags = "run soft.tremolo --damping-ratio 5% --duration 0.4";
  const std::vector<double> flagged = path(flags);
  std::ofstream(folder_ + "/one.toml")
      << "[bar]\nmodel = \"soft.tremolo\"\nstep = 0.002\nduration = 0.4\n"
         "damping-ratio = 0.05\nprobe = \"near:0.6,0.05,0.05\"\n";
  ASSERT_EQ(run("run one.toml --out one").code, 0);
  EXPECT_EQ(slurp(folder_ + "/one/run.csv"), slurp(folder_ + "/out/run.csv"));
  const std::string world =
      "step = 0.002\nduration = 0.1\n[[bodies]]\nname = \"bar\"\nmodel = "
      "\"soft.tremolo\"\n[[bodies.loads]]\nload = \"square\"\n";
  std::ofstream(folder_ + "/world.toml") << "damping-ratio = 1\n" + world;
  EXPECT_EQ(run("run world.toml").code, 3);
  std::ofstream(folder_ + "/plain.toml") << world;
  for (const auto& [ratio, code] : {std::pair{"5%", 0},
                                    {"1:2%,5:2%,9:3%", 0},
                                    {"5%,", 2},
                                    {"150%", 3},
                                    {"-0.1", 3},
                                    {"nan", 3},
                                    {"1%,1%,1%,1%,1%,1%,1%,1%,1%", 3}}) {
    EXPECT_EQ(run(std::string("run plain.toml --damping-ratio ") + ratio).code, code) << ratio;
    EXPECT_EQ(run(std::string("run soft.tremolo --duration 0.01 --damping-ratio ") + ratio).code,
              code)
        << ratio;
  }
  const ProgramResult many =
      run("run soft.tremolo --duration 0.01 --damping-ratio 1%,1%,1%,1%,1%,1%,1%,1%,1%");
  EXPECT_NE(many.err.find("there are 8 modes"), std::string::npos) << many.err;
}

TEST_F(LoadsProgram, ShapesThatDoNotApplyAreRefused) {
  for (const char* wrong :
       {"--load square --frequency 3", "--load sine --sweep 1,2", "--load chirp --sweep 1",
        "--damping-ratio 1:0.1", "--damping-ratio 1:0.1,2:0.1 --alpha 1"})
    EXPECT_EQ(run("run soft.tremolo --duration 0.01 " + std::string(wrong)).code, 2) << wrong;
  for (const char* wrong : {"--load sine --frequency 0", "--load chirp --sweep 1,-2",
                            "--load impulse --load-duration 0", "--damping-ratio 1:0.01,10:0.5"})
    EXPECT_EQ(run("run soft.tremolo --duration 0.01 " + std::string(wrong)).code, 3) << wrong;
}

TEST_F(LoadsProgram, ARescaledModelIsTheOneThatPrecomputeMakesOfTheOtherMaterial) {
  make("stiff.tremolo", "--young 5e6 --density 400");
  ASSERT_EQ(run("export soft.tremolo --rescale young=5e6,density=400 --rescaled made.tremolo").code,
            0);
  const auto stiff = read_basis(folder_ + "/stiff.tremolo"),
             made = read_basis(folder_ + "/made.tremolo");
  ASSERT_TRUE(stiff && made);
  // Both solve for modes to about 1e-8.
  EXPECT_TRUE(made->lambda.isApprox(stiff->lambda, 1e-6));
  EXPECT_NEAR(made->total_mass, stiff->total_mass, 1e-12);
  const std::string load = " --load square --duration 0.5";
  const std::vector<double> there = path("run stiff.tremolo" + load);
  const std::vector<double> here = path("run soft.tremolo --rescale young=5e6,density=400" + load);
  double largest = 0;
  for (const double z : there) largest = std::max(largest, std::abs(z));
  ASSERT_EQ(here.size(), there.size());
  for (std::size_t k = 0; k < here.size(); ++k) EXPECT_NEAR(here[k], there[k], 1e-4 * largest);
}

TEST_F(LoadsProgram, RescalingIsRefusedWithTheReason) {
  make("two.tremolo", "--young 1e6 --density 1000 --material 'x<50%: young=2e6'");
  const ProgramResult two = run("run two.tremolo --rescale young=2e6 --duration 0.01");
  EXPECT_EQ(two.code, 3);
  EXPECT_NE(two.err.find("several materials"), std::string::npos) << two.err;
  for (const char* wrong : {"young", "young=", "young=-1", "poisson=0.3", "young=1,young=2"})
    EXPECT_EQ(run("run soft.tremolo --duration 0.01 --rescale " + std::string(wrong)).code, 2)
        << wrong;
}

// The end of a bar whose one half is meshed finer; the force along x must not bend it.
TEST_F(LoadsProgram, AForceOnAFaceThatIsMeshedFinerOnOneSideDoesNotTwistTheBar) {
  TetMesh mesh = box_mesh({4, 6, 2}, {0.6, 0.1, 0.1});
  // Vertices crowd towards y = 0; the tetrahedra stay as they are.
  for (Eigen::Vector3d& x : mesh.vertices) x.y() = 0.1 * std::pow(x.y() / 0.1, 2.5);
  write_veg(folder_ + "/graded.veg", mesh);
  const ProgramResult made = run_program(
      folder_,
      kMayBeRoot + kPrecompute +
          "graded.veg -o graded.tremolo --young 1e6 --poisson 0 --density 1000 --fix 'x<1%' "
          "--linear --linear-modes 60 --threads 1");
  ASSERT_EQ(made.code, 0) << made.err;
  const ProgramResult pulled =
      run("run graded.tremolo --at 'x>99%' --force 1,0,0 --start static --load constant --duration "
          "0.001 "
          "--step 0.001 --probe near:0.6,0,0.05 --probe near:0.6,0.1,0.05 --out pulled");
  ASSERT_EQ(pulled.code, 0) << pulled.err;
  std::ifstream file(folder_ + "/pulled/run.csv");
  std::string header, row;
  std::getline(file, header);
  std::getline(file, row);
  std::vector<double> along_y, along_x;
  for (std::size_t at = 0, to = 0; at != std::string::npos && to != std::string::npos;) {
    const std::size_t next = header.find(',', at), end = row.find(',', to);
    const std::string name = header.substr(at, next - at);
    const double value = std::atof(row.substr(to, end - to).c_str());
    if (name.starts_with("u") && name.ends_with("x")) along_x.push_back(value);
    if (name.starts_with("u") && name.ends_with("y")) along_y.push_back(value);
    at = next == std::string::npos ? next : next + 1;
    to = end == std::string::npos ? end : end + 1;
  }
  ASSERT_EQ(along_x.size(), 2u) << header;
  // Both edges of the end move by F L / (E A) = 6e-5 m, within what 60 modes leave out; equal
  // shares bend the bar, so that the edges differ by more than that.
  EXPECT_NEAR(along_x[0], 6e-5, 1e-5);
  EXPECT_NEAR(along_x[1], 6e-5, 1e-5);
  EXPECT_LT(std::abs(along_y[0]), 3e-5);
}

}  // namespace
}  // namespace tremolo
