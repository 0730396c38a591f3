// imexv-adaptive: the low block stays within its bound, coordinates move early and come back late.
#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "tests/support/dynamics.h"

namespace tremolo {
namespace {

using testing::make;

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
