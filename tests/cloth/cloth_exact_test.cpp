// Cases of cloth whose answers are known in closed form.
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "runtime/bodies/cloth/cloth_model.h"
#include "runtime/bodies/cloth/cloth_world.h"
#include "tests/cloth/cloth_samples.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kGravity = 9.81;

Vector3d cloth_centroid(const ClothWorld& world) {
  const VectorXd& mass = world.model(0).mass();
  Vector3d sum = Vector3d::Zero();
  for (Eigen::Index i = 0; i < mass.size(); ++i)
    sum += mass[i] * world.positions(0).segment<3>(3 * i);
  return sum / mass.sum();
}

ClothScene free_fall(const std::string& integrator, double step) {
  ClothScene scene;
  scene.integrator = integrator;
  scene.options.step = step;
  scene.gravity.values = {{0.0, 0.0, -kGravity}};
  SceneCloth cloth = testing::sample_sheet(8, 7);
  cloth.structural.damping = 0.2;
  cloth.shear.damping = 0.1;
  cloth.bend.damping = 0.02;
  cloth.crumple = 0.05;
  scene.cloths = {cloth};
  return scene;
}

// Extension of each spring: what hangs below it, m g/k.
TEST(ClothExact, AHangingChainOfMassesStretchesByTheWeightBelow) {
  constexpr std::size_t kSprings = 10;
  constexpr double kStiffness = 500.0, kRest = 0.1, kMass = 0.02;
  for (const char* name : {"implicit-euler", "midpoint", "newmark", "bdf2", "energy"}) {
    Result<ClothModel> model = ClothModel::create(
        testing::sample_chain(kSprings, {0.0, 0.0, -kRest}, kRest, kMass, {kStiffness, 4.0}));
    ASSERT_TRUE(model);
    model->set_gravity({0.0, 0.0, -kGravity});
    ASSERT_TRUE(model->pin(std::array<std::size_t, 1>{0}, MotionPath{}, 1e300));
    NodalOptions options{.step = 0.02, .tolerance = 1e-12};
    auto integrator = make_nodal_integrator(name, *model, options);
    ASSERT_TRUE(integrator);
    NodalState state{model->parts().x, VectorXd::Zero(3 * (kSprings + 1)), 0.0};
    for (int k = 0; k < 4000; ++k) ASSERT_TRUE((*integrator)->step(state).made) << name << k;
    for (std::size_t i = 0; i < kSprings; ++i) {
      const auto at = 3 * static_cast<Eigen::Index>(i);
      const double stretch = (state.x.segment<3>(at) - state.x.segment<3>(at + 3)).norm() - kRest;
      const double below = static_cast<double>(kSprings - i) * kMass;
      // Newton's residual, 1e-12 of a weight of 2 N, over 500 N/m, and what has not died down.
      EXPECT_NEAR(stretch, below * kGravity / kStiffness, 1e-9) << name << i;
    }
  }
}

TEST(ClothExact, ACrumpledClothFallsStraightByTheMethodsOwnParabola) {
  struct Case {
    const char* name;
    double shift;  // centroid: -g/2 t (t + shift h)
  };
  for (const Case& known :
       {Case{"explicit-euler", -1.0}, Case{"symplectic-euler", 1.0}, Case{"implicit-euler", 1.0},
        Case{"implicit-euler-linear", 1.0}, Case{"explicit-midpoint", 0.0}, Case{"midpoint", 0.0},
        Case{"energy", 0.0}, Case{"newmark", 0.0}, Case{"rk4", 0.0}}) {
    constexpr double kStep = 2e-4;
    ClothScene scene = free_fall(known.name, kStep);
    scene.options.tolerance = 1e-12;
    Result<ClothWorld> world = ClothWorld::create(scene);
    ASSERT_TRUE(world) << known.name << world.error().message;
    const Vector3d start = cloth_centroid(*world);
    for (int k = 0; k < 500; ++k) ASSERT_TRUE(world->step());
    const double t = world->time();
    const Vector3d fallen = cloth_centroid(*world) - start;
    // Rounding of 500 steps; Newton's residual, 1e-12 of the weight, adds up to less.
    EXPECT_NEAR(fallen.z(), -0.5 * kGravity * t * (t + known.shift * kStep), 1e-12) << known.name;
    EXPECT_LE(std::abs(fallen.x()) + std::abs(fallen.y()), 1e-12) << known.name;
  }
}

