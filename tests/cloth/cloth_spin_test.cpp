// Angular momentum of what flies freely, under methods that do not keep it.
#include <cmath>
#include <cstdio>

#include "runtime/bodies/cloth/cloth_world.h"
#include "tests/cloth/cloth_samples.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

Vector3d spin_of(const ClothModel& model, const NodalState& state) {
  Vector3d sum = Vector3d::Zero();
  for (Eigen::Index i = 0; i < model.mass().size(); ++i)
    sum += model.mass()[i] *
           Vector3d(state.x.segment<3>(3 * i)).cross(Vector3d(state.v.segment<3>(3 * i)));
  return sum;
}

NodalState after(const ClothModel& model, const NodalState& begun, const char* method, double step,
                 double duration) {
  NodalOptions options;
  options.step = step;
  options.tolerance = 1e-11;
  auto integrator = make_nodal_integrator(method, model, options);
  EXPECT_TRUE(integrator) << integrator.error().message;
  NodalState state = begun;
  for (int k = 0; k < static_cast<int>(std::lround(duration / step)); ++k)
    EXPECT_TRUE((*integrator)->step(state).made);
  return state;
}

// The fraction by which the angular momentum has changed after a second.
double changed_spin(const ClothModel& model, const NodalState& begun, const char* method,
                    double step) {
  const Vector3d first = spin_of(model, begun);
  const Vector3d change = spin_of(model, after(model, begun, method, step, 1.0)) - first;
  return change.norm() / first.norm();
}

// Two masses that circle each other with omega, their spring stretched by what holds them. With
// x1 = x0 + h v1 the change is sum x1 x m (v1 - v0) - h sum v1 x m (v1 - v0). The first sum is zero
// where forces are taken at x1, so that
//   L1 - L0 = h sum v1 x m v0 = -h^2 omega^2 L to the lowest order.
// Of one linearisation it is not zero, but the torque of the springs' tensions T about x0 is, by
// the virial, h^2 omega sum T |x| = h^2 omega sum m omega^2 r^2, which is the same.
TEST(ClothSpin, TwoMassesLoseTheShareThatIsKnown) {
  constexpr double kOmega = 2.0, kMass = 0.1, kRadius = 0.5, kStiffness = 50.0;
  const double stretched = kMass * kOmega * kOmega * kRadius / kStiffness;
  const ClothParts parts =
      testing::sample_chain(1, Vector3d(2.0 * kRadius, 0.0, 0.0), 2.0 * kRadius - stretched, kMass,
                            SpringLaw{kStiffness, 0.0});
  const Result<ClothModel> model = ClothModel::create(parts);
  ASSERT_TRUE(model) << model.error().message;
  NodalState begun;
  begun.x.resize(6);
  begun.x << -kRadius, 0.0, 0.0, kRadius, 0.0, 0.0;
  begun.v.resize(6);
  begun.v << 0.0, -kOmega * kRadius, 0.0, 0.0, kOmega * kRadius, 0.0;
  for (const char* method : {"implicit-euler", "implicit-euler-linear"})
    for (const double step : {1.0 / 120, 1.0 / 240, 1.0 / 480, 1.0 / 960}) {
      const double lost = changed_spin(*model, begun, method, step);
      const double known = step * kOmega * kOmega;
      std::printf("%s, two masses, %.0f steps a second: %.4g %% a second, known %.4g %%\n", method,
                  1.0 / step, 100.0 * lost, 100.0 * known);
      // A second-order effect; implicit Euler also slows the spin, which makes it lose less.
      EXPECT_NEAR(lost, known, 2.0 * known * known) << method << step;
    }
}

// Both are of first order; the midpoint's rules keep it to the tolerance of a step.
TEST(ClothSpin, ASheetsSpinChangesWithTheStepAndByTheMidpointsRulesNotAtAll) {
  SceneCloth cloth = testing::sample_sheet(14, 14);
  cloth.grid.corner = {-0.5, -0.5, 0.0};
  const ClothModel model = testing::sample_model(cloth);
  NodalState begun;
  begun.x = model.parts().x;
  begun.v.resize(begun.x.size());
  for (Eigen::Index i = 0; i < begun.x.size(); i += 3) {
    const Vector3d x = begun.x.segment<3>(i);
    begun.v.segment<3>(i) =
        Vector3d(0.2, 0.1, 2.0).cross(x) + Vector3d(0.0, 0.0, 0.5 * std::cos(5.0 * x.x()));
  }
  for (const char* method : {"implicit-euler", "implicit-euler-linear"}) {
    double last = 0.0, before = 0.0;
    for (const double step : {1.0 / 60, 1.0 / 120, 1.0 / 240, 1.0 / 480, 1.0 / 960}) {
      before = last;
      last = changed_spin(model, begun, method, step);
      std::printf("%s, sheet, %.0f steps a second: %.4g %%\n", method, 1.0 / step, 100.0 * last);
    }
    EXPECT_NEAR(before / last, 2.0, 0.1) << method;
  }
  for (const char* method : {"midpoint", "energy"})
    EXPECT_LE(changed_spin(model, begun, method, 1.0 / 60), 1e-10) << method;
}

// With a ball that hits it the fraction is larger, but also proportional to the step.
TEST(ClothSpin, OfASheetAndABallItsChangeGoesWithTheStep) {
  ClothScene scene = testing::sheet_and_ball({0.03, 0.02, 0.25});
  scene.options.tolerance = 1e-10;
  scene.balls[0].velocity = {0.3, -0.2, -2.0};
  scene.balls[0].spin = {3.0, 1.0, -2.0};
  for (const char* method : {"implicit-euler", "implicit-euler-linear"}) {
    scene.integrator = method;
    double first = 0.0, last = 0.0;
    for (const double step : {1.0 / 60, 1.0 / 120, 1.0 / 240, 1.0 / 480, 1.0 / 960}) {
      scene.options.step = step;
      auto world = ClothWorld::create(scene);
      ASSERT_TRUE(world) << world.error().message;
      const Vector3d begun = world->angular_momentum();
      while (world->time() < 40.0 / 60.0 - 0.5 * step) ASSERT_TRUE(world->step());
      last = (world->angular_momentum() - begun).norm() / begun.norm();
      if (first == 0.0) first = last;
      std::printf("%s, sheet and ball, %.0f steps a second: %.4g %%\n", method, 1.0 / step,
                  100.0 * last);
    }
    EXPECT_LE(last, first / 7.0) << method;
  }
}

}  // namespace
}  // namespace tremolo
