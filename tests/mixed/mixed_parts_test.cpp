// Steps of islands with cloth and tetrahedra that are too long to be solved whole and are taken in
// parts: momenta, energy, shorter steps, what a step that fails leaves behind.
#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/mixed/cloth_bodies.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;
using testing::MixedKind;
using testing::MixedSum;
using testing::MixedWorld;
using testing::Sheet;

constexpr double kFrame = 1.0 / 60.0;  // s
const Vector3d kDown(0, 0, -9.81);

PlacedCollider ball_collider(double friction) {
  PlacedCollider ball;
  ball.shape = SphereShape{0.3};
  ball.start = ball.end = testing::placed_at({0, 0, 0.3});
  ball.friction = friction;
  ball.restitution = 0.5;
  return ball;
}

// The sheet of assets/scenes/cloth-sphere.toml as one body among others.
ClothBody falling_sheet(double step) {
  const MixedKind kind{.step = step, .restitution = 0.5, .friction = 0.4, .gravity = kDown};
  ClothScene scene = testing::sheet_scene({.particles = 41,
                                           .width = 1.2,
                                           .thickness = 0.01,
                                           .middle = {0, 0, 0.8},
                                           .structural = {500.0, 0.05},
                                           .shear = {150.0, 0.05},
                                           .bend = {5.0, 0.005}},
                                          kind);
  scene.cloths[0].crumple = 0.02;
  Result<ClothBody> body = ClothBody::create(scene);
  EXPECT_TRUE(body) << body.error().message;
  return std::move(*body);
}

// Every step is solved as a whole. With a matrix without the indefinite terms some were not.
TEST(ClothInParts, FallsOnASphereInWholeStepsOfAFrame) {
  MixedWorld world(kFrame);
  const PlacedCollider ball = ball_collider(0.4);
  world.set_colliders({&ball, 1});
  ASSERT_TRUE(world.add(falling_sheet(kFrame)));
  const ClothBody& sheet = *world.cloth(0);
  const double start = testing::sum_of(world).energy;
  double taken = 0.0;
  int cut = 0;
  for (int i = 0; i < 16; ++i) {
    const Vector3d before = sheet.momenta().linear;
    const double stored = world.account(0).energy;
    const Status made = world.step();
    ASSERT_TRUE(made) << i << made.error().message;
    cut += world.report().cut;
    EXPECT_EQ(world.report().parts > 0, world.report().cut > 0);
    const ContactAccount account = world.account(0);
    // A step of gravity gives 0.047 kg m/s. A last resort of the solve leaves 1e-7 of the forces.
    const Vector3d put_in = sheet.mass() * kFrame * kDown + account.impulse_vector;
    EXPECT_LT((sheet.momenta().linear - before - put_in).norm(), 1e-5) << i;
    // The sphere is at rest and gives nothing.
    EXPECT_NEAR(account.given, 0.0, 1e-12);
    EXPECT_NEAR(account.surplus, 0.0, 1e-12);
    EXPECT_NEAR(account.work, stored - account.energy - account.lost - account.friction_loss,
                1e-12);
    taken += account.lost + account.friction_loss;
    EXPECT_NEAR(testing::sum_of(world).energy + taken - testing::own_energy(sheet), start, 1e-9)
        << i;
  }
  EXPECT_EQ(sheet.steps(), 16);
  EXPECT_EQ(sheet.cut_steps(), 0);
  EXPECT_EQ(cut, 0);
}

// A sheet that wraps a reduced cube and one of tetrahedra, which are at rest side by side.
TEST(ClothInParts, WrapsBodiesOfOtherKindsAndKeepsTheMomentaAndTheEnergy) {
  const TetModelPointer model = testing::tets_cube(1e5, 2);
  const TetHullPointer hull = testing::cube_hull(model);
  int cut = 0;
  for (const char* integrator : {"energy", "midpoint"}) {
    const MixedKind kind{.step = kFrame, .restitution = 0.5, .friction = 0.3};
    MixedWorld world(kind.step);
    ASSERT_TRUE(world.add(
        "reduced", testing::reduced_body(testing::reduced_cube("1e5"), kind, {-0.08, 0, 0})));
    ASSERT_TRUE(world.add(
        "tets", testing::tets_body(model, kind, {0.08, 0, 0}, Vector3d::Zero(), Vector3d::Zero()),
        testing::contact_of(kind, Vector3d::Ones()), hull));
    ASSERT_TRUE(world.add(testing::sheet_body({.integrator = integrator,
                                               .particles = 11,
                                               .width = 0.4,
                                               .middle = {0, 0, 0.1},
                                               .velocity = {0.3, 0.1, -2.0}},
                                              kind)));
    const testing::WorstErrors worst = testing::follow(world, 6);
    cut += worst.cut;
    EXPECT_EQ(world.in_islands(), 3U);
    EXPECT_GT(worst.touched, 50);
    EXPECT_LT(worst.linear, 1e-10);
    EXPECT_LT(worst.angular, 1e-11);
    EXPECT_LT(worst.energy, 1e-6 * worst.start);
    EXPECT_EQ(world.tets(1)->steps(), 6);
    EXPECT_EQ(world.cloth(2)->steps(), 6);
  }
  EXPECT_GT(cut, 0);
}

