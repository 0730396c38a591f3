// Loads in time on cloths and bodies of tetrahedra of a world: momenta, work, displacement at rest,
// steps in parts, contact.
#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "runtime/scene/scene_start.h"
#include "runtime/world/guest_loads.h"
#include "runtime/world/guest_points.h"
#include "tests/mixed/cloth_bodies.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;
using testing::MixedKind;
using testing::MixedWorld;

constexpr double kLoadGravity = 9.81;

// A free cube of 1 kg, or a sheet, and a method.
struct LoadedKind {
  bool cloth = true;
  const char* integrator = "energy";
  TetMethod method = TetMethod::kMidpoint;
};

constexpr LoadedKind kLoaded[] = {{true, "energy"},
                                  {true, "midpoint"},
                                  {true, "implicit-euler"},
                                  {false, "", TetMethod::kMidpoint},
                                  {false, "", TetMethod::kNewmark},
                                  {false, "", TetMethod::kImplicitEuler},
                                  {false, "", TetMethod::kBdf2}};

const char* name_of(const LoadedKind& loaded) {
  return loaded.cloth ? loaded.integrator : tet_method_name(loaded.method);
}

void add_body(MixedWorld& world, const LoadedKind& loaded, MixedKind kind, double young = 2e4) {
  kind.method = loaded.method;
  if (loaded.cloth)
    ASSERT_TRUE(world.add(testing::sheet_body({.integrator = loaded.integrator}, kind)));
  else
    ASSERT_TRUE(
        world.add("cube", testing::tets_body(testing::tets_cube(young, 2), kind, Vector3d::Zero(),
                                             Vector3d::Zero(), Vector3d::Zero())));
}

double mass_of(MixedWorld& world) {
  return world.cloth(0) != nullptr ? world.cloth(0)->mass() : world.tets(0)->model().mass();
}

SceneLoad load_of(const char* at, const Vector3d& force, const Signal& signal) {
  return {.signal = signal, .table = nullptr, .at = at, .force = force};
}

Signal constant() {
  return {.kind = SignalKind::kConstant};
}

// Motion under a constant force F on a face: the momentum is F t, whatever the method and the step.
TEST(GuestLoad, AForceOverTheMassMovesAFreeBody) {
  for (const LoadedKind& loaded : kLoaded)
    for (const double h : {4e-3, 2e-3}) {
      SCOPED_TRACE(std::string(name_of(loaded)) + " " + std::to_string(h));
      MixedWorld world(h);
      add_body(world, loaded, {.step = h});
      const Vector3d force(0.3, -0.2, 0.5);
      // One side of the cube; the left half of the sheet.
      ASSERT_TRUE(
          add_guest_loads(world.guests(), 0, std::array{load_of("x<40%", force, constant())}));
      for (int k = 1; k <= 25; ++k) {
        ASSERT_TRUE(world.step());
        const Vector3d expected = k * h * force;
        ASSERT_LT((testing::sum_of(world).linear - expected).norm(), 1e-8 * expected.norm()) << k;
      }
      EXPECT_GT(testing::sum_of(world).angular.norm(), 1e-4) << "it acts beside the centre";
    }
}

// A force on all of a sheet accelerates each particle by F/m: the sheet stays flat and its springs
// at rest.
TEST(GuestLoad, AForceOnAllOfASheetLeavesItFlat) {
  const MixedKind kind{.step = 2e-3};
  MixedWorld world(kind.step);
  add_body(world, {}, kind);
  const Vector3d force(0.0, 0.1, 0.4);
  ASSERT_TRUE(add_guest_loads(world.guests(), 0, std::array{load_of("x>-9", force, constant())}));
  const Eigen::VectorXd before = world.cloth(0)->state().x;
  for (int k = 0; k < 50; ++k) ASSERT_TRUE(world.step());
  const double t = 50 * kind.step;
  const Vector3d way = 0.5 * t * t / mass_of(world) * force;
  const Eigen::VectorXd& x = world.cloth(0)->state().x;
  for (Eigen::Index i = 0; i < x.size(); i += 3)
    EXPECT_LT((x.segment<3>(i) - before.segment<3>(i) - way).norm(), 1e-9 * way.norm()) << i;
  EXPECT_NEAR(world.guests().load_work(0), force.dot(way), 1e-9 * force.dot(way));
}

