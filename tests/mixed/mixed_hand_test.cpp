// Hands that hold cloths and bodies of tetrahedra in a world: the displacement at rest, momentum,
// energy, contact, steps in parts.
#include <algorithm>
#include <cmath>

#include "tests/mixed/cloth_bodies.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;
using testing::MixedKind;
using testing::MixedWorld;

constexpr double kHandGravity = 9.81;

MixedKind hanging_kind() {
  return {.step = 5e-3,
          .restitution = 0.0,
          .friction = 0.5,
          .gravity = {0, 0, -kHandGravity},
          .method = TetMethod::kImplicitEuler,
          .beta = 0.01};
}

// Steps a world of one guest until it is at rest.
void come_to_rest(MixedWorld& world, int steps) {
  for (int i = 0; i < steps; ++i) {
    const Status made = world.step();
    ASSERT_TRUE(made) << i;
  }
}

// A body hangs on a hand that does not move: its spring is longer by weight / stiffness.
TEST(GuestHand, HoldsTheWeightOfWhatHangsOnIt) {
  MixedKind kind = hanging_kind();
  kind.step = 0.02;  // implicit-euler then ends the pendulum's motion within seconds
  for (const bool cloth : {true, false}) {
    SCOPED_TRACE(cloth ? "cloth" : "tetrahedra");
    MixedWorld world(kind.step);
    if (cloth)
      ASSERT_TRUE(world.add(testing::sheet_body({}, kind)));
    else
      ASSERT_TRUE(
          world.add("cube", testing::tets_body(testing::tets_cube(1e5, 2), kind, Vector3d::Zero(),
                                               Vector3d::Zero(), Vector3d::Zero())));
    const double mass = cloth ? world.cloth(0)->mass() : world.tets(0)->model().mass();
    MixedGuests& guests = world.guests();
    // The middle of an edge of the sheet; the middle of the cube's upper side.
    const std::size_t point =
        guests.point_near(0, cloth ? Vector3d(0.0, 0.15, 0.0) : Vector3d(0.0, 0.0, 0.05));
    const Vector3d begun = guests.point_at(0, point);
    const double stiffness = mass * 200.0;
    ASSERT_TRUE(guests.hold(0, point, {stiffness, 10.0 * mass}));
    come_to_rest(world, 3000);
    const Vector3d way = guests.point_at(0, point) - begun;
    const double longer = mass * kHandGravity / stiffness;
    EXPECT_NEAR(way.z(), -longer, 1e-5 * longer);
    EXPECT_LT(way.head<2>().norm(), 1e-5 * longer);
    EXPECT_NEAR(guests.hand(0)->force.z(), mass * kHandGravity, 1e-5 * mass * kHandGravity);
    // The centre hangs below the hand.
    const Vector3d pull = guests.hand(0)->force;
    EXPECT_LT(pull.head<2>().norm(), 1e-5 * pull.z());
  }
}

// The force that the hand's spring and damper have by its own formula, from the positions alone.
Vector3d expected_pull(const GuestHand& hand, const Vector3d& x0, const Vector3d& x1,
                       const Vector3d& p0, const Vector3d& p1, double h) {
  const Vector3d middle = 0.5 * (x0 + x1) - 0.5 * (p0 + p1);
  return -hand.stiffness * middle - hand.damping * ((x1 - x0) - (p1 - p0)) / h;
}

struct PullKind {
  bool cloth = true;
  const char* integrator = "energy";
  TetMethod method = TetMethod::kMidpoint;
};

