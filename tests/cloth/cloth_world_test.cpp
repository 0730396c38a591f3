// Cloth with balls and colliders, and scenes that are refused.
#include "runtime/bodies/cloth/cloth_world.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <string_view>

#include <gtest/gtest.h>

#include "runtime/bodies/cloth/ball_motion.h"
#include "tests/cloth/cloth_samples.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

ClothScene sheet_above_ball(bool fixed) {
  ClothScene scene = testing::sheet_and_ball({0.03, 0.02, fixed ? -0.25 : 0.25});
  scene.integrator = "symplectic-euler";
  scene.options.step = 5e-4;
  scene.gravity.values = {{0.0, 0.0, -9.81}};
  scene.balls[0].fixed = fixed;
  return scene;
}

TEST(ClothWorld, ABallOnAFreeSheetKeepsLinearMomentumToRounding) {
  ClothScene scene = sheet_above_ball(false);
  scene.gravity.values.clear();
  scene.balls[0].velocity = {0.3, -0.2, -2.0};
  scene.balls[0].spin = {3.0, 1.0, -2.0};
  Result<ClothWorld> world = ClothWorld::create(scene);
  ASSERT_TRUE(world) << world.error().message;
  const Vector3d before = world->linear_momentum();
  for (int k = 0; k < 800; ++k) ASSERT_TRUE(world->step());
  EXPECT_LT(std::abs(world->energy().contact), 10.0);
  EXPECT_LT(world->energy().contact, 0.0);
  // Some ten thousand impulses of up to 1e-2 N s.
  EXPECT_LE((world->linear_momentum() - before).norm(), 1e-13);
  EXPECT_EQ(world->penetration_max(), 0.0);
}

TEST(ClothWorld, EnergyIsAccountedForToRounding) {
  for (const bool fixed : {false, true}) {
    ClothScene scene = sheet_above_ball(fixed);
    scene.cloths[0].drag = 1.2;
    scene.wind = {1.0, 0.5, 0.0};
    Result<ClothWorld> world = ClothWorld::create(scene);
    ASSERT_TRUE(world) << world.error().message;
    const double start = world->energy().total();
    for (int k = 0; k < 1000; ++k) ASSERT_TRUE(world->step());
    const ClothEnergy e = world->energy();
    EXPECT_NEAR(e.total() - start, e.wind + e.pins + e.contact + e.numerical - e.damped, 1e-11);
    EXPECT_EQ(world->penetration_max(), 0.0);
  }
}

TEST(ClothWorld, ImpulsesKeepBothMomenta) {
  Vector3d va(1.0, 2.0, -3.0), wa(3.0, -1.0, 2.0), vb(-0.3, 0.2, 1.0), wb(0.1, 4.0, 0.3);
  const Vector3d n = Vector3d(0.2, -0.1, 1.0).normalized(), point(0.3, 0.4, 0.5);
  const double ra = 0.2, rb = 0.3, ia = 2.5 / (0.7 * ra * ra), ib = 2.5 / (1.9 * rb * rb);
  const Vector3d xa = point + ra * n, xb = point - rb * n;
  ContactSide a{1.0 / 0.7, ia, -ra * n, &va, &wa, {}}, b{1.0 / 1.9, ib, rb * n, &vb, &wb, {}};
  const auto linear = [&] { return Vector3d(0.7 * va + 1.9 * vb); };
  const auto angular = [&] {
    return Vector3d(0.7 * xa.cross(va) + 1.9 * xb.cross(vb) + wa / ia + wb / ib);
  };
  const Vector3d p = linear(), l = angular();
  ASSERT_TRUE(collide(n, {0.4, 0.6, 0.0}, a, b));
  EXPECT_LE((linear() - p).norm(), 1e-14);
  EXPECT_LE((angular() - l).norm(), 1e-14);
}

