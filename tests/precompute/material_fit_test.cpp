// Materials and damping from measurements that were made with known ones.
#include "precompute/sensitivity/material_fit.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "common/damping_ratios.h"
#include "precompute/problem/material_rules.h"
#include "precompute/ranks/halo.h"
#include "precompute/sensitivity/damping_fit.h"
#include "precompute/sensitivity/mode_matching.h"
#include "tests/support/assembled_body.h"
#include "tests/support/meshes/box_mesh.h"
#include "tests/support/meshes/symmetric_mesh.h"

namespace tremolo {
namespace {

using testing::box_mesh;
using testing::vertices_on_plane;
using Body = testing::AssembledBody;
using Eigen::Index;
using Eigen::VectorXd;

constexpr Index kModes = 8;
const Material kTruth{2.4e9, 0.28, 1130.0};
const Material kGuess{1e9, 0.4, 1000.0};

MaterialTable table_of(const Material& material) {
  return {{{"default", material}}, {}};
}

// A clamped block of three different sides, or of a square section: its modes by a dense solver.
struct Block {
  explicit Block(bool square = false)
      : mesh(square ? testing::symmetric_box({3, 1, 1}, {0.6, 0.1, 0.1})
                    : box_mesh({4, 2, 1}, {0.5, 0.17, 0.11})),
        fixed(vertices_on_plane(mesh, 0, square ? -0.3 : 0.0)) {}

  FitModel solve(const MaterialTable& table) const {
    const Body body(mesh, table, fixed);
    const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(
        body.dense(body.matrices.stiffness), body.dense(body.matrices.mass));
    const Columns vectors = solver.eigenvectors().leftCols(kModes);
    const BasisRows psi = expand_to_vertices(body.map, body.local, vectors);
    FitModel model;
    model.squared = solver.eigenvalues().head(kModes);
    model.clusters = find_clusters(model.squared, {1e-7});
    for (const ModalForms& forms :
         modal_forms(body.solid, mesh.tetrahedra.size(), psi, MassKind::kConsistent))
      model.by.push_back(mode_derivatives(forms, model.squared, model.clusters));
    for (const MaterialShare& share : material_shares(table, mesh))
      model.mass.push_back(share.volume);
    for (std::size_t m = 0; m < model.mass.size(); ++m)
      model.mass[m] *= table.materials[m].material.density;
    return model;
  }
  VectorXd hertz(const MaterialTable& table) const {
    return solve(table).squared.cwiseSqrt() / (2.0 * std::numbers::pi);
  }

