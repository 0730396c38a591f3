// Advantages of the two variational splits over imexv, and the price of each.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/support/dynamics.h"

namespace tremolo {
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
}  // namespace tremolo