// a = 5/7 g sin of the slope, where friction suffices.
TEST(ClothWorld, ABallRollsDownASlopeWithFiveSeventhsOfTheFall) {
  ClothScene scene = sheet_above_ball(false);
  scene.cloths[0].grid.corner = {50.0, 0.0, 50.0};
  constexpr double kSlope = 0.2;
  SceneCollider slope;
  slope.name = "slope";
  slope.shape = PlaneShape{};
  slope.pose.rotation = Eigen::AngleAxisd(kSlope, Vector3d::UnitY());
  slope.friction = 0.5;
  scene.colliders = {slope};
  scene.balls[0].friction = 0.5;
  scene.balls[0].position = 0.2 * (slope.pose.rotation * Vector3d::UnitZ());
  Result<ClothWorld> world = ClothWorld::create(scene);
  ASSERT_TRUE(world) << world.error().message;
  for (int k = 0; k < 1000; ++k) ASSERT_TRUE(world->step());
  const double speed = world->balls()[0].velocity.norm();
  // Its point of contact sticks to the slope within each step: to a step's share.
  EXPECT_NEAR(speed, 5.0 / 7.0 * 9.81 * std::sin(kSlope) * world->time(), 2e-3 * speed);
}

// The first second of cloth-sphere.toml on a coarser sheet, from just above the ball. Newton's
// matrix without the indefinite terms of compressed springs left a third of the steps to be
// subdivided.
TEST(ClothWorld, ACrumpledSheetOverABallIsSolvedInWholeSteps) {
  ClothScene scene = testing::sheet_and_ball({0.0, 0.0, 0.0});
  SceneCloth& sheet = scene.cloths[0];
  sheet.grid.columns = sheet.grid.rows = 31;
  sheet.grid.width = sheet.grid.height = 1.2;
  sheet.grid.corner = {-0.6, -0.6, 0.32};
  sheet.structural = {500.0, 0.05};
  sheet.shear = {150.0, 0.05};
  sheet.bend = {5.0, 0.005};
  sheet.crumple = 0.02;
  sheet.friction = 0.4;
  scene.balls[0].radius = 0.3;
  scene.balls[0].fixed = true;
  scene.gravity.values = {{0.0, 0.0, -9.81}};
  scene.integrator = "implicit-euler";
  scene.options.step = 1.0 / 60.0;
  Result<ClothWorld> world = ClothWorld::create(scene);
  ASSERT_TRUE(world) << world.error().message;
  for (int k = 0; k < 60; ++k) ASSERT_TRUE(world->step());
  RecordProperty("cut", std::to_string(world->cut_steps()));
  RecordProperty("iterations", std::to_string(world->iterations()));
  EXPECT_LE(world->cut_steps(), 1);
  EXPECT_LE(world->iterations(), 60 * 40);
  EXPECT_EQ(world->penetration_max(), 0.0);
}

TEST(ClothWorld, HandsHoldAndLetGo) {
  ClothScene scene = sheet_above_ball(true);
  Result<ClothWorld> world = ClothWorld::create(scene);
  ASSERT_TRUE(world);
  const Vector3d at = world->positions(0).head<3>() + Vector3d(0.0, 0.0, 0.01);
  ASSERT_TRUE(world->hold(0, 0, at));
  for (int k = 0; k < 100; ++k) ASSERT_TRUE(world->step());
  EXPECT_EQ(Vector3d(world->positions(0).head<3>()), at);
  ASSERT_TRUE(world->let_go(0, 0));
  for (int k = 0; k < 100; ++k) ASSERT_TRUE(world->step());
  EXPECT_NE(Vector3d(world->positions(0).head<3>()), at);
  EXPECT_FALSE(world->hold(0, 100000, at));
}

// A sheet in the air and a hand on its particle 17 from 0.02 s to 0.06 s.
ClothScene sheet_in_hand(const std::string& method, double step) {
  ClothScene scene = sheet_above_ball(true);
  scene.integrator = method;
  scene.options.step = step;
  scene.balls.clear();
  ClothHand hand;
  hand.cloth = scene.cloths[0].name;
  hand.particle = 17;
  hand.from = 0.02;
  hand.until = 0.06;
  const Pose up{Vector3d(0.05, 0.0, 0.1), Eigen::Quaterniond::Identity()};
  hand.motion.parts = {
      KeyframeMotion{.keys = {{0.0, {}}, {0.1, up}}, .interpolation = Interpolation::kLinear}};
  scene.hands = {hand};
  return scene;
}