// Torque of midpoint and `energy`: about the means of the points' ends.
TEST(GuestLoad, AForceBesideTheCentreTurnsTheBody) {
  for (const LoadedKind& loaded : {kLoaded[0], kLoaded[3]}) {
    SCOPED_TRACE(name_of(loaded));
    const MixedKind kind{.step = 2e-3};
    MixedWorld world(kind.step);
    add_body(world, loaded, kind);
    MixedGuests& guests = world.guests();
    const Vector3d force(0.0, 0.0, 0.4);
    const auto pushes = guest_pushes(guests, 0, "x<1%", force);
    ASSERT_TRUE(pushes);
    ASSERT_GT(pushes->size(), 2U);
    Vector3d sum = Vector3d::Zero();
    for (const PointPush& push : *pushes) sum += push.force;
    EXPECT_LT((sum - force).norm(), 1e-14);
    ASSERT_TRUE(guests.add_load({.guest = 0, .pushes = *pushes, .signal = constant()}));
    double work = 0.0;
    for (int k = 0; k < 50; ++k) {
      std::vector<Vector3d> from;
      for (const PointPush& push : *pushes) from.push_back(guests.point_at(0, push.point));
      const testing::MixedSum before = testing::sum_of(world);
      ASSERT_TRUE(world.step());
      Vector3d torque = Vector3d::Zero();
      for (std::size_t i = 0; i < from.size(); ++i) {
        const PointPush& push = (*pushes)[i];
        const Vector3d to = guests.point_at(0, push.point);
        torque += (0.5 * (from[i] + to)).cross(push.force);
        work += push.force.dot(to - from[i]);
      }
      const Vector3d gained = testing::sum_of(world).angular - before.angular;
      ASSERT_LT((gained - kind.step * torque).norm(), 1e-8 * kind.step * torque.norm()) << k;
    }
    EXPECT_NEAR(guests.load_work(0), work, 1e-12 * work);
    EXPECT_GT(work, 1e-5);
  }
}

// A square load that begins and ends inside steps, one that fits into a step, and a table with a
// jump: the impulse is F times the integral of the course.
TEST(GuestLoad, ItsImpulseIsThatOfTheCourseWhateverTheStep) {
  const auto table = std::make_shared<SignalTable>(
      SignalTable{{0.0013, 0.0101, 0.0101, 0.0172}, {0.0, 2.0, -1.0, 0.5}});
  for (const LoadedKind& loaded : {kLoaded[0], kLoaded[2], kLoaded[3], kLoaded[5], kLoaded[6]})
    for (const double h : {5e-3, 2.5e-3, 0.7e-3}) {
      SCOPED_TRACE(std::string(name_of(loaded)) + " " + std::to_string(h));
      MixedWorld world(h);
      add_body(world, loaded, {.step = h});
      const Vector3d one(0.7, 0.1, 0.0), two(0.0, 0.4, -0.2), three(0.1, 0.0, 0.9);
      SceneLoad of_table = load_of("x<1%", three, {.kind = SignalKind::kTable});
      of_table.table = table;
      of_table.scale = 0.5;
      ASSERT_TRUE(add_guest_loads(
          world.guests(), 0,
          std::array{load_of("x<1%", one,
                             {.kind = SignalKind::kSquare, .start = 1.1e-3, .duration = 0.0123}),
                     load_of("x<1%", two,
                             {.kind = SignalKind::kSquare, .start = 1.2e-3, .duration = 1e-4}),
                     of_table}));
      for (int k = 0; k < static_cast<int>(0.02 / h) + 1; ++k) ASSERT_TRUE(world.step());
      const double integral = 1.0 * 0.0088 + 0.5 * (-1.0 + 0.5) * 0.0071;
      const Vector3d expected = 0.0123 * one + 1e-4 * two + 0.5 * integral * three;
      // Once they are over the body takes its own steps.
      for (int k = 0; k < 3; ++k) {
        ASSERT_TRUE(world.step());
        ASSERT_EQ(world.in_islands(), 0U);
      }
      EXPECT_LT((testing::sum_of(world).linear - expected).norm(), 1e-8 * expected.norm());
    }
}