  TetMesh mesh;
  std::vector<VertexId> fixed;
};

FitProblem problem_of(const Block& block, const std::string& unknowns, const Material& start) {
  FitProblem problem;
  problem.materials = table_of(start);
  problem.unknowns = *read_unknowns(unknowns, problem.materials);
  problem.solve = [&block](const MaterialTable& table) { return block.solve(table); };
  return problem;
}

MeasuredMode measured(double hertz, double deviation = 0.0, std::optional<int> mode = {}) {
  MeasuredMode row;
  row.frequency = Uncertain{hertz, deviation};
  row.mode = mode;
  return row;
}

TEST(MaterialFit, ExactMeasurementsGiveTheMaterial) {
  const Block block;
  const VectorXd hertz = block.hertz(table_of(kTruth));
  FitProblem problem = problem_of(block, "young,poisson,density", kGuess);
  for (Index k = 0; k < kModes; ++k)
    problem.measured.rows.push_back(measured(hertz[k], 0.01 * hertz[k], static_cast<int>(k)));
  problem.measured.frequency_deviations = true;
  problem.mass = Uncertain{kTruth.density * 0.5 * 0.17 * 0.11, 1e-3};
  const Result<MaterialFit> fit = fit_materials(problem);
  ASSERT_TRUE(fit) << fit.error().message;
  // The last move was below 1e-7.
  const Material& found = fit->materials.materials[0].material;
  EXPECT_NEAR(found.young, kTruth.young, 1e-7 * kTruth.young);
  EXPECT_NEAR(found.poisson, kTruth.poisson, 1e-7);
  EXPECT_NEAR(found.density, kTruth.density, 1e-7 * kTruth.density);
  EXPECT_LT(fit->chi_squared, 1e-8);
  EXPECT_EQ(fit->freedom, kModes + 1 - 3);
  EXPECT_LT(fit->solves, 12);
}

// E alone multiplies all frequencies by one number. If all are off by equal fractions and nothing
// else is known, it is the geometric mean of the measured ones over the computed.
TEST(MaterialFit, FrequenciesWithoutDeviationsCountByEqualFractions) {
  const Block block;
  const VectorXd hertz = block.hertz(table_of(kGuess));
  FitProblem problem = problem_of(block, "young", kGuess);
  double logarithms = 0.0;
  for (Index k = 0; k < kModes; ++k) {
    const double fraction = k % 2 == 0 ? 1.2 : 0.8;
    problem.measured.rows.push_back(measured(fraction * hertz[k], 0.0, static_cast<int>(k)));
    logarithms += std::log(fraction) / kModes;
  }
  const Result<MaterialFit> fit = fit_materials(problem);
  ASSERT_TRUE(fit) << fit.error().message;
  const double young = kGuess.young * std::exp(2.0 * logarithms);
  EXPECT_NEAR(fit->materials.materials[0].material.young, young, 1e-6 * young);
}

// A ratio of 30 %: the ringing body is 5 % below the frequency without damping, which nobody has
// measured.
TEST(MaterialFit, RowsShowTheFrequenciesOfTheRingingBody) {
  const Block block;
  const VectorXd hertz = block.hertz(table_of(kTruth));
  const double ringing = std::sqrt(1.0 - 0.3 * 0.3) * hertz[0];
  FitProblem problem = problem_of(block, "young", {2e9, 0.28, 1130.0});
  problem.measured = *parse_measurements(
      "mode,frequency,frequency_sd,damping_ratio\n1," + std::to_string(ringing) + ",1,30%\n",
      "m.csv");
  const Result<MaterialFit> fit = fit_materials(problem);
  ASSERT_TRUE(fit) << fit.error().message;
  const Material& found = fit->materials.materials[0].material;
  EXPECT_NEAR(found.young, kTruth.young, 1e-6 * kTruth.young);
  EXPECT_NEAR(fit->rows[0].measured, ringing, 1e-6);
  EXPECT_NEAR(fit->rows[0].fitted, ringing, 1e-6 * ringing);
  EXPECT_NEAR(fit->rows[0].deviation, 1.0, 1e-12);
}

// With errors of 1 % the distance from the truth in standard deviations is that of a normal
// distribution, and the misfit that of chi^2. The random numbers are fixed: the bounds are those
// that chance exceeds once in a thousand.
TEST(MaterialFit, NoiseIsRecoveredWithinItsOwnErrorBar) {
  constexpr int kSeeds = 20;
  const Block block;
  const VectorXd hertz = block.hertz(table_of(kTruth));
  const double mass = kTruth.density * 0.5 * 0.17 * 0.11;
  double squares[3] = {0.0, 0.0, 0.0}, misfit = 0.0;
  int freedom = 0;
  for (unsigned seed = 0; seed < kSeeds; ++seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    FitProblem problem = problem_of(block, "young,poisson,density", {2e9, 0.3, 1000.0});
    for (Index k = 0; k < kModes; ++k) {
      const double deviation = 0.01 * hertz[k];
      problem.measured.rows.push_back(
          measured(hertz[k] + deviation * normal(random), deviation, static_cast<int>(k)));
    }
    problem.measured.frequency_deviations = true;
    problem.mass = Uncertain{mass * (1.0 + 0.01 * normal(random)), 0.01 * mass};
    const Result<MaterialFit> fit = fit_materials(problem);
    ASSERT_TRUE(fit) << seed << ": " << fit.error().message;
    const double truth[3] = {kTruth.young, kTruth.poisson, kTruth.density};
    for (Index u = 0; u < 3; ++u)
      squares[u] += std::pow((fit->values[u] - truth[u]) / fit->deviations[u], 2);
    misfit += fit->chi_squared;
    freedom += fit->freedom;
    EXPECT_LT(fit->deviations[0], 0.1 * kTruth.young);
  }
  // chi^2 of 20: 5.9 to 45.3; of 120: 77 to 174.
  for (const double sum : squares) {
    EXPECT_GT(sum, 5.9);
    EXPECT_LT(sum, 45.3);
  }
  EXPECT_EQ(freedom, 6 * kSeeds);
  EXPECT_GT(misfit, 77.0);
  EXPECT_LT(misfit, 174.0);
}

TEST(MaterialFit, WithoutDeviationsTheMisfitGivesThem) {
  const Block block;
  const VectorXd hertz = block.hertz(table_of(kTruth));
  FitProblem problem = problem_of(block, "young", {2e9, kTruth.poisson, kTruth.density});
  const double noise[kModes] = {1.01, 0.99, 0.99, 1.01, 1.01, 0.99, 1.01, 0.99};
  for (Index k = 0; k < kModes; ++k)
    problem.measured.rows.push_back(measured(noise[k] * hertz[k], 0.0, static_cast<int>(k)));
  const Result<MaterialFit> fit = fit_materials(problem);
  ASSERT_TRUE(fit) << fit.error().message;
  EXPECT_FALSE(fit->absolute);
  // One percent of each, sqrt(8/7) by the lost degree of freedom; E goes with f^2, from 8 of them.
  EXPECT_NEAR(fit->deviations[0] / fit->values[0], 2.0 * 0.01 * std::sqrt(8.0 / 7.0 / 8.0), 1e-4);
  EXPECT_NEAR(fit->values[0], kTruth.young, 3.0 * fit->deviations[0]);
  // One frequency gives E, and no deviation.
  problem.measured.rows.resize(1);
  const Result<MaterialFit> one = fit_materials(problem);
  ASSERT_TRUE(one) << one.error().message;
  EXPECT_NEAR(one->values[0], kTruth.young * 1.01 * 1.01, 1e-6 * kTruth.young);
  EXPECT_TRUE(std::isnan(one->deviations[0]));
}

TEST(MaterialFit, FrequenciesAloneDoNotGiveStiffnessAndDensity) {
  const Block block;
  const VectorXd hertz = block.hertz(table_of(kTruth));
  FitProblem problem = problem_of(block, "young,density", kGuess);
  for (Index k = 0; k < 4; ++k) problem.measured.rows.push_back(measured(hertz[k]));
  const Result<MaterialFit> refused = fit_materials(problem);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, ErrorKind::kContent);
  EXPECT_NE(refused.error().message.find("do not determine young and density"), std::string::npos)
      << refused.error().message;
  EXPECT_NE(refused.error().message.find("--fit-mass"), std::string::npos);
  problem.measured.rows.resize(1);
  EXPECT_FALSE(fit_materials(problem));  // fewer values than unknowns
}

TEST(MaterialFit, AListWithGapsIsMatchedToItsModes) {
  const Block block;
  const VectorXd hertz = block.hertz(table_of(kTruth));
  FitProblem problem =
      problem_of(block, "young", {1.1 * kTruth.young, kTruth.poisson, kTruth.density});
  for (const Index k : {6, 0, 3}) problem.measured.rows.push_back(measured(hertz[k]));
  const Result<MaterialFit> fit = fit_materials(problem);
  ASSERT_TRUE(fit) << fit.error().message;
  EXPECT_EQ(fit->modes, (std::vector<int>{6, 0, 3}));
  EXPECT_NEAR(fit->values[0], kTruth.young, 1e-6 * kTruth.young);
  for (const FittedRow& row : fit->rows) EXPECT_FALSE(row.ambiguous);
}

// From half of E the frequencies are taken for those of higher modes: the rows are far off.
TEST(MaterialFit, AWrongMatchWithoutDeviationsIsNamed) {
  const Block block;
  const VectorXd hertz = block.hertz(table_of(kTruth));
  FitProblem problem =
      problem_of(block, "young", {0.4 * kTruth.young, kTruth.poisson, kTruth.density});
  for (const Index k : {0, 2, 3, 5}) problem.measured.rows.push_back(measured(hertz[k]));
  const Result<MaterialFit> wrong = fit_materials(problem);
  ASSERT_TRUE(wrong) << wrong.error().message;
  ASSERT_GT(std::abs(wrong->values[0] / kTruth.young - 1.0), 0.1);
  EXPECT_NE(misfit_warning(*wrong).find("is off by"), std::string::npos) << misfit_warning(*wrong);
  problem.materials = table_of({1.1 * kTruth.young, kTruth.poisson, kTruth.density});
  const Result<MaterialFit> right = fit_materials(problem);
  ASSERT_TRUE(right) << right.error().message;
  EXPECT_EQ(misfit_warning(*right), "");
}

// The first two modes of a square bar have one frequency: whichever of them a row takes, and
// whether both were measured, does not matter.
TEST(MaterialFit, EqualFrequenciesMayBeMeasuredOnceOrTwice) {
  const Block bar(true);
  const VectorXd hertz = bar.hertz(table_of(kTruth));
  ASSERT_NEAR(hertz[0], hertz[1], 1e-9 * hertz[0]);
  for (const std::vector<double>& factors :
       {std::vector<double>{1.0}, std::vector<double>{1.004, 0.996}}) {
    FitProblem problem = problem_of(bar, "young", {2.3e9, kTruth.poisson, kTruth.density});
    for (const double factor : factors)
      problem.measured.rows.push_back(measured(factor * hertz[0]));
    // Named, since the next mode is only 0.4 % above it.
    problem.measured.rows.push_back(measured(hertz[2], 0.0, 2));
    const Result<MaterialFit> fit = fit_materials(problem);
    ASSERT_TRUE(fit) << fit.error().message;
    EXPECT_EQ(fit->rows.front().equal, 2);
    EXPECT_NEAR(fit->values[0], kTruth.young, 1e-4 * kTruth.young);
  }
}

TEST(ModeMatching, IsNearestInTheWholeAndKeepsNamedModes) {
  const VectorXd hertz = (VectorXd(6) << 1.0, 2.0, 2.1, 5.0, 7.0, 9.0).finished();
  const auto modes = [&hertz](const std::vector<MeasuredMode>& rows) {
    return *match_modes(rows, hertz);
  };
  EXPECT_EQ(modes({measured(2.02), measured(6.8)}), (std::vector<int>{1, 4}));
  // Both are nearest to 2.0; together the second takes 2.1.
  EXPECT_EQ(modes({measured(2.02), measured(2.03)}), (std::vector<int>{1, 2}));
  EXPECT_EQ(modes({measured(8.0), measured(2.0, 0.0, 2)}), (std::vector<int>{5, 2}));
  EXPECT_EQ(modes({measured(2.1), measured(1.0, 0.0, 2)}), (std::vector<int>{1, 2}));
  std::vector<MeasuredMode> many(7, measured(1.0));
  EXPECT_FALSE(match_modes(many, hertz));
  EXPECT_FALSE(match_modes({measured(1.0, 0.0, 6)}, hertz));
}

// ---- damping ----

TEST(DampingFit, RayleighDampingIsRecoveredWithinItsErrorBar) {
  constexpr double kAlpha = 1.3, kBeta = 4e-5;
  constexpr int kSeeds = 200;
  const VectorXd hertz = VectorXd::LinSpaced(6, 10.0, 400.0);
  std::vector<int> modes = {0, 1, 2, 3, 4, 5};
  double squares[2] = {0.0, 0.0}, misfit = 0.0;
  for (unsigned seed = 0; seed < kSeeds; ++seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    Measurements measurements;
    measurements.ratio_deviations = true;
    for (Index k = 0; k < 6; ++k) {
      const double omega = 2.0 * std::numbers::pi * hertz[k];
      const double ratio = 0.5 * kAlpha / omega + 0.5 * kBeta * omega;
      MeasuredMode row = measured(hertz[k]);
      row.ratio = Uncertain{ratio * (1.0 + 0.01 * normal(random)), 0.01 * ratio};
      measurements.rows.push_back(row);
    }
    const auto fit = fit_damping(measurements, modes, hertz);
    ASSERT_TRUE(fit);
    squares[0] += std::pow((fit->alpha.value - kAlpha) / fit->alpha.deviation, 2);
    squares[1] += std::pow((fit->beta.value - kBeta) / fit->beta.deviation, 2);
    misfit += fit->chi_squared;
    EXPECT_EQ(fit->freedom, 4);
  }
  // chi^2 of 200 and of 800, once in a thousand beyond.
  for (const double sum : squares) {
    EXPECT_GT(sum, 140.0);
    EXPECT_LT(sum, 272.0);
  }
  EXPECT_GT(misfit, 682.0);
  EXPECT_LT(misfit, 931.0);
}

// Mean and root mean square of (fitted - true)/deviation of alpha and beta, over many ring-downs or
// ratios of 15 % noise.
struct Bias {
  double mean[2] = {0.0, 0.0}, square[2] = {0.0, 0.0};
};
Bias bias_of(bool decays, bool deviations) {
  constexpr double kAlpha = 3.0, kBeta = 2e-6, kNoise = 0.15;
  constexpr int kSeeds = 400;
  const VectorXd hertz{{61.0, 90.0, 380.0, 560.0, 1050.0, 1550.0, 2000.0, 2900.0}};
  const std::vector<int> modes = {0, 1, 2, 3, 4, 5, 6, 7};
  Bias bias;
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  for (int seed = 0; seed < kSeeds; ++seed) {
    Measurements measurements;
    measurements.ratio_deviations = deviations;
    for (Index k = 0; k < 8; ++k) {
      const double omega = 2.0 * std::numbers::pi * hertz[k];
      const double ratio = 0.5 * kAlpha / omega + 0.5 * kBeta * omega;
      const double exact = decays ? 1.0 / (ratio * omega) : ratio;
      const Uncertain value{exact * (1.0 + kNoise * normal(random)),
                            deviations ? kNoise * exact : 0.0};
      MeasuredMode row = measured(hertz[k]);
      row.ratio = value;
      if (decays) {
        row.decay = value;
        row.ratio = Uncertain{1.0 / (value.value * omega), 0.0};
      }
      measurements.rows.push_back(row);
    }
    const auto fit = fit_damping(measurements, modes, hertz);
    const double offs[2] = {(fit->alpha.value - kAlpha) / fit->alpha.deviation,
                            (fit->beta.value - kBeta) / fit->beta.deviation};
    for (int i = 0; i < 2; ++i) {
      bias.mean[i] += offs[i] / kSeeds;
      bias.square[i] += offs[i] * offs[i] / kSeeds;
    }
  }
  return bias;
}

// Weights by the measured values favour those measured low: they shift alpha or beta by up to one
// of its deviations.
TEST(DampingFit, RatiosAndRingDownsWithNoiseHaveNoBias) {
  for (const bool decays : {false, true})
    for (const bool deviations : {false, true}) {
      const Bias bias = bias_of(decays, deviations);
      for (int i = 0; i < 2; ++i) {
        // The mean of 400 has a deviation of 0.05 to 0.06. The equations are not linear: noise of
        // 15 % is 2 % of it squared, 0.15 of a deviation.
        EXPECT_LT(std::abs(bias.mean[i]), 0.3) << decays << deviations << i;
        // Student's t with six degrees of freedom has the variance 1.5.
        EXPECT_LT(bias.square[i], deviations ? 1.3 : 2.0) << decays << deviations << i;
        EXPECT_GT(bias.square[i], 0.75) << decays << deviations << i;
      }
    }
}

TEST(DampingFit, RatiosThatNeedANegativeConstantGiveTheOtherAlone) {
  const VectorXd hertz = VectorXd::LinSpaced(3, 10.0, 30.0);
  Measurements measurements;
  for (const Index k : {0, 2}) {
    MeasuredMode row = measured(hertz[k]);
    row.ratio = Uncertain{k == 0 ? 0.001 : 0.05, 0.0};
    measurements.rows.push_back(row);
  }
  const auto fit = fit_damping(measurements, {0, 2}, hertz);
  ASSERT_TRUE(fit);
  EXPECT_EQ(fit->alpha.value, 0.0);
  EXPECT_GT(fit->beta.value, 0.0);
  // The mode between them has a ratio by frequency; the text is one for --damping-ratio.
  const Result<DampingRatios> list = parse_damping(fit->ratios);
  ASSERT_TRUE(list) << fit->ratios;
  ASSERT_EQ(list->of_modes.size(), 3U);
  EXPECT_NEAR(list->of_modes[1], 0.0255, 1e-9);
  EXPECT_NEAR(list->of_modes[2], 0.05, 1e-9);
  Measurements none;
  none.rows.push_back(measured(10.0));
  EXPECT_FALSE(fit_damping(none, {0}, hertz));
}

// ---- the file ----

TEST(Measurements, ARingDownGivesRatioAndUndampedFrequency) {
  const Result<Measurements> read = parse_measurements(
      "# a bell\nmode, frequency, frequency_sd, decay_time\n1, 10, 0.1, 0.5\n\n3, 40, 0.2,\n",
      "m.csv");
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_EQ(read->rows.size(), 2U);
  EXPECT_TRUE(read->frequency_deviations);
  EXPECT_FALSE(read->ratio_deviations);
  const MeasuredMode& row = read->rows[0];
  EXPECT_EQ(row.mode, 0);
  // e^{-t/0.5} cos(20 pi t): s = -2 +- 20 pi i.
  const double omega = std::hypot(2.0, 20.0 * std::numbers::pi);
  EXPECT_NEAR(row.ratio->value, 2.0 / omega, 1e-15);
  EXPECT_NEAR(row.frequency->value, omega / (2.0 * std::numbers::pi), 1e-13);
  EXPECT_EQ(read->rows[1].mode, 2);
  EXPECT_FALSE(read->rows[1].ratio);
}

TEST(Measurements, AByteOrderMarkIsSkipped) {
  const Result<Measurements> read =
      parse_measurements("\xef\xbb\xbfmode,frequency\n1,8.4\n", "m.csv");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->rows[0].mode, 0);
}