TEST(ClothWorld, AHandOfTheSceneGoesItsWayFromWhereItTookTheParticle) {
  const ClothScene scene = sheet_in_hand("symplectic-euler", 5e-4);
  ClothScene without = scene;
  without.hands.clear();
  Result<ClothWorld> world = ClothWorld::create(scene), other = ClothWorld::create(without);
  ASSERT_TRUE(world && other) << (world ? other : world).error().message;
  const auto place = [](const ClothWorld& of) { return Vector3d(of.positions(0).segment<3>(51)); };
  const Vector3d speed(0.5, 0.0, 1.0);
  Vector3d taken = Vector3d::Zero();
  for (int k = 0; k < 160; ++k) {
    if (k == 40) taken = place(*world);
    ASSERT_TRUE(world->step());
    ASSERT_TRUE(other->step());
    if (k < 40) {
      EXPECT_EQ(world->positions(0), other->positions(0)) << k;
    } else if (k < 120) {
      // Rounding of positions of 1 m.
      EXPECT_LE((place(*world) - taken - (k - 39) * 5e-4 * speed).norm(), 1e-14) << k;
      EXPECT_EQ(world->model(0).held()[17], 1);
    } else {
      EXPECT_EQ(world->model(0).held()[17], 0);
    }
  }
  // It lifts the sheet.
  EXPECT_GT(world->energy().pins, 0.0);
  EXPECT_EQ(other->energy().pins, 0.0);
}

// Methods that save state between steps continue with it.
TEST(ClothWorld, AHandThatRestsIsAPin) {
  for (const char* method : {"symplectic-euler", "implicit-euler", "newmark", "bdf2", "energy"}) {
    ClothScene held = sheet_in_hand(method, 5e-4);
    ClothScene pinned = held;
    held.hands[0].from = 0.0;
    held.hands[0].motion.parts.clear();
    pinned.hands.clear();
    ClothPin pin;
    pin.particles = {held.hands[0].particle};
    pin.until = held.hands[0].until;
    pinned.cloths[0].pins = {pin};
    Result<ClothWorld> world = ClothWorld::create(held), other = ClothWorld::create(pinned);
    ASSERT_TRUE(world && other) << method;
    for (int k = 0; k < 160; ++k) {
      ASSERT_TRUE(world->step());
      ASSERT_TRUE(other->step());
      ASSERT_EQ(world->positions(0), other->positions(0)) << method << k;
    }
    EXPECT_EQ(world->model(0).held()[17], 0) << method;
  }
}

TEST(ClothWorld, OfHandsOnOneParticleTheNextTakesItWhereTheLastLetsGo) {
  ClothScene scene = sheet_in_hand("implicit-euler", 0.01);
  ClothHand next = scene.hands[0];
  next.from = scene.hands[0].until;
  next.until = 0.1;
  next.motion.parts.clear();
  scene.hands.insert(scene.hands.begin(), next);
  Result<ClothWorld> world = ClothWorld::create(scene);
  ASSERT_TRUE(world) << world.error().message;
  for (int k = 0; k < 6; ++k) ASSERT_TRUE(world->step());
  const Vector3d there = world->positions(0).segment<3>(51);
  for (int k = 6; k < 10; ++k) {
    ASSERT_TRUE(world->step());
    EXPECT_EQ(Vector3d(world->positions(0).segment<3>(51)), there);
  }
  ASSERT_TRUE(world->step());
  EXPECT_EQ(world->model(0).held()[17], 0);
}

// For any number of parts a step ends with the speed of the hand's path.
TEST(ClothWorld, AHandGoesEvenlyThroughAStepThatIsCut) {
  ClothScene scene = sheet_in_hand("implicit-euler", 0.02);
  scene.hands.clear();
  scene.options.max_iterations = 6;
  scene.options.tolerance = 1e-8;
  Result<ClothWorld> world = ClothWorld::create(scene);
  ASSERT_TRUE(world) << world.error().message;
  const Vector3d way(0.01, 0.02, 0.03), begun = world->positions(0).head<3>();
  for (int k = 1; k <= 3; ++k) {
    ASSERT_TRUE(world->hold(0, 0, begun + k * way));
    ASSERT_TRUE(world->step()) << k;
    EXPECT_EQ(world->cut_steps(), k);
    EXPECT_EQ(Vector3d(world->positions(0).head<3>()), begun + k * way);
    // Rounding of positions of 1 m over a 64th of the step at least.
    EXPECT_LE((world->velocities(0).head<3>() - way / 0.02).norm(), 1e-11);
  }
}

