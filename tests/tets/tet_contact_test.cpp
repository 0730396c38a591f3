// A body of tetrahedra on a floor: rest, fall, slope, and no energy out of nothing.
#include "runtime/bodies/tets/contact/tet_contact.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/support/tet_bodies.h"

namespace tremolo {
namespace {

constexpr double kFallG = 9.81;

TetBody block_body(const TetModelPointer& model, DegreeKind kind, TetMethod method) {
  TetBodyOptions options;
  options.method = method;
  options.gravity = {0.0, 0.0, -kFallG};
  options.beta = 5e-3;
  options.degree.kind = kind;
  Result<TetBody> body = TetBody::create(model, options);
  EXPECT_TRUE(body) << body.error().message;
  return std::move(*body);
}

Eigen::VectorXd lifted(const TetModel& model, double height) {
  Eigen::VectorXd x = model.rest();
  for (Eigen::Index i = 2; i < x.size(); i += 3) x[i] += height;
  return x;
}

TEST(TetContact, TheForcesAreTheSlopeOfTheirEnergy) {
  const TetModelPointer model = testing::tet_bar({2, 1, 1}, {0.2, 0.1, 0.1}, false);
  Pose pose;
  pose.rotation = Eigen::Quaterniond(0.9, 0.3, -0.2, 0.1).normalized();
  pose.position = {0.1, 0.05, 0.03};
  TetContact contact(boundary_hull(model),
                     {{SphereShape{0.08}, pose, 0.0}, {PlaneShape{}, pose, 0.0}});
  testing::TetRandom random(3);
  const Eigen::VectorXd x =
      model->rest() + testing::random_state(random, model->rest().size(), 0.01);
  const Eigen::VectorXd way = testing::random_state(random, x.size(), 1.0);
  Eigen::VectorXd force = Eigen::VectorXd::Zero(x.size());
  contact.fit(x);
  contact.find(x, x);
  contact.add_forces(force);
  const double h = 1e-6;
  const double slope =
      (contact.look(x + h * way).energy - contact.look(x - h * way).energy) / (2.0 * h);
  ASSERT_GT(force.norm(), 0.1);
  // Central differences: h^2 and the rounding of energies over h.
  EXPECT_NEAR(-force.dot(way), slope, 1e-6 * std::abs(slope) + 1e-9 * force.norm());
}

TEST(TetContact, ABlockComesToRestOnTheFloorUnderItsOwnWeight) {
  const TetModelPointer model = testing::tet_bar({2, 1, 1}, {0.2, 0.1, 0.1}, false);
  for (const DegreeKind kind :
       {DegreeKind::kLinear, DegreeKind::kQuadratic, DegreeKind::kAdaptive}) {
    TetBody body = block_body(model, kind, TetMethod::kImplicitEuler);
    TetContact contact(boundary_hull(model), {{PlaneShape{}, {}, 0.3}});
    ASSERT_TRUE(body.set_state(lifted(*model, 0.05), Eigen::VectorXd::Zero(model->rest().size())));
    for (int k = 0; k < 180; ++k) ASSERT_TRUE(body.step(&contact).converged) << k;
    EXPECT_LT(body.momentum().norm() / model->mass(), 1e-4);  // m/s
    // The floor's force is the weight.
    Eigen::VectorXd force = Eigen::VectorXd::Zero(model->rest().size());
    contact.fit(body.positions());
    contact.find(body.positions(), body.positions());
    contact.add_forces(force);
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (Eigen::Index i = 0; i < force.size(); i += 3) sum += force.segment<3>(i);
    // To the rest of the motion, 1e-4 m/s over a step of 1/60 s: 6e-3 m/s^2.
    EXPECT_NEAR(sum.z(), model->mass() * kFallG, 1e-3 * model->mass() * kFallG);
    EXPECT_LT(contact.look(body.positions()).depth, 0.01);
  }
}

TEST(TetContact, NoEnergyComesOutOfNothing) {
  const TetModelPointer model = testing::tet_bar({3, 1, 1}, {0.3, 0.1, 0.1}, false);
  for (const TetMethod method : {TetMethod::kImplicitEuler, TetMethod::kBdf2}) {
    TetBody body = block_body(model, DegreeKind::kQuadratic, method);
    Pose slope;
    slope.rotation = Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY());
    TetContact contact(boundary_hull(model), {{PlaneShape{}, slope, 0.5}, {PlaneShape{}, {}, 0.5}});
    Eigen::VectorXd x = lifted(*model, 0.3), v = Eigen::VectorXd::Zero(x.size());
    for (Eigen::Index i = 0; i < v.size(); i += 3) v[i] = 1.0;  // towards the slope
    ASSERT_TRUE(body.set_state(x, v));
    const auto energy = [&] {
      return body.kinetic_energy() + body.elastic_energy() + body.gravity_energy() +
             contact.look(body.positions()).energy;
    };
    const double floor = -0.5 * model->mass() * kFallG;  // of the potential, generously
    const double begin = energy();
    for (int k = 0; k < 240; ++k) {
      ASSERT_TRUE(body.step(&contact).converged) << k;
      // bdf2's own energy differs from the state's by terms of h; a tenth of what was put in.
      EXPECT_LT(energy(), begin + (method == TetMethod::kBdf2 ? 0.1 * (begin - floor) : 1e-6)) << k;
    }
    EXPECT_LT(body.momentum().norm() / model->mass(), 0.05);
  }
}

// On a slope of angle a a block slides with g (sin a - mu cos a), and stays where mu > tan a.
TEST(TetContact, ABlockSlidesDownASlopeAsCoulombSays) {
  const TetModelPointer model = testing::tet_bar({2, 2, 1}, {0.2, 0.2, 0.05}, false);
  const double angle = 0.3;
  for (const double mu : {0.0, 0.15, 0.6}) {
    TetBodyOptions options;
    options.method = TetMethod::kImplicitEuler;
    // The slope is fixed and gravity is rotated, which is the same.
    options.gravity = kFallG * Eigen::Vector3d(std::sin(angle), 0.0, -std::cos(angle));
    options.beta = 5e-3;
    options.degree.kind = DegreeKind::kLinear;
    Result<TetBody> body = TetBody::create(model, options);
    ASSERT_TRUE(body);
    TetContact contact(boundary_hull(model), {{PlaneShape{}, {}, mu}});
    for (int k = 0; k < 60; ++k) ASSERT_TRUE(body->step(&contact).converged);
    const double before = body->momentum().x();
    for (int k = 0; k < 60; ++k) ASSERT_TRUE(body->step(&contact).converged);
    const double found = (body->momentum().x() - before) / model->mass();  // over one second
    const double expected = std::max(0.0, kFallG * (std::sin(angle) - mu * std::cos(angle)));
    // The rest of settling is below a hundredth of g.
    EXPECT_NEAR(found, expected, 0.01 * kFallG) << mu;
    if (mu > std::tan(angle)) {
      EXPECT_LT(body->momentum().norm() / model->mass(), 1e-6);
    }
  }
}

}  // namespace
}  // namespace tremolo