// The energy of a method without errors of its own grows by the work of the load; that of midpoint
// on tetrahedra to second order in the step.
TEST(GuestLoad, ItsWorkIsTheChangeOfTheEnergy) {
  {
    const MixedKind kind{.step = 2e-3};
    MixedWorld world(kind.step);
    add_body(world, {true, "energy"}, kind);
    ASSERT_TRUE(
        add_guest_loads(world.guests(), 0,
                        std::array{load_of("top-left", {0.01, 0.0, 0.03},
                                           {.kind = SignalKind::kSine, .frequency = 7.0})}));
    for (int k = 0; k < 150; ++k) ASSERT_TRUE(world.step());
    const double work = world.guests().load_work(0);
    EXPECT_GT(work, 1e-4);
    const double others = testing::own_energy(*world.cloth(0));
    EXPECT_NEAR(testing::sum_of(world).energy, work + others, 1e-9 * work);
  }
  double errors[2];
  for (const int fine : {0, 1}) {
    const MixedKind kind{.step = fine == 1 ? 0.5e-3 : 1e-3};
    MixedWorld world(kind.step);
    add_body(world, {false, "", TetMethod::kMidpoint}, kind);
    ASSERT_TRUE(
        add_guest_loads(world.guests(), 0,
                        std::array{load_of("z>99%", {0.0, 0.0, 3.0},
                                           {.kind = SignalKind::kSine, .frequency = 5.0})}));
    const double start = testing::sum_of(world).energy;
    for (double t = 0.0; t < 0.1499; t += kind.step) ASSERT_TRUE(world.step());
    const double work = world.guests().load_work(0);
    EXPECT_GT(work, 1e-3);
    errors[fine] = std::abs(testing::sum_of(world).energy - start - work) / work;
  }
  EXPECT_LT(errors[0], 1e-3);
  EXPECT_LT(errors[1], 0.4 * errors[0]);
}

// A bar of linear tetrahedra without lateral contraction under a force on its end: its elongation
// at rest is F L/(E A).
TEST(GuestLoad, ABarThatHoldsAForceIsLongerByForceTimesLengthOverStiffness) {
  const double young = 1e5, length = 0.4, side = 0.1;
  const TetMesh mesh = box_mesh({8, 2, 2}, {length, side, side});
  auto model = TetModel::create(mesh, {{{"gel", {young, 0.0, 1000.0}}}, {}},
                                testing::vertices_on_plane(mesh, 0, 0.0));
  ASSERT_TRUE(model);
  TetBodyOptions options;
  options.step = 0.05;
  options.method = TetMethod::kImplicitEuler;
  options.beta = 0.02;
  options.degree.kind = DegreeKind::kLinear;
  Result<TetBody> body = TetBody::create(*model, options);
  ASSERT_TRUE(body);
  MixedWorld world(options.step);
  ASSERT_TRUE(world.add("bar", std::move(*body)));
  MixedGuests& guests = world.guests();
  const double force = 20.0;  // 2 % longer
  ASSERT_TRUE(add_guest_loads(guests, 0, std::array{load_of("x>99%", {force, 0, 0}, constant())}));
  for (int k = 0; k < 400; ++k) ASSERT_TRUE(world.step());
  const double longer = force * length / (young * side * side);
  const std::size_t point = guests.point_near(0, {length, 0.5 * side, 0.5 * side});
  EXPECT_NEAR(guests.point_at(0, point).x() - length, longer, 1e-6 * longer);
  // All of the work is elastic energy, or was taken by the method.
  EXPECT_NEAR(world.tets(0)->elastic_energy(), 0.5 * force * longer, 1e-6 * force * longer);
  EXPECT_NEAR(guests.load_work(0), force * longer, 1e-6 * force * longer);
}