TEST(ClothWorld, BadScenesAreRefusedByName) {
  struct Bad {
    const char* word;
    std::function<void(ClothScene&)> spoil;
  };
  const auto held = [](std::string cloth, std::size_t particle, double from, double until) {
    return [=](ClothScene& s) { s.hands = {ClothHand{cloth, particle, {}, from, until}}; };
  };
  const std::string sheet = sheet_above_ball(true).cloths[0].name;
  const std::array<Bad, 13> all = {
      Bad{"hand 1: there is no cloth 'silk'", held("silk", 0, 0.0, 1.0)},
      Bad{"hand 1: there is no particle 196", held(sheet, 196, 0.0, 1.0)},
      Bad{"hand 1: until must be later than from", held(sheet, 0, 2.0, 1.0)},
      Bad{"hand 1: until must be later than from", held(sheet, 0, -1.0, 1.0)},
      Bad{"stiffness", [](ClothScene& s) { s.cloths[0].shear.stiffness = -1.0; }},
      Bad{"density", [](ClothScene& s) { s.cloths[0].density = 0.0; }},
      Bad{"columns", [](ClothScene& s) { s.cloths[0].grid.columns = 1; }},
      Bad{"width", [](ClothScene& s) { s.cloths[0].grid.width = 0.0; }},
      Bad{"no particle 9999",
          [](ClothScene& s) {
            s.cloths[0].pins = {ClothPin{{9999}, {}, 1.0}};
          }},
      Bad{"inside ball 'ball'", [](ClothScene& s) { s.balls[0].position.setZero(); }},
      Bad{"integrator", [](ClothScene& s) { s.integrator = "magic"; }},
      Bad{"grid or a file", [](ClothScene& s) { s.cloths[0].file = "sheet.obj"; }},
      Bad{"radius", [](ClothScene& s) { s.balls[0].radius = std::nan(""); }}};
  for (const Bad& bad : all) {
    ClothScene scene = sheet_above_ball(true);
    bad.spoil(scene);
    const Result<ClothWorld> world = ClothWorld::create(scene);
    ASSERT_FALSE(world) << bad.word;
    EXPECT_NE(world.error().message.find(bad.word), std::string::npos) << world.error().message;
  }
}

SurfaceMesh two_triangles() {
  return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}, {{0, 1, 2}, {1, 3, 2}}};
}

TEST(ClothWorld, BadMeshesAreRefused) {
  const auto problem = [](const SurfaceMesh& mesh) {
    const Result<ClothParts> parts = make_mesh_cloth(SceneCloth{}, mesh);
    return parts ? std::string() : parts.error().message;
  };
  EXPECT_EQ(problem(two_triangles()), "");
  SurfaceMesh mesh = two_triangles();
  mesh.vertices.push_back({5, 5, 5});
  EXPECT_NE(problem(mesh).find("isolated"), std::string::npos);
  mesh = two_triangles();
  for (int k = 0; k < 1000; ++k) {
    mesh.vertices.push_back({0.5, 0.5, 1.0 + k});
    mesh.triangles.push_back({1, 2, 4 + k});
  }
  EXPECT_NE(problem(mesh).find("1002 triangles"), std::string::npos);
  mesh = two_triangles();
  mesh.vertices[3] = mesh.vertices[1];
  EXPECT_NE(problem(mesh).find("no length"), std::string::npos);
}

// A stiff sheet on two corners above a fixed ball, in long steps.
ClothScene sheet_that_swings(const std::string& method) {
  ClothScene scene;
  scene.integrator = method;
  scene.options.step = 1.0 / 60.0;
  scene.gravity.times = {0.0};
  scene.gravity.values = {{0.0, 0.0, -9.81}};
  SceneCloth cloth;
  cloth.grid.columns = cloth.grid.rows = 12;
  cloth.grid.corner = {-0.5, -0.5, 1.0};
  cloth.pins = {{.particles = {0, 11}, .motion = {}}};
  scene.cloths = {cloth};
  SceneBall ball;
  ball.name = "ball";
  ball.position = {0.02, 0.01, 0.6};
  ball.radius = 0.2;
  ball.fixed = true;
  scene.balls = {ball};
  return scene;
}

constexpr const char* kMethodsThatLast[] = {
    "implicit-euler", "implicit-euler-linear", "midpoint", "newmark", "bdf2", "energy"};

