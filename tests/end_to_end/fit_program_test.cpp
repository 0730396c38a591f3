// tremolo-precompute --sensitivities and --fit.
#include <cmath>
#include <fstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/programs.h"

namespace tremolo {
namespace {

using Json = nlohmann::json;

class FitProgram : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fresh_folder();
    write_veg(folder_ + "/bar.veg", box_mesh({5, 2, 1}, {0.5, 0.17, 0.11}));
  }
  ProgramResult precompute(const std::string& arguments) {
    return run_program(folder_, kMayBeRoot + kPrecompute +
                                    "bar.veg --fix 'x<1%' --linear-modes 6 --threads 1 " +
                                    arguments);
  }
  Json json(const std::string& arguments) {
    const ProgramResult result = precompute(arguments + " --json");
    EXPECT_EQ(result.code, 0) << arguments << "\n" << result.err;
    return Json::parse(result.out);
  }
  std::vector<double> hertz(const std::string& material) {
    std::vector<double> values;
    const Json report = json(material + " --sensitivities");
    for (const Json& mode : report["sensitivities"]) values.push_back(mode["frequency_hz"]);
    return values;
  }
  void refused(const std::string& arguments, int code, const std::string& words) {
    const ProgramResult result = precompute(arguments);
    EXPECT_EQ(result.code, code) << arguments << "\n" << result.err;
    EXPECT_NE(result.err.find(words), std::string::npos) << arguments << "\n" << result.err;
  }
  std::string folder_;
};

// Whole runs with other constants; two steps of central differences without their common error.
TEST_F(FitProgram, SensitivitiesAreDifferencesOfRuns) {
  const auto material = [](double young, double nu, double density) {
    return "--young " + std::to_string(young) + " --poisson " + std::to_string(nu) + " --density " +
           std::to_string(density);
  };
  const double E = 2e9, nu = 0.3, rho = 1200.0;
  const Json modes = json(material(E, nu, rho) + " --sensitivities")["sensitivities"];
  ASSERT_EQ(modes.size(), 6U);
  const auto squared = [&](double by_e, double by_nu, double by_rho) {
    std::vector<double> values =
        hertz(material(E * (1.0 + by_e), nu + by_nu, rho * (1.0 + by_rho)));
    for (double& value : values) value = std::pow(2.0 * M_PI * value, 2);
    return values;
  };
  const auto expect_derivative = [&](const char* key, double unit, double e, double n, double r) {
    const auto quotients = [&](double h) {
      std::vector<double> more = squared(h * e, h * n, h * r);
      const std::vector<double> less = squared(-h * e, -h * n, -h * r);
      for (std::size_t k = 0; k < more.size(); ++k) more[k] = (more[k] - less[k]) / (2.0 * h);
      return more;
    };
    const std::vector<double> coarse = quotients(0.01), fine = quotients(0.005);
    for (const std::size_t k : {0U, 3U, 5U}) {
      const double omega = 2.0 * M_PI * double(modes[k]["frequency_hz"]);
      const double wanted = (4.0 * fine[k] - coarse[k]) / 3.0;
      const double got = unit * double(modes[k]["materials"][0][key]);
      EXPECT_NEAR(got, wanted, 1e-6 * omega * omega) << key << " mode " << k + 1;
    }
  };
  expect_derivative("omega2_by_young", E, 1.0, 0.0, 0.0);
  expect_derivative("omega2_by_poisson", 1.0, 0.0, 1.0, 0.0);
  expect_derivative("omega2_by_density", rho, 0.0, 0.0, 1.0);
}

TEST_F(FitProgram, AFitMakesTheModelOfTheMeasuredBody) {
  const std::string truth = "--young 2.4e9 --poisson 0.28 --density 1130 ";
  const std::string guess = "--young 2e9 --poisson 0.35 --density 1130 ";
  const std::vector<double> measured = hertz(truth);
  {
    std::ofstream csv(folder_ + "/m.csv");
    csv.precision(12);
    // The first E is 17 % low, too far to tell the modes by their frequencies alone.
    csv << "mode,frequency,frequency_sd,damping_ratio,damping_ratio_sd\n";
    for (const std::size_t k : {0U, 1U, 3U, 4U})  // with a gap
      csv << k + 1 << "," << measured[k] << "," << 0.01 * measured[k] << "," << 0.01 + 0.001 * double(k)
          << ",0.001\n";
  }
  const Json fit = json(guess + "--fit m.csv --fit-for young,poisson")["fit"];
  // The frequencies are those of a body without damping: the file's have it.
  EXPECT_NEAR(fit["unknowns"][0]["value"], 2.4e9, 2e-3 * 2.4e9);
  EXPECT_NEAR(fit["unknowns"][1]["value"], 0.28, 2e-3);
  EXPECT_EQ(fit["frequencies"][2]["mode"], 4);
  EXPECT_EQ(fit["degrees_of_freedom"], 2);
  const std::string ratios = fit["damping"]["damping_ratio"];
  EXPECT_EQ(std::count(ratios.begin(), ratios.end(), ','), 4);
  // The basis file is that of the fitted material, and a body moves with the fitted damping.
  const Json made = json(guess + "--fit m.csv --fit-for young,poisson --linear -o fitted.tremolo");
  for (std::size_t k = 0; k < 6; ++k)
    EXPECT_NEAR(made["frequencies_hz"][k], measured[k], 1e-3 * measured[k]);
  EXPECT_NEAR(made["materials"][0]["young_pa"], 2.4e9, 2e-3 * 2.4e9);
  const ProgramResult run =
      run_program(folder_, kTremolo +
                               "run fitted.tremolo --start near:0.5,0,0=0,0,1e-4 --load none "
                               "--duration 0.01 --step 1e-5 --damping-ratio " +
                               ratios);
  EXPECT_EQ(run.code, 0) << run.err;
  // With the mass the density too.
  const double mass = 1130.0 * 0.5 * 0.17 * 0.11;
  const Json both = json(
      "--young 2e9 --poisson 0.28 --density 1000 --fit m.csv --fit-for "
      "young,density --fit-mass " +
      std::to_string(mass))["fit"];
  EXPECT_NEAR(both["unknowns"][1]["value"], 1130.0, 1.0);
}

TEST_F(FitProgram, WhatCannotBeFittedIsRefused) {
  const auto file = [&](const std::string& text) { std::ofstream(folder_ + "/m.csv") << text; };
  file("frequency\n100\n200\n300\n");
  refused("--fit m.csv --fit-for young,density", 3, "--fit-mass");
  refused("--fit m.csv --fit-for stiffness", 2, "young, poisson, density");
  refused("--fit m.csv --fit-for young:grip", 2, "no material 'grip'");
  refused("--fit m.csv --fit-mass -1", 2, "--fit-mass -1");
  refused("--fit m.csv --fit-mass 1:x", 2, "--fit-mass");
  refused("--fit-mass 1 -o a.tremolo", 2, "--fit");
  refused("--fit none.csv", 1, "none.csv");
  refused("--fit m.csv --checkpoint", 2, "--output");
  file("frequency\n100\nx\n");
  refused("--fit m.csv", 3, "line 3");
  file("mode,frequency\n9,100\n");
  refused("--fit m.csv", 3, "--linear-modes");
  file("frequency\n1\n2\n3\n4\n5\n6\n7\n");
  refused("--fit m.csv", 3, "--linear-modes");
  file("frequency,damping_ratio\n100,120%\n");
  refused("--fit m.csv", 3, "below 1");
}

}  // namespace
}  // namespace tremolo