// A sine shakes the end of a bar of tetrahedra and of its reduced model by the same way.
TEST(GuestLoad, ASineMovesABarAsItMovesItsReducedModel) {
  const TetMesh mesh = box_mesh({6, 2, 2}, {0.3, 0.1, 0.1});
  const Model::Pointer reduced = testing::made_body("sine-bar", mesh, "1e6", "x<1%");
  ASSERT_NE(reduced, nullptr);
  auto model = TetModel::create(mesh, {{{"gel", {1e6, 0.3, 1000.0}}}, {}},
                                testing::vertices_on_plane(mesh, 0, 0.0));
  ASSERT_TRUE(model);
  const double h = 1e-3;
  TetBodyOptions options;
  options.step = h;
  options.method = TetMethod::kMidpoint;
  options.degree.kind = DegreeKind::kLinear;
  Result<TetBody> body = TetBody::create(*model, options);
  ASSERT_TRUE(body);
  MixedWorld world(h);
  ASSERT_TRUE(world.add("bar", std::move(*body)));
  MixedGuests& guests = world.guests();
  const Signal sine{.kind = SignalKind::kSine, .frequency = 10.0};
  const SceneLoad load = load_of("x>99%", {0.0, 0.0, 0.05}, sine);
  ASSERT_TRUE(add_guest_loads(guests, 0, std::array{load}));
  Result<ContactBody> other = ContactBody::create(reduced, "ep4", {.step = h}, FrameKind::kFixed);
  ASSERT_TRUE(other) << other.error().message;
  ASSERT_TRUE(add_loads({load}, *other));
  const VertexId tip = testing::vertices_on_plane(mesh, 0, 0.3).front();
  const auto point = guests.point_of_vertex(0, tip);
  ASSERT_TRUE(point);
  const Vector3d rest = guests.point_at(0, *point);
  double largest = 0.0, error = 0.0;
  for (int k = 0; k < 200; ++k) {
    ASSERT_TRUE(world.step());
    ASSERT_TRUE(other->step().converged);
    const double own = guests.point_at(0, *point).z() - rest.z();
    const double theirs = other->displacement(tip)->z();
    largest = std::max(largest, std::abs(theirs));
    error = std::max(error, std::abs(own - theirs));
  }
  EXPECT_GT(largest, 1e-5);
  EXPECT_LT(error, 0.02 * largest) << "the reduced model has 12 shapes";
}

// A cube is pressed on a floor by a load on its upper side: the floor carries both.
TEST(GuestLoad, PressesABodyOnTheFloor) {
  const MixedKind kind{.step = 5e-3,
                       .restitution = 0.0,
                       .friction = 0.5,
                       .gravity = {0, 0, -kLoadGravity},
                       .method = TetMethod::kImplicitEuler,
                       .beta = 0.01};
  MixedWorld world(kind.step);
  PlacedCollider floor;
  floor.shape = PlaneShape{};
  floor.friction = 0.5;
  floor.restitution = 0.0;
  world.set_colliders({&floor, 1});
  ASSERT_TRUE(world.add("cube", testing::tets_body(testing::tets_cube(1e5, 2), kind, {0, 0, 0.0505},
                                                   Vector3d::Zero(), Vector3d::Zero())));
  const double pressed = 15.0;
  ASSERT_TRUE(add_guest_loads(world.guests(), 0,
                              std::array{load_of("z>99%", {0, 0, -pressed}, constant())}));
  for (int k = 0; k < 600; ++k) ASSERT_TRUE(world.step()) << k;
  const double carried = world.account(0).impulse_vector.z() / kind.step;
  EXPECT_NEAR(carried, kLoadGravity + pressed, 1e-6 * carried) << "a cube of 1 kg";
}