// In each step momentum grows by the impulses of the hand and of gravity. In the sum, the energy of
// a method without errors of its own grows by the works of the hand and of gravity.
TEST(GuestHand, GivesItsImpulseAndItsWork) {
  for (const PullKind& pulled :
       {PullKind{true, "energy"}, PullKind{true, "midpoint"}, PullKind{true, "implicit-euler"},
        PullKind{false, "", TetMethod::kMidpoint},
        PullKind{false, "", TetMethod::kImplicitEuler}}) {
    SCOPED_TRACE(pulled.cloth ? pulled.integrator : tet_method_name(pulled.method));
    const MixedKind kind{.step = 2e-3, .gravity = {0, 0, -kHandGravity}, .method = pulled.method};
    MixedWorld world(kind.step);
    if (pulled.cloth)
      ASSERT_TRUE(world.add(testing::sheet_body({.integrator = pulled.integrator}, kind)));
    else
      ASSERT_TRUE(
          world.add("cube", testing::tets_body(testing::tets_cube(2e4, 2), kind, Vector3d::Zero(),
                                               Vector3d::Zero(), Vector3d::Zero())));
    const double mass = pulled.cloth ? world.cloth(0)->mass() : world.tets(0)->model().mass();
    MixedGuests& guests = world.guests();
    const std::size_t point = guests.point_near(0, {0.15, 0.15, 0.05});
    ASSERT_TRUE(guests.hold(0, point, {mass * 400.0, mass * 5.0}));
    const testing::MixedSum start = testing::sum_of(world);
    Vector3d p0 = guests.point_at(0, point);
    double work = 0.0, size = 0.0;
    for (int i = 0; i < 200; ++i) {
      const Vector3d x0 = guests.point_at(0, point), before = testing::sum_of(world).linear;
      const Vector3d p1 = p0 + kind.step * Vector3d(0.3, 0.2 * std::sin(0.05 * i), 0.8);
      ASSERT_TRUE(guests.move_hand(0, p1));
      ASSERT_TRUE(world.step()) << i;
      const Vector3d x1 = guests.point_at(0, point);
      const Vector3d pull = expected_pull(*guests.hand(0), x0, x1, p0, p1, kind.step);
      size = std::max(size, pull.norm());
      ASSERT_LT((guests.hand(0)->force - pull).norm(), 1e-9 * size);
      const Vector3d impulse = kind.step * (pull + mass * kind.gravity);
      ASSERT_LT((testing::sum_of(world).linear - before - impulse).norm(), 1e-9 * kind.step * size);
      work += pull.dot(x1 - x0);
      p0 = p1;
    }
    EXPECT_NEAR(guests.sums(0).hand, work, 1e-12 * std::abs(work));
    EXPECT_GT(work, 1e-3 * mass);
    if (!pulled.cloth) continue;
    const ClothBody& body = *world.cloth(0);
    const double gained = testing::sum_of(world).energy - start.energy;
    const double others = testing::own_energy(body);  // gravity, dampers, the method
    EXPECT_NEAR(gained, work + others, 1e-9 * work);
    if (pulled.integrator == std::string("energy")) {
      EXPECT_LT(std::abs(body.work().numerical), 1e-9 * work);
    }
  }
}

// A cube is pushed on a floor by a hand: the floor carries its weight and the hand's force.
// A stiff cube swings on a hand along the line through its centre, without damping: its amplitude
// remains v/omega. A force that bdf2 had late by half a step would raise it by omega^2 h/4 a
// second, 10 % here.
TEST(GuestHand, GivesASwingingBodyNoEnergy) {
  for (const double step : {4e-3, 2e-3}) {
    MixedKind kind = hanging_kind();
    kind.step = step;
    kind.gravity.setZero();
    kind.beta = 0.0;
    kind.method = TetMethod::kBdf2;
    MixedWorld world(step);
    ASSERT_TRUE(
        world.add("cube", testing::tets_body(testing::tets_cube(1e7, 2), kind, Vector3d::Zero(),
                                             {0.0, 0.0, 0.3}, Vector3d::Zero())));
    MixedGuests& guests = world.guests();
    const double omega = 10.0, mass = world.tets(0)->model().mass();
    const std::size_t point = guests.point_near(0, Vector3d(0.0, 0.0, 0.05));
    const double begun = guests.point_at(0, point).z();
    ASSERT_TRUE(guests.hold(0, point, {omega * omega * mass, 0.0}));
    double largest = 0.0;
    for (int i = 0; i < std::lround(5.0 / step); ++i) {
      ASSERT_TRUE(world.step()) << i;
      if (i * step > 4.0)
        largest = std::max(largest, std::abs(guests.point_at(0, point).z() - begun));
    }
    EXPECT_NEAR(largest, 0.3 / omega, 0.005 * 0.3 / omega) << step;
  }
}