// The most that the total rose above any earlier one, beyond what was given from outside, J.
double most_gained(ClothWorld& world, int steps) {
  double least = std::numeric_limits<double>::infinity(), most = 0.0;
  for (int k = 0; k <= steps; ++k) {
    const ClothEnergy e = world.energy();
    const double left = e.total() - e.wind - e.pins + e.damped;
    least = std::min(least, left);
    most = std::max(most, left - least);
    if (k == steps) break;
    const Status made = world.step();
    EXPECT_TRUE(made) << k;
    if (!made) break;
  }
  return most;
}

// Nothing is put in, so that what moves and is stretched has what gravity gave and no more, also
// where a sheet under tension slides over a ball for long.
TEST(ClothWorlds, ASheetThatSwingsOntoAFixedBallGainsNoEnergyInLongSteps) {
  for (const char* method : kMethodsThatLast) {
    auto world = ClothWorld::create(sheet_that_swings(method));
    ASSERT_TRUE(world) << world.error().message;
    // The sheet falls through 2 J; a method may add a hundredth of what moves (NodalOptions).
    EXPECT_LE(most_gained(*world, 60), 0.02) << method;
    EXPECT_LT(world->energy().contact, 0.0) << method;
    EXPECT_EQ(world->penetration_max(), 0.0) << method;
  }
}

// Between them and the sheet nothing is lost: linear momentum, which gravity does not change here.
TEST(ClothWorlds, ABallThatHitsAFreeSheetInLongStepsKeepsMomentum) {
  for (const char* method : kMethodsThatLast) {
    ClothScene scene = sheet_above_ball(false);
    scene.integrator = method;
    scene.options.step = 1.0 / 60.0;
    scene.options.tolerance = 1e-10;
    scene.gravity.values.clear();
    scene.balls[0].velocity = {0.3, -0.2, -2.0};
    scene.balls[0].spin = {3.0, 1.0, -2.0};
    auto world = ClothWorld::create(scene);
    ASSERT_TRUE(world) << world.error().message;
    const Vector3d before = world->linear_momentum(), turning = world->angular_momentum();
    EXPECT_LE(most_gained(*world, 40), 0.002) << method;  // of 0.2 J
    EXPECT_GT((world->balls()[0].velocity - scene.balls[0].velocity).norm(), 0.1) << method;
    // Newton's residual, 1e-10 of a load of 1e-3 x 60 N/m x 0.08 m x sqrt(springs), 40 steps.
    EXPECT_LE((world->linear_momentum() - before).norm(), 1e-9) << method;
    // The midpoint's rules keep it without contact: the projection changes it.
    if (method == std::string_view("energy") || method == std::string_view("midpoint")) {
      EXPECT_LE((world->angular_momentum() - turning).norm(), 3e-3 * turning.norm()) << method;
    }
    EXPECT_EQ(world->penetration_max(), 0.0) << method;
  }
}

// The ball stays in the sheet's frame: it is slowed by all of what the sheet bears.
TEST(ClothWorlds, AHeavyBallOnAHeldMatIsCarriedInLongSteps) {
  ClothScene scene;
  scene.options.step = 1.0 / 60.0;
  scene.gravity.times = {0.0};
  scene.gravity.values = {{0.0, 0.0, -9.81}};
  SceneCloth mat;
  mat.grid.columns = mat.grid.rows = 16;
  mat.grid.corner = {-0.5, -0.5, 1.0};
  mat.density = 0.3;
  mat.structural.stiffness = 3000.0;
  ClothPin rim;
  for (std::size_t k = 0; k < 16; ++k)
    for (const std::size_t particle : {k, 240 + k, 16 * k, 16 * k + 15})
      rim.particles.push_back(particle);
  mat.pins = {rim};
  scene.cloths = {mat};
  SceneBall ball;
  ball.name = "ball";
  ball.position = {0.02, 0.01, 1.3};
  ball.radius = 0.15;
  ball.mass = 1.0;
  ball.restitution = 0.0;
  scene.balls = {ball};
  auto world = ClothWorld::create(scene);
  ASSERT_TRUE(world) << world.error().message;
  double lowest = 10.0;
  for (int k = 0; k < 180; ++k) {
    ASSERT_TRUE(world->step()) << k;
    lowest = std::min(lowest, world->balls()[0].position.z());
  }
  // The mat lies at 1 m: the ball dips into it and does not fall through.
  EXPECT_GT(lowest, 0.7);
}

}  // namespace
}  // namespace tremolo
