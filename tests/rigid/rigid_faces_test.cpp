// Rigid bodies that rest, or turn, on the insides of their faces.
#include <algorithm>
#include <fstream>
#include <numbers>
#include <random>

#include "tests/rigid/rigid_scene.h"
#include "tests/support/temporary_folder.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;
using testing::kG;
using testing::rigid_body;

// A prism of that many sides, as a drawing program writes it: no vertex inside a face.
std::string write_prism(const testing::TemporaryFolder& folder, int sides, double radius,
                        double half_height) {
  const std::string path = folder.file("prism" + std::to_string(sides) + ".obj");
  std::ofstream out(path);
  out.precision(17);
  for (const double z : {-half_height, half_height})
    for (int k = 0; k < sides; ++k)
      out << "v " << radius * std::cos(2.0 * std::numbers::pi * k / sides) << " "
          << radius * std::sin(2.0 * std::numbers::pi * k / sides) << " " << z << "\n";
  for (int k = 0; k < sides; ++k) {
    const int next = (k + 1) % sides;
    out << "f " << k + 1 << " " << next + 1 << " " << sides + next + 1 << " " << sides + k + 1
        << "\n";
  }
  out << "f";
  for (int k = sides; k > 0; --k) out << " " << k;
  out << "\nf";
  for (int k = 1; k <= sides; ++k) out << " " << sides + k;
  out << "\n";
  return path;
}

SceneCollider leg(const std::string& name, double radius, double angle) {
  SceneCollider leg;
  leg.name = name;
  leg.shape = CylinderShape{radius, 0.2};
  leg.pose.position = Vector3d(0.17 * std::cos(angle), 0.17 * std::sin(angle), 0.2);
  return leg;
}

// A table top of 30 cm radius and 4 cm thickness on three legs of 40 cm height.
Scene table(SceneBody top, double leg_radius) {
  Scene scene;
  scene.step = 2e-3;
  scene.duration = 10.0;
  scene.gravity.values = {{0.0, 0.0, -kG}};
  top.pose.position = Vector3d(0.0, 0.0, 0.421);
  scene.bodies = {std::move(top)};
  scene.colliders = {testing::floor_with(0.3)};
  for (int k = 0; k < 3; ++k)
    scene.colliders.push_back(
        leg("leg" + std::to_string(k), leg_radius, 0.3 + 2.0 * std::numbers::pi * k / 3.0));
  return scene;
}

// Three legs carry the weight, and nothing else does.
void expect_on_legs(const Scene& scene) {
  SceneWorld world = testing::make_world(scene);
  testing::run_until(world, 0.6);
  Vector3d before = Vector3d::Zero();
  for (std::size_t c = 1; c < 4; ++c) before += world.collider_impulse(0, c);
  testing::run_until(world, 0.8);
  EXPECT_NEAR(testing::centre_of(world, 0).z(), 0.42, 1e-3);
  Vector3d carried = -before;
  for (std::size_t c = 1; c < 4; ++c) carried += world.collider_impulse(0, c);
  const double weight = kG * world.body(0).model().inertia()->mass;
  EXPECT_NEAR(carried.z(), -0.2 * weight, 1e-3 * weight);
  EXPECT_EQ(world.collider_impulse(0, 0), Vector3d(Vector3d::Zero()));
}

TEST(RigidFaces, ARoundTableStandsOnItsLegs) {
  for (const double radius : {0.08, 0.05}) {
    SCOPED_TRACE(radius);
    const SceneBody top = rigid_body("top", CylinderShape{0.3, 0.02}, Vector3d::Zero());
    expect_on_legs(table(top, radius));
  }
}

// Of four sides and of 48; with the shape of the solid and without.
TEST(RigidFaces, ATableTopOfAMeshStandsOnItsLegs) {
  testing::TemporaryFolder folder;
  for (const int sides : {4, 48})
    for (const bool shaped : {false, true}) {
      SCOPED_TRACE(std::to_string(sides) + (shaped ? " with a shape" : ""));
      SceneBody top = rigid_body("top", CylinderShape{0.3, 0.02}, Vector3d::Zero());
      if (shaped) top.contact.shape = top.rigid->shape;
      top.rigid->shape.reset();
      top.rigid->mesh = write_prism(folder, sides, 0.3, 0.02);
      expect_on_legs(table(std::move(top), 0.08));
    }
}

