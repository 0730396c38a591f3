// Energy that is kept, and orders, on whole sheets.
#include <algorithm>
#include <cmath>
#include <string_view>

#include <gtest/gtest.h>

#include "runtime/bodies/cloth/cloth_world.h"
#include "runtime/step/nodal_integrator.h"
#include "tests/cloth/cloth_samples.h"
#include "tests/support/nodal_orders.h"

namespace tremolo {
namespace {

using Eigen::VectorXd;

// A sheet without damping or air that falls from the level and swings on one edge.
ClothScene swinging_sheet(std::size_t edge) {
  ClothScene scene;
  scene.integrator = "energy";
  scene.options.step = 1.0 / 60.0;
  scene.options.tolerance = 1e-12;
  scene.gravity.times = {0.0};
  scene.gravity.values = {{0.0, 0.0, -9.81}};
  SceneCloth cloth = testing::sample_sheet(edge, edge);
  cloth.grid.width = cloth.grid.height = 1.0;
  cloth.bend.stiffness = 2.0;
  ClothPin top;
  for (std::size_t k = 0; k < edge; ++k) top.particles.push_back(edge * (edge - 1) + k);
  top.until = 1e300;
  cloth.pins = {top};
  scene.cloths = {cloth};
  return scene;
}

// The largest change of the energy over the largest kinetic energy.
double energy_drift(std::size_t edge, int steps) {
  Result<ClothWorld> world = ClothWorld::create(swinging_sheet(edge));
  EXPECT_TRUE(world) << world.error().message;
  const double start = world->energy().total();
  double drift = 0.0, kinetic = 0.0;
  for (int k = 0; k < steps; ++k) {
    const Status made = world->step();
    EXPECT_TRUE(made) << k;
    if (!made) break;
    const ClothEnergy energy = world->energy();
    drift = std::max(drift, std::abs(energy.total() - start));
    kinetic = std::max(kinetic, energy.kinetic);
  }
  EXPECT_GT(kinetic, 0.3);
  return drift / kinetic;
}

TEST(ClothOrder, ASheetThatSwingsFreelyKeepsItsEnergy) {
  EXPECT_LE(energy_drift(11, 300), 1e-9);
}

#ifdef TREMOLO_LONG_TESTS
TEST(ClothOrder, ASheetThatSwingsFreelyKeepsItsEnergyForAMinute) {
  EXPECT_LE(energy_drift(21, 3600), 1e-9);
}
#endif

VectorXd places_after(const ClothModel& model, std::string_view method, double step,
                      double duration) {
  const NodalOptions options{.step = step, .tolerance = 1e-13, .guard = false};
  const auto integrator = make_nodal_integrator(method, model, options);
  EXPECT_TRUE(integrator);
  NodalState state{model.parts().x, VectorXd::Zero(model.parts().x.size()), 0.0};
  // A smooth blow, as a corner's would not be resolved.
  for (Eigen::Index i = 0; i < state.x.size(); i += 3)
    state.v[i + 2] = 0.5 * std::sin(3.0 * state.x[i]) * std::cos(2.0 * state.x[i + 1]);
  const auto steps = static_cast<int>(std::lround(duration / step));
  for (int k = 0; k < steps; ++k) EXPECT_TRUE((*integrator)->step(state).made) << method << k;
  return state.x;
}

TEST(ClothOrder, MethodsHaveTheirOrderOnASheetThatFliesAndBends) {
  constexpr double kDuration = 0.08;
  SceneCloth cloth = testing::sample_sheet(6, 5);
  cloth.structural = {20.0, 0.01};
  cloth.shear = {8.0, 0.01};
  cloth.bend = {1.0, 0.001};
  ClothModel model = testing::sample_model(cloth);
  model.set_gravity({0.0, 0.0, -9.81});
  const VectorXd truth = places_after(model, "rk4", kDuration / 3200.0, kDuration);
  for (const auto& [method, order] : testing::kNodalOrders) {
    const double coarse = (places_after(model, method, kDuration / 40.0, kDuration) - truth).norm();
    const double fine = (places_after(model, method, kDuration / 80.0, kDuration) - truth).norm();
    EXPECT_NEAR(std::log2(coarse / fine), order, 0.12) << method << " " << coarse;
  }
}

}  // namespace
}  // namespace tremolo
