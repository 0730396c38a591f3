#include "runtime/split.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "tests/support/dynamics.h"

namespace tremolo {
namespace {

// h omega of 0.5, 1.79, 1.81, 3, 6.28, 6.29 at h = 1.
const Eigen::VectorXd kLambda =
    Eigen::Vector<double, 6>(0.5, 1.79, 1.81, 3.0, 6.28, 6.29).cwiseAbs2();

TEST(Split, DefaultTakesWhatIsStableWithAMargin) {
  const Result<Split> split = choose_split(kLambda, 1.0, {});
  EXPECT_EQ(split->low, 2);
  EXPECT_EQ(split->high, 4);
}

TEST(Split, SafetyOneIsTheStabilityLimit) {
  EXPECT_EQ(choose_split(kLambda, 1.0, {.safety = 1.0})->low, 3);
}

TEST(Split, ThesisRuleComparesTheFrequencyWithTheStepRate) {
  // 2 pi = 6.283...: the fifth is below, the sixth above.
  EXPECT_EQ(choose_split(kLambda, 1.0, {.rule = SplitRule::kThesis})->low, 5);
}

TEST(Split, ScalesWithTheStep) {
  EXPECT_EQ(choose_split(kLambda, 0.1, {})->low, 6);
  EXPECT_EQ(choose_split(kLambda, 10.0, {})->low, 0);
}

TEST(Split, CountIsTakenAsGivenWithinTheModel) {
  EXPECT_EQ(choose_split(kLambda, 1.0, {.rule = SplitRule::kCount, .count = 6})->high, 0);
  EXPECT_EQ(choose_split(kLambda, 1.0, {.rule = SplitRule::kCount, .count = 7}).error().kind,
            ErrorKind::kUsage);
}

TEST(Split, RefusesASafetyOutsideItsRange) {
  EXPECT_FALSE(choose_split(kLambda, 1.0, {.safety = 0.0}));
  EXPECT_FALSE(choose_split(kLambda, 1.0, {.safety = 1.01}));
}

TEST(Split, IsReadFromItsName) {
  EXPECT_EQ(parse_split("default")->rule, SplitRule::kDefault);
  EXPECT_EQ(parse_split("thesis")->rule, SplitRule::kThesis);
  EXPECT_EQ(parse_split("9")->count, 9);
  for (const char* bad : {"", "-1", "9x", "half", "99999999999"})
    EXPECT_EQ(parse_split(bad).error().kind, ErrorKind::kUsage) << bad;
}

}  // namespace

// Advantages of the two variational splits over imexv, and the price of each.

namespace {

using testing::make;

constexpr double kSplitStep = 3e-3;  // s

// Four coordinates, the last two with h omega of 2.8 and 4.5.
testing::StrainModel split_strain_model() {
  return testing::random_strain_model(Eigen::Vector4d(20.0, 90.0, 930.0, 1500.0), 0.5, 17);
}

// The largest energy over 20 000 steps relative to the first; infinity if a step fails.
double energy_growth(const char* name, double size) {
  const testing::StrainModel strain = split_strain_model();
  IntegratorOptions options{.step = kSplitStep};
  options.halvings = 0;
  const auto integrator = make(name, testing::make_model(strain), options);
  EXPECT_EQ(integrator->split()->low, 2);
  State state{size * Eigen::Vector4d(1.0, -0.3, 0.0, 0.0), Eigen::VectorXd::Zero(4)};
  const double initial = testing::strain_energy(strain, state.q);
  double largest = initial;
  for (int k = 0; k < 20000; ++k) {
    if (!integrator->step(state, make_step_load(4)).converged) return INFINITY;
    const double energy = 0.5 * state.p.squaredNorm() + testing::strain_energy(strain, state.q);
    largest = std::max(largest, energy);
  }
  return largest / initial;
}

TEST(VariationalSplit, InSmallMotionTheEnergyOfBothStays) {
  // h omega = 0.27 on the highest low row: (h omega)^2/4 = 2 %, times its fraction of the energy.
  EXPECT_LE(energy_growth("imexv-linear", 0.01), 1.01);
  EXPECT_LE(energy_growth("imexv-coupled", 0.01), 1.01);
}

TEST(VariationalSplit, StiffeningBreaksTheLinearOneBeforeTheOthers) {
  // The stiffening of the high rows is kicked explicitly at h omega = 4.5.
  EXPECT_EQ(energy_growth("imexv-linear", 0.1), INFINITY);
  EXPECT_LE(energy_growth("imexv", 0.1), 1.01);
  EXPECT_LE(energy_growth("imexv-coupled", 0.1), 1.01);
}

TEST(VariationalSplit, LinearOneSolvesNothing) {
  const auto integrator =
      make("imexv-linear", testing::make_model(split_strain_model()), {.step = kSplitStep});
  State state{testing::random_vector(4, 0.02, 1), testing::random_vector(4, 1.0, 2)};
  EXPECT_EQ(integrator->step(state, make_step_load(4)).iterations, 0);
}

TEST(VariationalSplit, SplitOutsideTheModelIsRefused) {
  IntegratorOptions options{.step = kSplitStep};
  options.split = {.rule = SplitRule::kCount, .count = 5};
  for (const char* name : {"imexv-linear", "imexv-coupled"}) {
    const auto made = make_integrator(name, testing::make_model(split_strain_model()), options);
    ASSERT_FALSE(made) << name;
    EXPECT_EQ(made.error().kind, ErrorKind::kUsage) << name;
  }
}

}  // namespace

// imexv-adaptive: the low block stays within its bound, coordinates move early and come back late.

namespace {

constexpr double kStiffStep = 3e-3;

// h omega from 0.1 to 3, one row high at rest, strongly coupled. blocks: that many leading
// coordinates do not couple with the others.
testing::StrainModel stiff_strain_model(double nonlinearity = 0.5, Eigen::Index blocks = 0) {
  return testing::random_strain_model(testing::spread_omega(6, 33.0, 1000.0), nonlinearity, 5,
                                      blocks);
}

State stiff_state(double size) {
  return {size * testing::random_vector(6, 1.0, 3), Eigen::VectorXd::Zero(6)};
}

double largest_low_eigenvalue(const Model& model, const Eigen::VectorXd& q, Eigen::Index low) {
  PotentialWorkspace workspace = model.potential().make_workspace();
  Evaluation evaluation = model.potential().make_evaluation();
  model.potential().evaluate(q, kWantTangent, workspace, evaluation);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(
      evaluation.tangent.topLeftCorner(low, low));
  return eigen.eigenvalues().maxCoeff();
}

TEST(AdaptiveSplit, LowBlockNeverExceedsItsBoundWhereAStepBegins) {
  const Model::Pointer model = testing::make_model(stiff_strain_model());
  const IntegratorOptions options{.step = kStiffStep};
  const auto integrator = make("imexv-adaptive", model, options);
  State state = stiff_state(0.15);
  const double bound = std::pow(2.0 * 0.95 / kStiffStep, 2);
  int moved = 0;
  Eigen::Index low = integrator->split()->low;
  for (int k = 0; k < 2000; ++k) {
    const Eigen::VectorXd q = state.q;
    ASSERT_TRUE(integrator->step(state, make_step_load(6)).converged) << k;
    const Eigen::Index now = integrator->split()->low;
    if (now != low) ++moved;
    low = now;
    if (now > 0) {
      EXPECT_LT(largest_low_eigenvalue(*model, q, now), bound * (1.0 + 1e-12)) << k;
    }
  }
  EXPECT_GT(moved, 0) << "the motion never stiffened the low block: the test shows nothing";
}

TEST(AdaptiveSplit, KeepsItsEnergyWhereTheFixedSplitBlowsUp) {
  const testing::StrainModel strain = stiff_strain_model();
  const Model::Pointer model = testing::make_model(strain);
  const auto worst_energy = [&](const char* name, double size) {
    const auto integrator = make(name, model, {.step = kStiffStep});
    State state = stiff_state(size);
    const auto energy = [&] {
      return 0.5 * state.p.squaredNorm() + testing::strain_energy(strain, state.q);
    };
    const double initial = energy();
    double worst = 1.0;
    for (int k = 0; k < 5000; ++k) {
      if (!integrator->step(state, make_step_load(6)).converged) return 1e300;
      worst = std::max(worst, energy() / initial);
    }
    return worst;
  };
  // The motion is chaotic: starts that differ by 1e-9 reach 1.3 to 3, by the midpoint rule itself
  // 1.1 to 2.7. So the median of some, and none that grows without end.
  std::vector<double> worst;
  for (int k = 0; k < 9; ++k)
    worst.push_back(worst_energy("imexv-adaptive", 0.05 * (1 + 1e-9 * k)));
  std::sort(worst.begin(), worst.end());
  EXPECT_LE(worst[4], 2.0);
  EXPECT_LE(worst[8], 10.0);
  EXPECT_GE(worst_energy("imexv", 0.05), 1e3);
}

TEST(AdaptiveSplit, SmallMotionIsThatOfTheFixedSplit) {
  const Model::Pointer model = testing::make_model(stiff_strain_model());
  const IntegratorOptions options{.step = kStiffStep, .alpha = 0.3, .beta = 1e-5};
  State a = stiff_state(1e-3), b = a;
  testing::run(*make("imexv-adaptive", model, options), a, {}, kStiffStep, 500);
  testing::run(*make("imexv", model, options), b, {}, kStiffStep, 500);
  EXPECT_LE((a.q - b.q).norm(), 1e-12 * stiff_state(1e-3).q.norm());  // the same operations
}

TEST(AdaptiveSplit, CoordinatesComeBackOnlyAfterTheMotionHasCalmedDown) {
  // Without coupling between low and high rows no energy is added, which would stay.
  const Model::Pointer model = testing::make_model(stiff_strain_model(0.5, 5));
  const IntegratorOptions options{.step = kStiffStep};
  const auto integrator = make("imexv-adaptive", model, options);
  const Eigen::Index at_rest = integrator->split()->low;
  State state = stiff_state(0.2);
  testing::run(*integrator, state, {}, kStiffStep, 100);
  ASSERT_LT(integrator->split()->low, at_rest);
  // Calm from now on.
  state = stiff_state(1e-4);
  const Eigen::Index left = integrator->split()->low;
  testing::run(*integrator, state, {}, kStiffStep, 60);
  EXPECT_EQ(integrator->split()->low, left) << "came back at once";
  testing::run(*integrator, state, {}, kStiffStep, 1000);
  EXPECT_EQ(integrator->split()->low, at_rest);
}

}  // namespace
}  // namespace tremolo