// Mean height of the sheet on the sphere after a time, m.
double height_after(double seconds, double step, int& cut) {
  MixedWorld world(step);
  const PlacedCollider ball = ball_collider(0.4);
  world.set_colliders({&ball, 1});
  EXPECT_TRUE(world.add(falling_sheet(step)));
  const int steps = static_cast<int>(std::lround(seconds / step));
  for (int i = 0; i < steps; ++i) {
    const Status made = world.step();
    EXPECT_TRUE(made) << i << made.error().message;
    if (!made) break;
    cut += world.report().cut;
  }
  const ClothBody& sheet = *world.cloth(0);
  double height = 0.0;
  for (Eigen::Index i = 0; i < sheet.model().mass().size(); ++i)
    height += sheet.model().mass()[i] * sheet.state().x[3 * i + 2];
  return height / sheet.mass();
}

TEST(ClothInParts, SettlesAsTheStepIsHalved) {
  std::vector<double> heights;
  int cut = 0;
  for (const double step : {kFrame, kFrame / 2, kFrame / 4})
    heights.push_back(height_after(0.25, step, cut));
  RecordProperty("cut", std::to_string(cut));
  RecordProperty("heights", ::testing::PrintToString(heights));
  const double first = std::abs(heights[0] - heights[1]);
  const double second = std::abs(heights[1] - heights[2]);
  EXPECT_LT(second, 0.7 * first);
}

// The contact of this sheet with the floor is too stiff for numbers: the part in which it begins
// fails, and all parts of that part.
TEST(ClothInParts, AStepThatFailsLeavesAllAsItWas) {
  const MixedKind kind{.step = kFrame, .restitution = 0.5, .friction = 0.3};
  MixedWorld world(kind.step);
  PlacedCollider floor;
  floor.shape = PlaneShape{};
  world.set_colliders({&floor, 1});
  const TetModelPointer model = testing::tets_cube(1e5, 1);
  const TetHullPointer hull = testing::cube_hull(model);
  const Vector3d velocity(0, 0, -2.5);
  ContactBody reduced = testing::reduced_body(testing::reduced_cube("1e5"), kind, {0, 0, 0.1255});
  ASSERT_TRUE(reduced.set_motion(velocity, Vector3d::Zero()));
  ASSERT_TRUE(world.add("reduced", std::move(reduced)));
  ASSERT_TRUE(world.add(
      "tets", testing::tets_body(model, kind, {0.02, 0, 0.2265}, velocity, Vector3d::Zero()),
      testing::contact_of(kind, Vector3d::Ones()), hull));
  ASSERT_TRUE(world.add(testing::sheet_body({.middle = {0, 0, 0.072}, .velocity = velocity}, kind),
                        {.stiffness = 1e150}));
  State body;
  RigidState rigid;
  Eigen::VectorXd tets_x, tets_v;
  NodalState cloth;
  ClothWork work;
  ContactAccount account;
  int taken = 0;
  for (; taken < 5; ++taken) {
    body = world.reduced(0)->state();
    rigid = world.reduced(0)->rigid_state();
    tets_x = world.tets(1)->positions();
    tets_v = world.tets(1)->velocities();
    cloth = world.cloth(2)->state();
    work = world.cloth(2)->work();
    account = world.account(2);
    if (!world.step()) break;
  }
  EXPECT_FALSE(world.report().converged);
  EXPECT_EQ(world.in_islands(), 3U);
  EXPECT_GT(world.report().parts, 0);  // some parts were solved, and undone
  EXPECT_EQ(world.tets(1)->positions(), tets_x);
  EXPECT_EQ(world.tets(1)->velocities(), tets_v);
  EXPECT_EQ(world.cloth(2)->state().x, cloth.x);
  EXPECT_EQ(world.cloth(2)->state().v, cloth.v);
  EXPECT_EQ(world.cloth(2)->state().time, cloth.time);
  EXPECT_EQ(world.cloth(2)->work().numerical, work.numerical);
  EXPECT_EQ(world.cloth(2)->steps(), taken);
  EXPECT_EQ(world.tets(1)->steps(), taken);
  EXPECT_EQ(world.account(2).energy, account.energy);
  EXPECT_EQ(world.account(2).work, account.work);
  EXPECT_EQ(world.reduced(0)->state().q, body.q);
  EXPECT_EQ(world.reduced(0)->state().p, body.p);
  EXPECT_EQ(world.reduced(0)->rigid_state().centre, rigid.centre);
  EXPECT_EQ(world.reduced(0)->rigid_state().velocity, rigid.velocity);
  EXPECT_EQ(world.reduced(0)->options().step, kFrame);
}

}  // namespace
}  // namespace tremolo