TEST(RigidFaces, ABarrelLiesOnTwoRails) {
  Scene scene;
  scene.step = 2e-3;
  scene.duration = 10.0;
  scene.gravity.values = {{0.0, 0.0, -kG}};
  scene.bodies = {rigid_body("barrel", CylinderShape{0.1, 0.2}, {0.0, 0.0, 0.201})};
  scene.bodies[0].pose.rotation =
      Eigen::AngleAxisd(0.5 * std::numbers::pi, Vector3d::UnitX()) * Eigen::Quaterniond::Identity();
  scene.colliders = {testing::floor_with(0.3)};
  for (const double side : {-1.0, 1.0}) {
    SceneCollider rail;
    rail.name = side < 0.0 ? "left" : "right";
    rail.shape = BoxShape{{0.5, 0.05, 0.05}};
    rail.pose.position = Vector3d(0.0, 0.07 * side, 0.05);
    scene.colliders.push_back(rail);
  }
  SceneWorld world = testing::make_world(scene);
  testing::run_until(world, 0.8);
  EXPECT_NEAR(testing::centre_of(world, 0).z(), 0.2, 2e-3);
}

// The deceleration of a disc that spins flat on the floor, over that of an even pressure: friction
// brakes it by 2/3 mu m g R, that is by 4/3 mu g/R.
double braking(int points) {
  constexpr double kRadius = 0.05, kFriction = 0.3;
  SceneBody disc = rigid_body("disc", CylinderShape{kRadius, 0.01}, {0.0, 0.0, 0.01});
  disc.spin = Vector3d(0.0, 0.0, 30.0);
  disc.contact.friction = kFriction;
  if (points > 0) disc.contact.points = points;
  SceneWorld world = testing::make_world(testing::on_slope(disc, 0.0, kFriction, 1e-3));
  testing::run_until(world, 0.05);
  const double before = world.body(0).rigid_state().spin.z();
  testing::run_until(world, 0.25);
  const double rate = (before - world.body(0).rigid_state().spin.z()) / 0.2;
  return rate / (4.0 / 3.0 * kFriction * kG / kRadius);
}

// The rim's points stand also for the side next to them, so that the error falls as the spacing.
TEST(RigidFaces, ASpinningDiscIsBrakedByAnEvenPressure) {
  EXPECT_NEAR(braking(0), 1.0, 0.12);
  EXPECT_NEAR(braking(1000), 1.0, 0.08);
  EXPECT_NEAR(braking(5000), 1.0, 0.04);
}

// A box or a cylinder that tumbles; one of 24 pairs.
SceneBody tumbler(const std::string& name, std::mt19937& random) {
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  const Collider shape = any(random) < 0.0 ? Collider(BoxShape{{0.05, 0.05, 0.05}})
                                           : Collider(CylinderShape{0.05, 0.05});
  SceneBody body = rigid_body(name, shape, Vector3d::Zero());
  body.contact.friction = 0.0;
  body.contact.restitution = 1.0;
  body.pose.rotation =
      Eigen::Quaterniond(any(random), any(random), any(random), any(random)).normalized();
  body.spin = 5.0 * Vector3d(any(random), any(random), any(random));
  return body;
}

// Points that were pressed in next to an edge slide over it before they are out. Their energy goes
// back to the bodies, whatever the step and the number of points.
TEST(RigidFaces, HitsAtEdgesKeepTheirEnergy) {
  for (const auto& [step, points] : {std::pair{4e-3, 200}, {1e-3, 200}, {1e-3, 1000}}) {
    SCOPED_TRACE(std::to_string(step) + " s, " + std::to_string(points));
    std::mt19937 random(5);
    double sum = 0.0, most = 0.0;
    for (int k = 0; k < 24; ++k) {
      Scene scene;
      scene.step = step;
      scene.duration = 0.6;
      scene.bodies = {tumbler("a", random), tumbler("b", random)};
      std::uniform_real_distribution<double> aside(-0.07, 0.07);
      scene.bodies[0].pose.position = Vector3d(-0.3, aside(random), aside(random));
      scene.bodies[0].velocity = Vector3d::UnitX();
      for (SceneBody& body : scene.bodies) body.contact.points = points;
      SceneWorld world = testing::make_world(scene);
      const double before = world.account(0).total() + world.account(1).total();
      testing::run_until(world, 0.6);
      const double after = world.account(0).total() + world.account(1).total();
      EXPECT_GT(std::abs(world.account(0).contact_given), 1e-6) << "pair " << k << " does not meet";
      most = std::max(most, (before - after) / before);
      sum += (before - after) / before;
      EXPECT_LT(after, before * (1.0 + 1e-9));
    }
    EXPECT_LT(sum / 24.0, 0.005);
    EXPECT_LT(most, 0.05);
  }
}

}  // namespace
}  // namespace tremolo
