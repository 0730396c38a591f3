// Rigid motions of a mesh, and damping of what is left of a motion without them.
#include "runtime/bodies/tets/solve/rigid_balance.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/support/tet_bodies.h"

namespace tremolo {
namespace {

using testing::tet_bar;
using testing::TetRandom;

// A bar of 0.4 x 0.1 x 0.1 m with these vertices fixed.
TetModelPointer bar_fixed_at(const std::vector<VertexId>& fixed) {
  const TetMesh mesh = testing::box_mesh({4, 1, 1}, {0.4, 0.1, 0.1});
  auto model = TetModel::create(mesh, {{{"gel", testing::kTetGel}}, {}}, fixed);
  EXPECT_TRUE(model) << model.error().message;
  return *model;
}

Eigen::VectorXd rotating(const Eigen::VectorXd& x, const Eigen::Vector3d& about,
                         const Eigen::Vector3d& spin, const Eigen::Vector3d& shift) {
  Eigen::VectorXd v(x.size());
  for (Eigen::Index i = 0; i < x.size(); i += 3)
    v.segment<3>(i) = shift + spin.cross(Eigen::Vector3d(x.segment<3>(i) - about));
  return v;
}

struct Parts {
  Eigen::VectorXd rigid, rest;
};
Parts parts_of(const TetModel& model, const Eigen::VectorXd& x, const Eigen::VectorXd& v) {
  Eigen::VectorXd work(v.size()), rigid(v.size());
  rigid_part(model, rigid_freedom(model), x, v, work, rigid);
  return {rigid, v - rigid};
}

TEST(RigidPart, OfAFreeBodyLeavesNeitherMomentumNorAngularMomentum) {
  const TetModelPointer model = bar_fixed_at({});
  TetRandom random(7);
  const Eigen::VectorXd x =
      model->rest() + testing::random_state(random, model->rest().size(), 0.02);
  const Eigen::VectorXd v = testing::random_state(random, x.size(), 1.0);
  const auto [rigid, rest] = parts_of(*model, x, v);
  TetSystem system(model, RotationLaw::kLeastEnergy);
  const double size = system.momentum(v).norm() + system.angular_momentum(x, v).norm();
  EXPECT_LE(system.momentum(rest).norm(), 1e-14 * size);
  EXPECT_LE(system.angular_momentum(x, rest).norm(), 1e-14 * size);
  // Pythagoras: the nearest motion in kinetic energy.
  EXPECT_NEAR(system.kinetic_energy(v), system.kinetic_energy(rigid) + system.kinetic_energy(rest),
              1e-13 * system.kinetic_energy(v));
}

TEST(RigidPart, IsEveryMotionThatTheFixedPointsAllowAndNoOther) {
  const Eigen::Vector3d spin(0.3, -0.5, 0.8), shift(1.0, 2.0, -3.0);
  const TetModelPointer free = bar_fixed_at({});
  const Eigen::VectorXd& x = free->rest();
  EXPECT_LE(parts_of(*free, x, rotating(x, {0.1, 0, 0}, spin, shift)).rest.norm(), 1e-12);
  const Eigen::Vector3d a = free->mesh().vertices[0], b = free->mesh().vertices[1];
  const TetModelPointer point = bar_fixed_at({0});
  EXPECT_LE(parts_of(*point, x, rotating(x, a, spin, {0, 0, 0})).rest.norm(), 1e-12);
  const TetModelPointer axis = bar_fixed_at({0, 1});
  const Eigen::Vector3d along = (b - a).normalized();
  EXPECT_LE(parts_of(*axis, x, rotating(x, a, 2.0 * along, {0, 0, 0})).rest.norm(), 1e-12);
  // Across the axis the fixed points would have to move.
  const Eigen::Vector3d across = along.unitOrthogonal();
  EXPECT_LE(parts_of(*axis, x, rotating(x, a, across, {0, 0, 0})).rigid.norm(),
            0.9 * rotating(x, a, across, {0, 0, 0}).norm());
  const TetModelPointer held = tet_bar({4, 1, 1}, {0.4, 0.1, 0.1}, true);
  EXPECT_EQ(parts_of(*held, x, rotating(x, a, spin, {0, 0, 0})).rigid.norm(), 0.0);
}

struct FreeRun {
  double fallen = 0.0, kinetic = 0.0, spin_change = 0.0, speed = 0.0, worst_gain = 0.0;
  double internal_first = 0.0, internal_last = 0.0;
};

// A free bar for one second: it falls from rest, or spins and bends.
FreeRun run_free(double alpha, double drag, bool spins) {
  const TetModelPointer model = bar_fixed_at({});
  TetBodyOptions options;
  options.method = TetMethod::kMidpoint;
  options.step = 2e-3;
  options.alpha = alpha;
  options.drag = drag;
  options.tolerance = 1e-9;
  if (!spins) options.gravity = {0, 0, -9.81};
  TetBody body = std::move(*TetBody::create(model, options));
  Eigen::VectorXd v = Eigen::VectorXd::Zero(model->rest().size());
  if (spins) {
    v = rotating(model->rest(), {0.2, 0.05, 0.05}, {0.5, 2.0, -1.0}, {0, 0, 0});
    for (Eigen::Index i = 0; i < v.size(); i += 3) {
      const double along = model->rest()[i] - 0.2;
      v[i + 1] += 10.0 * along * along;
    }
  }
  EXPECT_TRUE(body.set_state(model->rest(), v));
  const auto internal = [&] {
    const Parts parts = parts_of(*model, body.positions(), body.velocities());
    return body.system().kinetic_energy(parts.rest) + body.elastic_energy();
  };
  FreeRun run;
  run.internal_first = internal();
  const Eigen::Vector3d spin = body.angular_momentum();
  double energy = body.kinetic_energy() + body.elastic_energy();
  for (int n = 0; n < 500; ++n) {
    EXPECT_TRUE(body.step().converged);
    const double now = body.kinetic_energy() + body.elastic_energy();
    run.worst_gain = std::max(run.worst_gain, now / energy - 1.0);
    energy = now;
  }
  run.fallen = (body.system().momentum(model->rest() - body.positions()) / model->mass()).z();
  run.spin_change = (body.angular_momentum() - spin).norm() / spin.norm();
  run.internal_last = internal();
  return run;
}

TEST(MassDamping, AlphaLeavesFreeFallAndDragSlowsIt) {
  // The midpoint rule has g t^2 / 2 exactly.
  EXPECT_NEAR(run_free(2.0, 0.0, false).fallen, 0.5 * 9.81, 1e-9);
  // x'' = g - d x': x = g/d (t - (1 - exp(-d t))/d); the rule's error is (d h)^2 / 12 of it.
  const double d = 2.0;
  EXPECT_NEAR(run_free(0.0, d, false).fallen, 9.81 / d * (1.0 - (1.0 - std::exp(-d)) / d), 1e-5);
}

TEST(MassDamping, AlphaKeepsTheSpinAndTakesFromWhatDeforms) {
  const FreeRun undamped = run_free(0.0, 0.0, true), damped = run_free(3.0, 0.0, true);
  // Rounding of 500 balances.
  EXPECT_LE(damped.spin_change, 1e-11);
  EXPECT_LE(undamped.spin_change, 1e-11);
  // Midpoint's own error of the energy in a step, with or without damping.
  EXPECT_LE(damped.worst_gain, undamped.worst_gain + 1e-9);
  // Of a mode the energy decays by exp(-alpha t) = 0.05; what the spin stretches stays.
  EXPECT_LT(damped.internal_last, 0.15 * damped.internal_first);
  EXPECT_GT(undamped.internal_last, 0.5 * undamped.internal_first);
}

TEST(MassDamping, APendulumThatHangsAtOneVertexKeepsSwinging) {
  // Stiff, so that the swing is nearly rigid: drag takes exp(-2) of its energy, alpha nothing.
  const TetMesh mesh = testing::box_mesh({4, 1, 1}, {0.4, 0.1, 0.1});
  const auto energy_left = [&](double alpha, double drag) {
    const auto model =
        TetModel::create(mesh, {{{"stiff", {1e7, 0.3, 1000.0}}}, {}}, std::vector<VertexId>{0});
    TetBodyOptions options;
    options.method = TetMethod::kMidpoint;
    options.step = 2e-3;
    options.alpha = alpha;
    options.drag = drag;
    TetBody body = std::move(*TetBody::create(*model, options));
    const Eigen::Vector3d pivot = (*model)->mesh().vertices[0];
    const Eigen::VectorXd v = rotating((*model)->rest(), pivot, {0, 1.0, 0.5}, {0, 0, 0});
    EXPECT_TRUE(body.set_state((*model)->rest(), v));
    const double begin = body.kinetic_energy();
    for (int n = 0; n < 500; ++n) EXPECT_TRUE(body.step().converged);
    return (body.kinetic_energy() + body.elastic_energy()) / begin;
  };
  EXPECT_GT(energy_left(2.0, 0.0), 0.98);
  EXPECT_LT(energy_left(0.0, 2.0), 0.05);
}

}  // namespace
}  // namespace tremolo