TEST(ClothExact, StabilityNumbersOfADampedSpringAreThoseOfTheClosedForms) {
  for (const double zeta : {0.0, 0.1, 0.5, 1.0})
    EXPECT_NEAR(damped_stability_number("symplectic-euler", zeta),
                2.0 * (std::sqrt(1.0 + zeta * zeta) - zeta), 1e-6);
  EXPECT_NEAR(damped_stability_number("rk4", 0.0), std::sqrt(8.0), 1e-6);
  EXPECT_NEAR(damped_stability_number("implicit-euler-sweep", 0.0), 2.0 / std::sqrt(3.0), 1e-6);
  EXPECT_NEAR(damped_stability_number("explicit-euler", 0.1), 0.2, 1e-6);
  EXPECT_EQ(damped_stability_number("explicit-euler", 0.0), 0.0);
  EXPECT_TRUE(std::isinf(damped_stability_number("implicit-euler", 0.0)));
}

// Largest speed after many steps from a flat sheet with tiny velocities.
double speed_after(const char* name, const ClothModel& model, double step) {
  NodalOptions options;
  options.step = step;
  auto integrator = make_nodal_integrator(name, model, options);
  EXPECT_TRUE(integrator);
  NodalState state{model.parts().x, testing::random_numbers(model.parts().x.size(), 1e-9, 3), 0.0};
  // In the plane of the sheet, where its springs are linear.
  for (Eigen::Index i = 2; i < state.v.size(); i += 3) state.v[i] = 0.0;
  for (int k = 0; k < 1500; ++k)
    if (!(*integrator)->step(state).made) return 1e300;
  return state.v.lpNorm<Eigen::Infinity>();
}

TEST(ClothExact, SheetsBlowUpAtTheStepOfTheirOwnLargestFrequency) {
  struct Sheet {
    std::size_t columns, rows;
    double structural, shear, bend;
  };
  for (const Sheet& sheet : {Sheet{8, 8, 200.0, 60.0, 5.0}, Sheet{12, 6, 1000.0, 300.0, 20.0},
                             Sheet{10, 14, 50.0, 200.0, 100.0}}) {
    SceneCloth cloth = testing::sample_sheet(sheet.columns, sheet.rows);
    cloth.structural = {sheet.structural, 0.0};
    cloth.shear = {sheet.shear, 0.0};
    cloth.bend = {sheet.bend, 0.0};
    const ClothModel model = testing::sample_model(cloth);
    for (const char* name : {"symplectic-euler", "rk4"}) {
      const double limit = stable_step(name, model, model.parts().x);
      EXPECT_LT(speed_after(name, model, 0.97 * limit), 1e-6) << name << sheet.columns;
      EXPECT_GT(speed_after(name, model, 1.03 * limit), 1e-3) << name << sheet.columns;
    }
  }
}

TEST(ClothExact, StepsBeyondTheLimitAreRefusedAndTheLimitTold) {
  ClothScene scene = free_fall("symplectic-euler", 1.0 / 60.0);
  const Result<ClothWorld> world = ClothWorld::create(scene);
  ASSERT_FALSE(world);
  EXPECT_EQ(world.error().kind, ErrorKind::kUsage);
  EXPECT_NE(world.error().message.find("the limit is "), std::string::npos);
  EXPECT_NE(world.error().message.find(" ms"), std::string::npos);
}

}  // namespace
}  // namespace tremolo
