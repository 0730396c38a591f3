// Joints that carry far more than the masses of the links that they join.
#include <numbers>

#include "runtime/scene/joint_loads.h"
#include "tests/rigid/rigid_scene.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;
using testing::kG;
using testing::rigid_body;

constexpr int kLinks = 8;
constexpr double kLink = 0.1;  // m, from joint to joint

// Links of 10 g along `along`, the last heavier by that ratio, from the origin on.
Scene chain(const Vector3d& along, double ratio, double step) {
  Scene scene;
  scene.step = step;
  scene.duration = 100.0;
  scene.gravity.values = {{0.0, 0.0, -kG}};
  for (int k = 0; k < kLinks; ++k) {
    SceneBody link = rigid_body("link-" + std::to_string(k), CapsuleShape{0.01, 0.04},
                                (k + 0.5) * kLink * along);
    link.rigid->density.reset();
    link.rigid->mass = k + 1 == kLinks ? 0.01 * ratio : 0.01;
    link.pose.rotation = Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), along);
    scene.bodies.push_back(link);
    SceneJoint joint;
    joint.body = link.name;
    joint.at = "near:0,0,-0.05";
    if (k > 0) joint.to = "link-" + std::to_string(k - 1);
    scene.joints.push_back(joint);
  }
  return scene;
}

constexpr double kLoadSteps[] = {1.0 / 60.0, 3e-3, 1e-3};
constexpr double kRatios[] = {1e3, 1e4, 1e5, 1e6};

// Each joint is at most g h^2/9 longer, whatever it carries, plus that of light links.
TEST(JointLoads, AHangingWeightExtendsTheChainLittle) {
  for (const double ratio : kRatios)
    for (const double step : kLoadSteps) {
      SCOPED_TRACE(std::to_string(ratio) + " at " + std::to_string(step));
      SceneWorld world = testing::make_world(chain(-Vector3d::UnitZ(), ratio, step));
      testing::run_until(world, 1.0);
      const double extension = -(kLinks - 0.5) * kLink - testing::centre_of(world, kLinks - 1).z();
      const double exact = kLinks * kG * step * step / 9.0;
      EXPECT_NEAR(extension, exact, 0.02 * exact + 1e-9);
    }
}

// It swings from the horizontal: the pull of a pendulum is three weights, and no part of the way
// is longer than at that pull, with as much again for the jerks.
TEST(JointLoads, AHeavyEndSwingsOnAChainOfLightLinks) {
  for (const double ratio : kRatios)
    for (const double step : kLoadSteps) {
      SCOPED_TRACE(std::to_string(ratio) + " at " + std::to_string(step));
      SceneWorld world = testing::make_world(chain(Vector3d::UnitX(), ratio, step));
      double farthest = 0.0;
      testing::Growth growth;
      testing::run_until(world, 1.5, [&] {
        farthest = std::max(farthest, testing::centre_of(world, kLinks - 1).norm());
        growth.look(world);
      });
      const double weight = kLinks * kG * step * step / 9.0;
      EXPECT_LT(farthest, (kLinks - 0.5) * kLink + 6.0 * weight);
      EXPECT_LT(growth.worst, 1e-8 * growth.most);
    }
}

// Ratios of up to ten and more links keep the spring of their own masses.
TEST(JointLoads, LightLoadsChangeNothing) {
  const Scene scene = chain(-Vector3d::UnitZ(), 1.0, 1e-3);
  const SceneWorld world = testing::make_world(scene);
  const ContactBody &one = world.body(1), &other = world.body(0);
  const Joint* joint = world.joint(1);
  const double mass = 1.0 / (1.0 / one.mass_at(joint->first) + 1.0 / other.mass_at(joint->second));
  EXPECT_EQ(joint->stiffness, 900.0 * mass / (1e-3 * 1e-3));
}

TEST(JointLoads, AreTheMassesThatHangOnTheJoint) {
  // world - a - b - c, and d - e without a support; a ring of f, g and h.
  const auto joint = [](const std::string& body, const std::string& to) {
    SceneJoint made;
    made.body = body;
    made.to = to;
    return made;
  };
  std::vector<SceneJoint> joints = {joint("a", ""),  joint("b", "a"),    joint("c", "b"),
                                    joint("d", "e"), joint("f", "g"),    joint("g", "h"),
                                    joint("h", "f"), joint("wall", "i"), joint("i", "")};
  const JointLoads loads(joints, [](const std::string& name) {
    CarriedBody body{.mass = std::pow(2.0, name[0] - 'a'), .moves = name != "wall"};
    return body;
  });
  EXPECT_EQ(loads.of(0), 1.0 + 2.0 + 4.0);
  EXPECT_EQ(loads.of(1), 2.0 + 4.0);
  EXPECT_EQ(loads.of(2), 4.0);
  EXPECT_EQ(loads.of(3), 8.0);
  EXPECT_EQ(loads.of(4), 32.0 + 64.0 + 128.0);
  EXPECT_EQ(loads.of(7), 256.0);  // between two supports
  EXPECT_EQ(loads.of(8), 256.0);
}

}  // namespace
}  // namespace tremolo