TEST(GuestHand, PressesABodyOnTheFloor) {
  const MixedKind kind = hanging_kind();
  MixedWorld world(kind.step);
  PlacedCollider floor;
  floor.shape = PlaneShape{};
  floor.friction = 0.5;
  floor.restitution = 0.0;
  world.set_colliders({&floor, 1});
  ASSERT_TRUE(world.add("cube", testing::tets_body(testing::tets_cube(1e5, 2), kind, {0, 0, 0.0505},
                                                   Vector3d::Zero(), Vector3d::Zero())));
  MixedGuests& guests = world.guests();
  const std::size_t point = guests.point_near(0, {0.0, 0.0, 0.2});
  const Vector3d begun = guests.point_at(0, point);
  ASSERT_TRUE(guests.hold(0, point, {500.0, 5.0}));
  ASSERT_TRUE(guests.move_hand(0, begun - Vector3d(0, 0, 0.02)));
  come_to_rest(world, 600);
  const double pressed = 500.0 * (guests.point_at(0, point).z() - (begun.z() - 0.02));
  EXPECT_GT(pressed, 5.0);
  EXPECT_NEAR(-guests.hand(0)->force.z(), pressed, 1e-6 * pressed);
  const double carried = world.account(0).impulse_vector.z() / kind.step;
  EXPECT_NEAR(carried, kHandGravity + pressed, 1e-6 * carried) << "a cube of 1 kg";
  // Released, it lies there with its weight alone.
  guests.let_go(0);
  come_to_rest(world, 600);
  EXPECT_EQ(guests.hand(0), nullptr);
  EXPECT_NEAR(world.account(0).impulse_vector.z() / kind.step, kHandGravity, 1e-5);
}

// A sheet falls on a sphere while a hand pulls its corner aside; steps of a frame are taken in
// parts. The sums of the parts account for all energy.
TEST(GuestHand, CountsItsWorkInPartsOfAStep) {
  const MixedKind kind{
      .step = 1.0 / 60.0, .restitution = 0.5, .friction = 0.4, .gravity = {0, 0, -kHandGravity}};
  MixedWorld world(kind.step);
  PlacedCollider ball;
  ball.shape = SphereShape{0.3};
  ball.friction = 0.4;
  ball.restitution = 0.5;
  world.set_colliders({&ball, 1});
  ClothScene scene = testing::sheet_scene({.integrator = "energy",
                                           .particles = 41,
                                           .width = 1.2,
                                           .thickness = 0.01,
                                           .middle = {0, 0, 0.5},
                                           .structural = {500.0, 0.05},
                                           .shear = {150.0, 0.05},
                                           .bend = {5.0, 0.005}},
                                          kind);
  scene.cloths[0].crumple = 0.02;
  Result<ClothBody> body = ClothBody::create(scene);
  ASSERT_TRUE(body) << body.error().message;
  ASSERT_TRUE(world.add(std::move(*body)));
  const ClothBody& sheet = *world.cloth(0);
  MixedGuests& guests = world.guests();
  const std::size_t point = guests.point_near(0, {0.6, 0.6, 0.5});
  ASSERT_TRUE(guests.hold(0, point, {50.0, 2.0}));
  const Vector3d begun = guests.point_at(0, point);
  const double start = testing::sum_of(world).energy;
  double taken = 0.0;
  int cut = 0;
  for (int i = 0; i < 16; ++i) {
    ASSERT_TRUE(guests.move_hand(0, begun + (i + 1) * kind.step * Vector3d(1.0, 0.5, 0.5)));
    const Status made = world.step();
    ASSERT_TRUE(made) << i;
    cut += world.report().cut;
    taken += world.account(0).lost + world.account(0).friction_loss;
    const double given = guests.sums(0).hand + testing::own_energy(sheet) - taken;
    EXPECT_NEAR(testing::sum_of(world).energy, start + given, 1e-9) << i;
  }
  EXPECT_GT(cut, 0);
  EXPECT_GT(guests.sums(0).hand, 0.1);
}