TEST(Measurements, WrongFilesAreRefusedWithTheLine) {
  for (const auto& [text, words] : {
           std::pair{"", "no measurement"},
           {"frequency\n", "no measurement"},
           {"10\n", "no column '10'"},
           {"frequency,frequency\n1,2\n", "twice"},
           {"damping_ratio\n1%\n", "needed"},
           {"frequency\n1,2\n", "line 2: it has 2 cells"},
           {"frequency\nx\n", "line 2: frequency: 'x'"},
           {"frequency\nnan\n", "line 2"},
           {"frequency\n-1\n", "must be positive"},
           {"frequency\n0\n", "must be positive"},
           {"mode,frequency\n1.5,3\n", "mode must be"},
           {"mode,frequency\n1,3\n1,4\n", "line 3: mode 1 is there twice"},
           {"frequency\n3\n3\n", "line 3: this frequency is there twice"},
           {"mode,frequency\n,\n", "neither"},
           {"mode,frequency\n1,\n", "neither a frequency nor damping"},
           {"frequency,damping_ratio\n3,100%\n", "below 1"},
           {"frequency,damping_ratio,decay_time\n3,1%,2\n", "not both"},
           {"mode,frequency,decay_time\n1,,2\n", "needs the frequency"},
           {"frequency,frequency_sd\n3,0.1\n4,\n", "all or none"},
           // Milliseconds.
           {"mode,frequency,decay_time\n1,5,1\n2,48.36,0.0009\n",
            "line 3: a decay_time of 0.0009 s is shorter than the period of 48.36 Hz, 0.0207 s"},
           {"mode,frequency,decay_time\n1,47,1e-9\n", "line 2: a decay_time"},
       }) {
    const Result<Measurements> wrong = parse_measurements(text, "m.csv");
    ASSERT_FALSE(wrong) << text;
    EXPECT_EQ(wrong.error().kind, ErrorKind::kContent);
    EXPECT_NE(wrong.error().message.find(words), std::string::npos) << wrong.error().message;
    EXPECT_EQ(wrong.error().message.find("m.csv"), 0U) << wrong.error().message;
  }
}

TEST(MaterialFit, UnknownsAreNamedByConstantAndRegion) {
  MaterialTable table;
  table.materials = {{"grip", {}}, {"blade", {}}};
  table.materials[1].material.orthotropic = OrthotropicElasticity{};
  EXPECT_EQ(read_unknowns("young", table)->size(), 2U);
  EXPECT_EQ(read_unknowns("young,density:blade", table)->size(), 3U);
  EXPECT_EQ(name_of((*read_unknowns("poisson:grip", table))[0], table), "poisson of `grip`");
  for (const char* wrong : {"", "stiffness", "young:", "young:hilt", "young,young:grip"}) {
    const auto refused = read_unknowns(wrong, table);
    ASSERT_FALSE(refused) << wrong;
    EXPECT_EQ(refused.error().kind, ErrorKind::kUsage) << wrong;
  }
  EXPECT_EQ(read_unknowns("poisson", table).error().kind, ErrorKind::kContent);
}

}  // namespace
}  // namespace tremolo
