// Tetrahedra under bdf2, their default method, in contact: impulses, hits and friction at any step.
#include <algorithm>
#include <cmath>

#include "tests/mixed/mixed_bodies.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;
using testing::MixedKind;
using testing::MixedWorld;

constexpr double kFall = 9.81;  // m/s^2

PlacedCollider floor_of(double friction, double restitution) {
  PlacedCollider floor;
  floor.shape = PlaneShape{};
  floor.friction = friction;
  floor.restitution = restitution;
  return floor;
}

// A flat block of 1.2 kg.
TetModelPointer block_of(double young) {
  TetMesh mesh = box_mesh({4, 3, 2}, {0.2, 0.1, 0.06});
  for (Vector3d& x : mesh.vertices) x -= 0.5 * Vector3d(0.2, 0.1, 0.06);
  auto model = TetModel::create(mesh, {{{"gel", {young, 0.3, 1000.0}}}, {}}, {});
  EXPECT_TRUE(model) << model.error().message;
  return *model;
}

double energy_of(TetBody& body, const ContactAccount& contact) {
  return body.kinetic_energy() + body.elastic_energy() + body.gravity_energy() + contact.energy;
}

// Its momentum changes by h (F + m g) in each step, and a hit, however stiff and short, gives it no
// energy. A force that is late by half a step let it rise higher than it had fallen: 1.35 times its
// speed at 8 ms and 1 MPa, 1.4 times at any step and 100 MPa.
TEST(Bdf2Contact, AHitGivesNoEnergyAtAnyStep) {
  for (const double young : {1e6, 1e8})
    for (const double step : {1.0 / 60.0, 8e-3, 4e-3, 2e-3, 1e-3}) {
      SCOPED_TRACE(std::to_string(young) + " Pa, " + std::to_string(step) + " s");
      const MixedKind kind{.step = step, .gravity = {0, 0, -kFall}, .method = TetMethod::kBdf2};
      MixedWorld world(step);
      ASSERT_TRUE(world.add(
          "block",
          testing::tets_body(block_of(young), kind, {0, 0, 0.2}, {0, 0, -4.0}, Vector3d::Zero()),
          testing::contact_of(kind, Vector3d::Ones())));
      const PlacedCollider floor = floor_of(0.0, 1.0);
      world.set_colliders({&floor, 1});
      TetBody& body = *world.tets(0);
      const double mass = body.model().mass(), start = energy_of(body, world.account(0));
      double down = 0.0, up = 0.0, most = start;
      Vector3d before = body.momentum();
      for (int i = 0; i < std::lround(0.2 / step); ++i) {
        ASSERT_TRUE(world.step()) << i;
        const Vector3d given = world.account(0).impulse_vector + step * mass * kind.gravity;
        EXPECT_LT((body.momentum() - before - given).norm(), 1e-9 * mass);
        before = body.momentum();
        down = std::min(down, before.z() / mass);
        up = std::max(up, before.z() / mass);
        most = std::max(most, energy_of(body, world.account(0)));
      }
      EXPECT_LT(up, -down);
      EXPECT_GT(up, -0.4 * down);
      EXPECT_LT(most, start + 1e-9 * std::abs(start));
    }
}

// At 0.95 of the angle of friction it stays where it is. It slid by 17 to 26 mm a second.
TEST(Bdf2Contact, ABlockSticksToASlopeAtAnyStep) {
  const double angle = 0.95 * std::atan(0.4);
  for (const double step : {4e-3, 2e-3, 1e-3}) {
    const MixedKind kind{.step = step,
                         .restitution = 0.5,
                         .friction = 0.4,
                         .gravity = {kFall * std::sin(angle), 0, -kFall * std::cos(angle)},
                         .method = TetMethod::kBdf2};
    MixedWorld world(step);
    ASSERT_TRUE(world.add(
        "block",
        testing::tets_body(block_of(1e6), kind, {0, 0, 0.03}, Vector3d::Zero(), Vector3d::Zero()),
        testing::contact_of(kind, Vector3d::Ones())));
    const PlacedCollider floor = floor_of(0.4, 0.5);
    world.set_colliders({&floor, 1});
    const auto run = [&](double seconds) {
      for (int i = 0; i < std::lround(seconds / step); ++i) ASSERT_TRUE(world.step()) << i;
    };
    const auto middle = [&] { return world.tets(0)->positions()[0]; };
    run(1.0);
    const double before = middle();
    run(1.0);
    EXPECT_LT(std::abs(middle() - before), 1e-6) << step;
  }
}

}  // namespace
}  // namespace tremolo