// A sheet falls on a sphere while loads pull it; steps of a frame are taken in parts, in one of
// which a load begins. The sums of the parts account for all energy.
TEST(GuestLoad, CountsItsWorkInPartsOfAStep) {
  const MixedKind kind{
      .step = 1.0 / 60.0, .restitution = 0.5, .friction = 0.4, .gravity = {0, 0, -kLoadGravity}};
  MixedWorld world(kind.step);
  PlacedCollider ball;
  ball.shape = SphereShape{0.3};
  ball.friction = 0.4;
  ball.restitution = 0.5;
  world.set_colliders({&ball, 1});
  ClothScene scene = testing::sheet_scene({.integrator = "energy",
                                           .particles = 21,
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
  ASSERT_TRUE(add_guest_loads(
      guests, 0,
      std::array{load_of("right", {0.6, 0.0, 0.3}, {.kind = SignalKind::kSine, .frequency = 2.0}),
                 load_of("left", {-0.2, 0.3, -0.5},
                         {.kind = SignalKind::kSquare, .start = 0.204, .duration = 0.02})}));
  const double start = testing::sum_of(world).energy;
  double taken = 0.0;
  int cut = 0;
  Vector3d given_by_ball = Vector3d::Zero();
  for (int i = 0; i < 20; ++i) {
    ASSERT_TRUE(world.step()) << i;
    given_by_ball += world.account(0).impulse_vector;
    cut += world.report().cut;
    taken += world.account(0).lost + world.account(0).friction_loss;
    const double given = guests.load_work(0) + testing::own_energy(sheet) - taken;
    EXPECT_NEAR(testing::sum_of(world).energy, start + given, 1e-9) << i;
  }
  EXPECT_GT(cut, 0);
  EXPECT_GT(guests.load_work(0), 0.03);
  // The impulses of the loads are exact, whatever the parts.
  const double t = 20 * kind.step, omega = 4.0 * std::numbers::pi;
  const Vector3d expected = given_by_ball + t * sheet.mass() * kind.gravity +
                            (1.0 - std::cos(omega * t)) / omega * Vector3d(0.6, 0.0, 0.3) +
                            0.02 * Vector3d(-0.2, 0.3, -0.5);
  EXPECT_LT((testing::sum_of(world).linear - expected).norm(), 1e-8);
}

// Free fall under gravity that changes: velocities, and the work of gravity as its energy.
TEST(GuestLoad, GravityThatChangesGivesItsImpulseAndItsWork) {
  const auto gravity_at = [](double t) { return Vector3d(0.5, -3.0 * t, -9.81 + 40.0 * t); };
  for (const LoadedKind& loaded : {kLoaded[0], kLoaded[3], kLoaded[4], kLoaded[6]}) {
    SCOPED_TRACE(name_of(loaded));
    const double h = 2e-3;
    MixedWorld world(h);
    add_body(world, loaded, {.step = h, .gravity = gravity_at(0.0)});
    const double start = world.tets(0) != nullptr ? world.tets(0)->gravity_energy() : 0.0;
    for (int k = 0; k < 100; ++k) {
      world.guests().set_gravity(gravity_at((k + 0.5) * h));
      ASSERT_TRUE(world.step());
    }
    const double t = 100 * h, m = mass_of(world);
    const Vector3d v(0.5 * t, -1.5 * t * t, -9.81 * t + 20.0 * t * t);
    EXPECT_LT((testing::sum_of(world).linear - m * v).norm(), 1e-9 * m * v.norm());
    const double work = world.tets(0) != nullptr ? start - world.tets(0)->gravity_energy()
                                                 : world.cloth(0)->work().gravity;
    if (loaded.method == TetMethod::kBdf2) continue;  // its positions are of second order
    EXPECT_NEAR(work, 0.5 * m * v.squaredNorm(), 1e-9 * work);
  }
}

// A force for some steps gives its impulse and then leaves no trace.
TEST(GuestLoad, AForceForSomeStepsEnds) {
  const MixedKind kind{.step = 2e-3};
  MixedWorld world(kind.step);
  add_body(world, {false, "", TetMethod::kMidpoint}, kind);
  MixedGuests& guests = world.guests();
  const Vector3d force(0.0, 1.5, 0.0), other(0.5, 0.0, 0.0);
  ASSERT_TRUE(guests.apply_force(0, 3, force, 4));
  ASSERT_TRUE(guests.apply_force(0, 5, other, 1));
  ASSERT_TRUE(world.step());
  ASSERT_TRUE(guests.apply_force(0, 5, other, 1)) << "it takes the place of the one that is over";
  for (int k = 0; k < 3; ++k) ASSERT_TRUE(world.step());
  const Vector3d expected = kind.step * (4.0 * force + 2.0 * other);
  EXPECT_LT((testing::sum_of(world).linear - expected).norm(), 1e-9 * expected.norm());
  EXPECT_FALSE(guests.has_load(0));
  ASSERT_TRUE(world.step());
  EXPECT_EQ(world.in_islands(), 0U);
  EXPECT_LT((testing::sum_of(world).linear - expected).norm(), 1e-9 * expected.norm());
}

TEST(GuestLoad, RefusesWhatCannotBeLoaded) {
  const MixedKind kind{.step = 2e-3};
  MixedWorld world(kind.step);
  const TetMesh mesh = box_mesh({2, 2, 2}, {0.1, 0.1, 0.1});
  auto model = TetModel::create(mesh, {{{"gel", {1e5, 0.3, 1000.0}}}, {}},
                                testing::vertices_on_plane(mesh, 2, 0.0));
  ASSERT_TRUE(model);
  TetBodyOptions options;
  options.step = kind.step;
  Result<TetBody> body = TetBody::create(*model, options);
  ASSERT_TRUE(body) << body.error().message;
  ASSERT_TRUE(world.add("block", std::move(*body)));
  MixedGuests& guests = world.guests();
  const auto refusal = [&](const char* at, const Vector3d& force) {
    const Status added = add_guest_loads(guests, 0, std::array{load_of(at, force, constant())});
    return added ? std::string() : added.error().message;
  };
  const Vector3d up = Vector3d::UnitZ();
  EXPECT_NE(refusal("z<1%", up).find("no vertex there moves"), std::string::npos);
  EXPECT_NE(refusal("fixed", up).find("no vertex there moves"), std::string::npos);
  EXPECT_NE(refusal("13", up).find("vertex 13 is inside"), std::string::npos) << refusal("13", up);
  EXPECT_NE(refusal("99", up).find("no vertex 99: it has 27"), std::string::npos);
  EXPECT_NE(refusal("z>99%", Vector3d::Zero()).find("the force is zero"), std::string::npos);
  EXPECT_NE(refusal("z>400%", up).find("z>400%"), std::string::npos);
  EXPECT_NE(refusal("", up).find("needs `at` and `force`"), std::string::npos);
  EXPECT_FALSE(guests.apply_force(0, 1000000, up, 1)) << "there is no such point";
  EXPECT_FALSE(guests.apply_force(0, *guests.point_of_vertex(0, 0), up, 1)) << "it is fixed";
  const std::size_t point = *guests.point_of_vertex(0, 26);
  EXPECT_FALSE(guests.apply_force(0, point, up, 0));
  EXPECT_FALSE(guests.apply_force(0, point, Vector3d::Constant(std::nan("")), 1));
  EXPECT_FALSE(guests.has_load(0));
  // Fixed vertices of a selection take their part of the force, as in reduced bodies.
  EXPECT_EQ(refusal("z<60%", up), "");
}

}  // namespace
}  // namespace tremolo