// The hand moves on straight from the start of a part to its end, in the time of the part.
TEST(GuestHand, MovesOnThroughThePartsOfAStep) {
  const MixedKind kind = hanging_kind();
  ClothBody body = testing::sheet_body({.velocity = {0.2, 0.0, 0.1}}, kind);
  ClothStep step(body, {});
  step.start();
  const Vector3d p0(0.1, 0.2, 0.3), way(0.04, -0.02, 0.01);
  const GuestHand hand{0, 4, 30.0, 2.0, p0, p0 + way};
  step.start_parts();
  for (const double from : {0.0, 0.25, 0.5, 0.75}) {
    const double to = from + 0.25, h = 0.25 * kind.step;
    step.start_part(from, to);
    step.begin();
    step.evaluate({});
    HandPull pull;
    pull.set(step, hand, from, to, kind.step);
    pull.press({});
    const SiteMotion at = step.motion(hand.point);
    ASSERT_GT((at.end - at.start).norm(), 0.1 * h);
    const Vector3d expected =
        expected_pull(hand, at.start, at.end, p0 + from * way, p0 + to * way, h);
    EXPECT_LT((pull.force() - expected).norm(), 1e-12 * expected.norm()) << from;
  }
  step.end_parts(false);
}

// A hand that has been removed leaves the bits of a guest without one.
TEST(GuestHand, LeavesNoTraceOnceItHasLetGo) {
  const MixedKind kind = hanging_kind();
  MixedWorld held(kind.step), free(kind.step);
  for (MixedWorld* world : {&held, &free}) ASSERT_TRUE(world->add(testing::sheet_body({}, kind)));
  ASSERT_TRUE(held.guests().hold(0, 3, {1.0, 0.0}));
  held.guests().let_go(0);
  for (int i = 0; i < 20; ++i) {
    ASSERT_TRUE(held.step());
    ASSERT_TRUE(free.step());
  }
  EXPECT_EQ(held.cloth(0)->state().x, free.cloth(0)->state().x);
  EXPECT_EQ(held.in_islands(), 0U);
}

TEST(GuestHand, RefusesWhatCannotBeHeld) {
  const MixedKind kind = hanging_kind();
  MixedWorld world(kind.step);
  ClothScene scene = testing::sheet_scene({}, kind);
  scene.cloths.front().pins.emplace_back().particles = {0};
  Result<ClothBody> pinned = ClothBody::create(scene);
  ASSERT_TRUE(pinned) << pinned.error().message;
  ASSERT_TRUE(world.add(std::move(*pinned)));
  MixedGuests& guests = world.guests();
  EXPECT_FALSE(guests.hold(0, 0, {1.0, 1.0})) << "a pin fixes it";
  EXPECT_FALSE(guests.hold(0, 81, {1.0, 1.0})) << "there are 81";
  EXPECT_FALSE(guests.hold(0, 1, {-1.0, 1.0}));
  EXPECT_FALSE(guests.hold(0, 1, {1.0, std::nan("")}));
  EXPECT_FALSE(guests.move_hand(0, Vector3d::Zero())) << "there is none";
  EXPECT_EQ(guests.hand(0), nullptr);
  ASSERT_TRUE(guests.hold(0, 1, {1.0, 1.0}));
  EXPECT_FALSE(guests.move_hand(0, Vector3d::Constant(std::nan(""))));
}

}  // namespace
}  // namespace tremolo
