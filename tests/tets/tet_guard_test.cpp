// Energy that long steps would add: the guard of midpoint and newmark, steps in contact, the bound.
#include <cmath>

#include <gtest/gtest.h>

#include "runtime/bodies/tets/contact/tet_contact.h"
#include "runtime/bodies/tets/motion/tet_group.h"
#include "tests/support/tet_bodies.h"

namespace tremolo {
namespace {

using testing::tet_bar;

struct SpinRun {
  double most = 0.0;         // energy over that at the start
  double spin_change = 0.0;  // of the angular momentum
  int guarded = 0;
  std::size_t inverted = 0;
};

// A free bar of 10 MPa that spins with 8 rad/s, 200 steps of 1/60 s.
SpinRun spin(TetMethod method, DegreeKind degree, bool guard) {
  const TetModelPointer model = tet_bar({8, 2, 2}, {0.4, 0.1, 0.1}, false, {1e7, 0.4, 1000.0});
  TetBodyOptions options;
  options.method = method;
  options.guard = guard;
  options.degree.kind = degree;
  TetBody body = std::move(*TetBody::create(model, options));
  Eigen::VectorXd v(model->rest().size());
  const Eigen::Vector3d turn = 8.0 * Eigen::Vector3d(0.3, 1.0, 0.2).normalized();
  for (Eigen::Index i = 0; i < v.size(); i += 3)
    v.segment<3>(i) =
        turn.cross(Eigen::Vector3d(model->rest().segment<3>(i) - Eigen::Vector3d(0.2, 0.05, 0.05)));
  EXPECT_TRUE(body.set_state(model->rest(), v));
  const double begin = body.kinetic_energy();
  const Eigen::Vector3d l = body.angular_momentum();
  SpinRun run;
  for (int n = 0; n < 200; ++n) {
    const TetStepReport report = body.step();
    EXPECT_TRUE(report.converged);
    run.guarded += report.guarded;
    run.most = std::max(run.most, (body.kinetic_energy() + body.elastic_energy()) / begin);
  }
  run.spin_change = (body.angular_momentum() - l).norm() / l.norm();
  run.inverted = body.system().inverted();
  return run;
}

TEST(TetGuard, AStiffSpinningBarKeepsItsEnergyAndItsSpinInLongStepsOfMidpoint) {
  for (const DegreeKind degree : {DegreeKind::kQuadratic, DegreeKind::kAdaptive}) {
    const SpinRun run = spin(TetMethod::kMidpoint, degree, true);
    EXPECT_LE(run.most, 1.02 + 1e-9);   // what the guard allows
    EXPECT_LE(run.spin_change, 1e-11);  // rounding of 200 steps
    EXPECT_GT(run.guarded, 0);
    EXPECT_EQ(run.inverted, 0U);
  }
  EXPECT_GT(spin(TetMethod::kMidpoint, DegreeKind::kQuadratic, false).most, 2.0);
}

TEST(TetGuard, NewmarkAddsNoMoreThanItsFiftieth) {
  EXPECT_LE(spin(TetMethod::kNewmark, DegreeKind::kQuadratic, true).most, 1.02 + 1e-9);
}

TEST(TetGuard, MethodsThatDampAreLeftAlone) {
  for (const TetMethod method : {TetMethod::kImplicitEuler, TetMethod::kBdf2}) {
    const SpinRun run = spin(method, DegreeKind::kQuadratic, true);
    EXPECT_EQ(run.guarded, 0);
    EXPECT_LE(run.most, 1.0 + 1e-9);
  }
}

// A block above the floor, all of whose steps in contact are a few corrections.
TEST(TetGuard, AFallOntoTheFloorTakesAFewCorrectionsAStepAndAddsNoEnergy) {
  const TetModelPointer model = tet_bar({4, 2, 2}, {0.2, 0.1, 0.1}, false, {3e4, 0.4, 1000.0});
  for (const TetMethod method : {TetMethod::kImplicitEuler, TetMethod::kBdf2}) {
    TetBodyOptions options;
    options.method = method;
    options.unsolved = UnsolvedStep::kTakeContact;
    options.gravity = {0, 0, -9.81};
    options.degree.kind = DegreeKind::kAdaptive;
    TetBody body = std::move(*TetBody::create(model, options));
    TetContact contact(boundary_hull(model), {{PlaneShape{}, {}, 0.3}});
    Eigen::VectorXd x = model->rest();
    const Eigen::Matrix3d tilt =
        Eigen::AngleAxisd(0.5, Eigen::Vector3d(1, 2, 0).normalized()).toRotationMatrix();
    for (Eigen::Index i = 0; i < x.size(); i += 3)
      x.segment<3>(i) = tilt * x.segment<3>(i) + Eigen::Vector3d(0, 0, 0.4);
    ASSERT_TRUE(body.set_state(x, Eigen::VectorXd::Zero(x.size())));
    const auto energy = [&] {
      return body.kinetic_energy() + body.elastic_energy() + body.gravity_energy() +
             contact.look(body.positions()).energy;
    };
    const double begin = energy(), fall = model->mass() * 9.81 * 0.4;
    int in_contact = 0;
    double most = begin;
    for (int n = 0; n < 240; ++n) {
      const TetStepReport report = body.step(&contact);
      ASSERT_TRUE(report.converged) << n;
      EXPECT_FALSE(report.linearised) << n;
      most = std::max(most, energy());
      if (contact.touches().empty()) continue;
      ++in_contact;
      // Two corrections of one, two and four parts, after those of the step that met the floor.
      EXPECT_LE(report.iterations, 2 * (1 + 2 + 4) + options.max_iterations) << n;
    }
    EXPECT_GT(in_contact, 100);
    // Of what the fall gives: the twentieth that a step may add.
    EXPECT_LE(most, begin + 0.05 * fall) << tet_method_name(method);
    EXPECT_LT(body.momentum().norm() / model->mass(), 0.05);
    EXPECT_LT(contact.look(body.positions()).depth, 0.01);
  }
}

TetGroup falling_group(const TetModelPointer& model) {
  TetBodyOptions options;
  options.gravity = {0, 0, -9.81};
  std::vector<TetBody> bodies;
  bodies.push_back(std::move(*TetBody::create(model, options)));
  std::vector<TetContact> contacts;
  contacts.emplace_back(boundary_hull(model), std::vector<TetObstacle>{});
  return TetGroup(std::move(bodies), std::move(contacts), {0.3}, {});
}

TEST(TetBound, AllowsWhatGravityGivesAndNothingElse) {
  const TetModelPointer model = tet_bar({2, 1, 1}, {0.2, 0.1, 0.1}, false);
  TetGroup group = falling_group(model);
  TetBound bound;
  EXPECT_TRUE(bound.look(group));  // at rest: nothing was put in
  std::vector<TetStepReport> reports(1);
  for (int n = 0; n < 60; ++n) {
    ASSERT_TRUE(group.step(reports));
    ASSERT_TRUE(bound.look(group)) << n;
  }
  // Nobody did the work for four times the speed, sixteen times the energy.
  TetBody& body = group.body(0);
  ASSERT_TRUE(body.set_state(body.positions(), 4.0 * body.velocities()));
  EXPECT_FALSE(bound.look(group));
  EXPECT_GT(bound.energy(), 0.0);
}

TEST(TetBound, ABodyAtRestInNoGravityIsInsideForEver) {
  const TetModelPointer model = tet_bar({2, 1, 1}, {0.2, 0.1, 0.1}, false);
  std::vector<TetBody> bodies;
  bodies.push_back(std::move(*TetBody::create(model, {})));
  std::vector<TetContact> contacts;
  contacts.emplace_back(boundary_hull(model), std::vector<TetObstacle>{});
  TetGroup group(std::move(bodies), std::move(contacts), {0.3}, {});
  TetBound bound;
  std::vector<TetStepReport> reports(1);
  for (int n = 0; n < 100; ++n) {
    ASSERT_TRUE(bound.look(group)) << n;
    ASSERT_TRUE(group.step(reports));
  }
}

}  // namespace
}  // namespace tremolo
