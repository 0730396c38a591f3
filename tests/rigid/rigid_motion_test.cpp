// Rigid bodies that touch nothing: mass, inertia, and the motion of a top by Euler's equations.
#include <array>
#include <cmath>
#include <fstream>
#include <numbers>

#include "runtime/bodies/reduced/rigid/rigid_solid.h"
#include "tests/rigid/rigid_scene.h"
#include "tests/support/temporary_folder.h"

namespace tremolo {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using testing::rigid_body;

constexpr double kPi = std::numbers::pi;

Model::Pointer model_of(const RigidSolid& solid) {
  Result<Model::Pointer> model = make_rigid_model(solid);
  EXPECT_TRUE(model) << (model ? "" : model.error().message);
  return *model;
}

// Moments of inertia about the origin.
Vector3d moments_of(const Model& model) {
  const Matrix3d& second = model.inertia()->second_moment;
  return Vector3d::Constant(second.trace()) - second.diagonal();
}

// A fine surface of a shape has the shape's integrals, up to its facets: of second order in their
// size, 1/20 of the radius and less here.
TEST(RigidSolids, HaveTheIntegralsOfTheirSurface) {
  testing::TemporaryFolder folder;
  for (const Collider& shape :
       {Collider(SphereShape{0.3}), Collider(CapsuleShape{0.2, 0.4}),
        Collider(CylinderShape{0.25, 0.1}), Collider(BoxShape{{0.1, 0.2, 0.3}})}) {
    const std::string file = folder.file("surface.obj");
    const SurfaceMesh surface = surface_of_shape(shape, 20'000);
    ASSERT_TRUE(check_closed(surface)) << shape_name(shape);
    std::ofstream out(file);
    out.precision(17);
    for (const Vector3d& x : surface.vertices)
      out << "v " << x.x() << " " << x.y() << " " << x.z() << "\n";
    for (const Triangle& t : surface.triangles)
      out << "f " << t[0] + 1 << " " << t[1] + 1 << " " << t[2] + 1 << "\n";
    out.close();
    RigidSolid exact, meshed;
    exact.shape = shape;
    meshed.mesh = file;
    const Model::Pointer one = model_of(exact), other = model_of(meshed);
    EXPECT_NEAR(other->inertia()->mass, one->inertia()->mass, 2e-3 * one->inertia()->mass);
    const Vector3d a = moments_of(*one), b = moments_of(*other);
    EXPECT_LT((a - b).norm(), 3e-3 * a.norm()) << shape_name(shape);
    EXPECT_LT(other->inertia()->first_moment.norm(), 1e-9 * one->inertia()->mass);
  }
}

TEST(RigidSolids, KeepTheMassAndTheMomentsThatAreGiven) {
  RigidSolid solid;
  solid.shape = SphereShape{0.1};
  solid.mass = 3.0;
  EXPECT_LT((moments_of(*model_of(solid)) - Vector3d::Constant(0.4 * 3.0 * 0.01)).norm(), 1e-15);
  solid.inertia = Vector3d(0.02, 0.03, 0.04);
  EXPECT_LT((moments_of(*model_of(solid)) - *solid.inertia).norm(), 1e-15);
}

// The spin of an axisymmetric top turns about its axis at (I3 - I1)/I1 w3.
TEST(RigidTops, PrecessAtTheRateOfEuler) {
  const CylinderShape disc{0.2, 0.03};
  std::array<double, 3> errors{};
  for (std::size_t level = 0; level < 3; ++level) {
    Scene scene;
    scene.step = 2e-3 / std::pow(2.0, static_cast<double>(level));
    SceneBody top = rigid_body("top", disc, {0.0, 0.0, 0.0});
    top.spin = {3.0, 0.0, 20.0};
    scene.bodies = {top};
    SceneWorld world = testing::make_world(scene);
    const Vector3d moments = moments_of(world.body(0).model());
    const double rate = (moments.z() - moments.x()) / moments.x() * 20.0;
    const Momenta before = world.momenta(0);
    testing::run_until(world, 1.0);
    const Vector3d spin = world.body(0).rigid_state().spin;
    const Vector3d expected(3.0 * std::cos(rate), 3.0 * std::sin(rate), 20.0);
    errors[level] = (spin - expected).norm() / 3.0;
    // Rounding of a thousand steps and more.
    EXPECT_LT((world.momenta(0).angular - before.angular).norm(), 1e-12 * before.angular.norm());
    EXPECT_LT(std::abs(world.account(0).total() / world.account(0).at_start - 1.0), 1e-12);
  }
  EXPECT_LT(errors[2], 1e-2);
  EXPECT_NEAR(std::log2(errors[0] / errors[1]), 2.0, 0.1);
  EXPECT_NEAR(std::log2(errors[1] / errors[2]), 2.0, 0.1);
}

// A rod of the distance of two bodies at rest, whose second end is not given, holds the nearest
// vertex and pushes nothing.
TEST(RigidJoints, ARodToTheNearestVertexLeavesBodiesAtRest) {
  const BoxShape box{{0.05, 0.05, 0.05}};
  Scene scene;
  scene.step = 3e-3;
  scene.bodies = {rigid_body("a", box, {0.0, 0.0, 0.3}), rigid_body("b", box, {0.4, 0.0, 0.3})};
  SceneJoint rod;
  rod.body = "a";
  rod.at = "near:0.05,0.05,0.05";
  rod.to = "b";
  rod.options.length = 0.3;
  scene.joints = {rod};
  SceneWorld world = testing::make_world(scene);
  testing::run_until(world, 0.3);
  for (std::size_t i = 0; i < 2; ++i) EXPECT_LT(std::abs(world.account(i).total()), 1e-18);
  EXPECT_LT((world.body(1).pose().position - Vector3d(0.4, 0.0, 0.3)).norm(), 1e-12);
  scene.joints[0].options.length = 0.2;
  const auto refused = SceneWorld::create(scene, load_scene_model);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("0.3 m apart"), std::string::npos)
      << refused.error().message;
}

// A load pulls at the place that a joint holds, and the body hardly moves. The rounding of its
// positions times the joint's stiffness gives it more energy than the load, by far.
TEST(RigidJoints, ABodyPulledAgainstAJointIsNoExplosion) {
  for (const double step : {2e-3, 0.25e-3, 0.125e-3, 0.05e-3}) {
    SCOPED_TRACE(step);
    Scene scene;
    scene.step = step;
    SceneBody box = rigid_body("box", BoxShape{{0.095, 0.055, 0.025}}, {0.0, 0.0, 1.0}, 300.0);
    SceneLoad pull;
    pull.signal = {.kind = SignalKind::kSine, .frequency = 5.0};
    pull.at = "near:0,0,0.025";
    pull.force = Vector3d(0.13, 0.6, 0.5);
    box.loads = {pull};
    scene.bodies = {box};
    SceneJoint joint;
    joint.body = "box";
    joint.at = pull.at;
    scene.joints = {joint};
    SceneWorld world = testing::make_world(scene);
    int beyond = 0;
    testing::run_until(world, 0.2, [&] {
      if (!world.body(0).energy_bound().sound(world.account(0).total())) ++beyond;
    });
    EXPECT_EQ(beyond, 0);
    EXPECT_LT(world.account(0).total(), 1e-6);
  }
}

// A body that turns about its middle axis tumbles. Its spin follows from Euler's equations, which
// are integrated here by Runge and Kutta in steps a hundredth as long.
TEST(RigidTops, TumbleAboutTheirMiddleAxis) {
  const BoxShape box{{0.05, 0.1, 0.2}};
  std::array<double, 3> errors{};
  for (std::size_t level = 0; level < 3; ++level) {
    Scene scene;
    scene.step = 2e-3 / std::pow(2.0, static_cast<double>(level));
    SceneBody top = rigid_body("top", box, {0.0, 0.0, 0.0});
    top.spin = {0.05, 8.0, 0.02};
    scene.bodies = {top};
    SceneWorld world = testing::make_world(scene);
    const Vector3d moments = moments_of(world.body(0).model());
    testing::run_until(world, 1.2);
    const auto slope = [&moments](const Vector3d& w) {
      const Vector3d momentum = moments.cwiseProduct(w);
      return Vector3d(momentum.cross(w).cwiseQuotient(moments));
    };
    Vector3d w = top.spin;
    constexpr int kFine = 60'000;
    const double h = 1.2 / kFine;
    for (int k = 0; k < kFine; ++k) {
      const Vector3d a = slope(w), b = slope(w + 0.5 * h * a), c = slope(w + 0.5 * h * b),
                     d = slope(w + h * c);
      w += h / 6.0 * (a + 2.0 * b + 2.0 * c + d);
    }
    errors[level] = (world.body(0).rigid_state().spin - w).norm() / 8.0;
    EXPECT_LT(std::abs(world.account(0).total() / world.account(0).at_start - 1.0), 1e-12);
  }
  EXPECT_LT(errors[2], 1e-2);
  EXPECT_NEAR(std::log2(errors[1] / errors[2]), 2.0, 0.2);
}

// A free fall is exact: the parabola is a polynomial of second order.
// The equation of omega1 needs more than Newton's method there; what it leaves would be energy from
// nowhere.
TEST(RigidTops, KeepTheirEnergyAtManyRadiansAStep) {
  const std::array<Collider, 4> shapes = {CapsuleShape{0.015, 0.025}, CylinderShape{0.03, 0.01},
                                          BoxShape{{0.02, 0.03, 0.04}},
                                          BoxShape{{0.02, 0.02, 0.04}}};
  for (const Collider& shape : shapes)
    for (const double rate : {100.0, 400.0, 1000.0, 4000.0})  // 1 to 40 radians
      for (const Vector3d& along :
           {Vector3d(1.0, 3e-4, 1.0), Vector3d(1e-3, 1.0, 2e-3), Vector3d(1.0, -1.0, 0.333)}) {
        SCOPED_TRACE(shape_name(shape) + (" " + std::to_string(rate)));
        Scene scene;
        scene.step = 0.01;
        SceneBody top = rigid_body("top", shape, {0.0, 0.0, 0.0});
        top.spin = rate * along;
        scene.bodies = {top};
        SceneWorld world = testing::make_world(scene);
        const double energy = world.account(0).total();
        const Vector3d momentum = world.momenta(0).angular;
        testing::run_until(world, 1.0);
        EXPECT_NEAR(world.account(0).total(), energy, 1e-11 * energy);
        EXPECT_LT((world.momenta(0).angular - momentum).norm(), 1e-12 * momentum.norm());
      }
}

TEST(RigidBodies, FallOnAParabola) {
  Scene scene;
  scene.gravity.values = {{0.0, 0.0, -testing::kG}};
  SceneBody ball = rigid_body("ball", SphereShape{0.1}, {1.0, 2.0, 3.0});
  ball.velocity = {1.0, -2.0, 4.0};
  ball.spin = {1.0, 2.0, 3.0};
  scene.bodies = {ball};
  SceneWorld world = testing::make_world(scene);
  testing::run_until(world, 3.0);
  const double t = world.time();
  const Vector3d expected =
      ball.pose.position + t * ball.velocity + Vector3d(0.0, 0.0, -0.5 * testing::kG * t * t);
  EXPECT_LT((testing::centre_of(world, 0) - expected).norm(), 1e-12);
}

void expect_refusal(const SceneBody& body, const std::string& words) {
  Scene scene;
  scene.bodies = {body};
  const Result<SceneWorld> world = SceneWorld::create(scene);
  ASSERT_FALSE(world) << words;
  EXPECT_EQ(world.error().kind, ErrorKind::kContent) << world.error().message;
  EXPECT_NE(world.error().message.find("'ball'"), std::string::npos) << world.error().message;
  EXPECT_NE(world.error().message.find(words), std::string::npos) << world.error().message;
}

TEST(RigidBodies, AreRefusedWithTheReason) {
  const SceneBody good = rigid_body("ball", SphereShape{0.1}, {0.0, 0.0, 0.0});
  const auto change = [&good](const auto& how) {
    SceneBody body = good;
    how(body);
    return body;
  };
  using Body = SceneBody;
  for (const double wrong : {0.0, -1.0, std::nan("")}) {
    expect_refusal(change([&](Body& b) { b.rigid->density = wrong; }), "density is");
    expect_refusal(change([&](Body& b) { b.rigid->density.reset(), b.rigid->mass = wrong; }),
                   "mass is");
    expect_refusal(change([&](Body& b) { b.rigid->shape = SphereShape{wrong}; }), "radius");
  }
  expect_refusal(change([](Body& b) { b.rigid->mass = 1.0; }), "leave one of them out");
  expect_refusal(change([](Body& b) { b.rigid->inertia = Vector3d(1.0, 1.0, 3.0); }),
                 "no solid has these moments");
  expect_refusal(change([](Body& b) { b.rigid->inertia = Vector3d(1.0, -1.0, 1.0); }),
                 "no solid has these moments");
  expect_refusal(change([](Body& b) { b.rigid->shape = PlaneShape{}; }), "a plane is not");
  expect_refusal(change([](Body& b) { b.rigid->mesh = "ball.obj"; }), "give one of the two");
  expect_refusal(change([](Body& b) { b.model = "ball.tremolo"; }), "leave the model out");
  expect_refusal(change([](Body& b) { b.kind = FrameKind::kDriven; }), "a rigid body is free");
  expect_refusal(change([](Body& b) { b.options.alpha = 1.0; }), "alpha, beta and damping-ratio");
  expect_refusal(change([](Body& b) { b.integrator = "verlet"; }), "integrator");
}

TEST(RigidBodies, NeedAClosedMesh) {
  testing::TemporaryFolder folder;
  const std::string file = folder.file("open.obj");
  std::ofstream(file) << "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\n";
  SceneBody body = rigid_body("ball", SphereShape{0.1}, {0.0, 0.0, 0.0});
  body.rigid->shape.reset();
  body.rigid->mesh = file;
  expect_refusal(body, "not closed: 3 edges");
  std::ofstream(file, std::ios::app) << "f 2 3 4\n";
  RigidSolid solid;
  solid.mesh = file;
  // A corner of a cube.
  EXPECT_NEAR(model_of(solid)->inertia()->mass, 1000.0 / 6.0, 1e-9);
}

}  // namespace
}  // namespace tremolo
