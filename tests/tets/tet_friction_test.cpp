// Friction of bodies of tetrahedra with the options that scenes have by default: closed forms of a
// block that is thrown along a floor, and of one on a slope, at the default step and half of it;
// of a block on another body.
#include <cmath>

#include <gtest/gtest.h>

#include "runtime/bodies/tets/contact/tet_contact.h"
#include "runtime/bodies/tets/motion/tet_body.h"
#include "tests/support/tet_bodies.h"

namespace tremolo {
namespace {

constexpr double kPull = 9.81;  // m/s^2
constexpr double kRub = 0.3;    // mu
constexpr double kSteps[] = {1.0 / 60.0, 1.0 / 120.0};
constexpr double kStiff[] = {2e5, 1e6, 5e7};  // Young's modulus, Pa

struct Slide {
  double way = 0.0, speed = 0.0;  // along x, of the centre of mass: m, m/s
  double lift = 0.0;              // most energy over that at the start, J
  double creep = 0.0;             // the way after the first second, m
};

// A flat block of 0.2 x 0.2 x 0.05 m begins at a gap of 0 with a speed along x. slope: of the
// floor, over the angle of friction.
Slide slide(double young, double step, double slope, double speed, double seconds) {
  const TetModelPointer model =
      testing::tet_bar({4, 4, 1}, {0.2, 0.2, 0.05}, false, {young, 0.4, 1000.0});
  const double angle = slope * std::atan(kRub);
  TetBodyOptions options;
  options.step = step;
  options.unsolved = UnsolvedStep::kTakeContact;
  options.gravity = kPull * Eigen::Vector3d(std::sin(angle), 0.0, -std::cos(angle));
  options.degree.kind = DegreeKind::kAdaptive;
  TetBody body = std::move(*TetBody::create(model, options));
  TetContact contact(boundary_hull(model), {{PlaneShape{}, {}, kRub}});
  Eigen::VectorXd v = Eigen::VectorXd::Zero(model->rest().size());
  for (Eigen::Index i = 0; i < v.size(); i += 3) v[i] = speed;
  EXPECT_TRUE(body.set_state(model->rest(), v));
  const auto centre = [&] { return body.system().momentum(body.positions()).x() / model->mass(); };
  const auto energy = [&] {
    return body.kinetic_energy() + body.elastic_energy() + body.gravity_energy() +
           contact.look(body.positions()).energy;
  };
  const double from = centre(), begin = energy();
  Slide run;
  for (int n = 0; n < static_cast<int>(std::lround(seconds / step)); ++n) {
    EXPECT_TRUE(body.step(&contact).converged) << n;
    if (n + 1 == static_cast<int>(std::lround(1.0 / step))) run.creep = -centre();
    run.lift = std::max(run.lift, energy() - begin);
  }
  run.way = centre() - from;
  run.creep += centre();
  run.speed = body.momentum().x() / model->mass();
  return run;
}

TEST(TetFriction, AThrownBlockStopsAfterItsWay) {
  const double way = 2.0 * 2.0 / (2.0 * kRub * kPull);
  for (const double young : kStiff)
    for (const double step : kSteps) {
      const Slide run = slide(young, step, 0.0, 2.0, 1.0);
      EXPECT_NEAR(run.way, way, 0.05 * way) << young << " " << step;
      EXPECT_LT(std::abs(run.speed), 0.02) << young << " " << step;
      EXPECT_LT(run.lift, 1e-3) << young << " " << step;
    }
}

TEST(TetFriction, ABlockSlidesDownASteepSlope) {
  const double angle = 1.5 * std::atan(kRub);
  const double speed = kPull * (std::sin(angle) - kRub * std::cos(angle));  // after a second
  for (const double young : kStiff)
    for (const double step : kSteps) {
      const Slide run = slide(young, step, 1.5, 0.0, 1.0);
      EXPECT_NEAR(run.speed, speed, 0.05 * speed) << young << " " << step;
      EXPECT_LT(run.lift, 1e-3) << young << " " << step;
    }
}

TEST(TetFriction, ABlockSlidesWithAllThatExceedsFriction) {
  const double angle = 1.05 * std::atan(kRub);
  const double speed = kPull * (std::sin(angle) - kRub * std::cos(angle));
  for (const double young : kStiff)
    for (const double step : kSteps) {
      const double first = slide(young, step, 1.05, 0.0, 1.0).speed;
      EXPECT_NEAR(slide(young, step, 1.05, 0.0, 2.0).speed - first, speed, 0.005 * speed)
          << young << " " << step;
    }
}

TEST(TetFriction, ABlockStaysOnASlopeThatIsAlmostTooSteep) {
  for (const double young : kStiff)
    for (const double step : kSteps) {
      const Slide run = slide(young, step, 0.95, 0.0, 20.0);
      EXPECT_LT(std::abs(run.creep), 1e-6) << young << " " << step;
      EXPECT_LT(std::abs(run.speed), 1e-7) << young << " " << step;
    }
}

}  // namespace
}  // namespace tremolo
