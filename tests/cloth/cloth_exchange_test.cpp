// Slow exchange of energy between stiff springs that soft ones couple: imex against all implicit
// and all explicit.
//
// The stiff springs swing with amplitudes that the method itself gives them: of an energy of 1 J,
// imex and the truth have the positions that belong to it; midpoint evaluates the soft force in the
// middle of the step, where the amplitude is less by cos(phase/2) = (1 + y^2/4)^(-1/2), y = h
// omega; symplectic Euler keeps 1/2 p^2 + 1/2 q^2 - y/2 p q, so that an energy of 1 J in the
// stretch swells in the mean to 1/(1 - y^2/4). A quartic coupling hands energy over at a rate that
// is proportional to the amplitude's square, and what has gone over at first to that rate's square:
// midpoint shows (1 + y^2/4)^-2 of it.
#include <cmath>

#include <gtest/gtest.h>

#include "runtime/step/nodal_integrator.h"
#include "tests/cloth/cloth_samples.h"
#include "tests/cloth/stiff_stair.h"

namespace tremolo {
namespace {

// The means over 20 to 40 s of the treads' energies.
Eigen::Vector3d exchanged(const char* method, double step) {
  const Result<ClothModel> model = testing::stiff_stair();
  EXPECT_TRUE(model);
  const NodalOptions options{.step = step, .tolerance = 1e-11, .guard = false};
  const auto integrator = make_nodal_integrator(method, *model, options);
  EXPECT_TRUE(integrator);
  NodalState state = testing::stair_start(*model);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int count = 0;
  while (state.time < 40.0) {
    EXPECT_TRUE((*integrator)->step(state).made) << method;
    if (state.time < 20.0) continue;
    sum += testing::stair_energies(state);
    ++count;
  }
  return sum / count;
}

TEST(ClothExchange, ImexHandsEnergyOverAsTheTruthDoesWhereAllImplicitLagsAndAllExplicitSwells) {
  // y = 0.1 and fourth order: 1e-3 of the first tread's energy is lost by then.
  const Eigen::Vector3d truth = exchanged("rk4", 0.002);
  EXPECT_NEAR(truth.sum(), 1.0, 2e-3);
  EXPECT_GT(truth[1], 0.04);
  for (const double step : {0.01, 0.03}) {
    const double y = step * testing::kStairOmega;
    const Eigen::Vector3d imex = exchanged("imex", step);
    EXPECT_NEAR(imex[1], truth[1], 0.01 * truth[1]) << step;
    EXPECT_NEAR(imex.sum(), 1.0, 2e-3) << step;
    const double less = std::pow(1.0 + 0.25 * y * y, -2);
    for (const char* method : {"midpoint", "energy"})
      EXPECT_NEAR(exchanged(method, step)[1], less * truth[1], 0.03 * truth[1]) << method << step;
    const double swollen = 1.0 / (1.0 - 0.25 * y * y);
    EXPECT_NEAR(exchanged("symplectic-euler", step).sum(), swollen, 5e-3 * swollen) << step;
  }
  // All explicit is right where it takes the fifteenfold of steps.
  EXPECT_NEAR(exchanged("symplectic-euler", 0.002)[1], truth[1], 0.01 * truth[1]);
  // implicit-euler leaves nothing to hand over: what it shows is the drift's.
  EXPECT_LE(exchanged("implicit-euler", 0.03).sum(), 1e-4);
}

}  // namespace
}  // namespace tremolo
