// Bodies on bones in scenes: their chains, energy balance, welds, refusals.
#include <algorithm>
#include <cmath>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "runtime/world/scene_world.h"
#include "tests/support/frames/rigged_model.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

SwingMotion swing(const Vector3d& axis, double amplitude) {
  return {.axis = axis,
          .amplitude = amplitude,
          .frequency = 1.5,
          .phase = 0.4,
          .course = {.start = 0.1, .ramp = 0.3}};
}

// An arm of three bones that swings on a cart.
Scene arm_scene() {
  Scene scene;
  scene.duration = 1.0;
  scene.gravity.values = {{0.0, 0.0, -9.81}};
  SceneBody body;
  body.name = body.model = "arm";
  body.kind = FrameKind::kDriven;
  body.options.beta = 1e-3;
  body.pose = {{0.5, -0.2, 1.0}, turn_by({0.1, 0.2, 0.3})};
  body.motion.parts = {GlideMotion{{0.3, 0.0, 0.1}, {.start = 0.2, .ramp = 0.3}}};
  const std::vector<BoneSegment> bones = testing::bar_bones();
  const char* names[] = {"upper", "lower", "hand"};
  for (std::size_t b = 0; b < 3; ++b) {
    SceneBone bone;
    bone.name = names[b];
    bone.head = bones[b].head;
    bone.tail = bones[b].tail;
    if (b > 0) bone.parent = names[b - 1];
    bone.motion.parts = {swing(Vector3d::Unit(static_cast<Eigen::Index>(b)), 0.3)};
    body.bones.push_back(bone);
  }
  body.bone_blend = 0.08;
  SceneLoad load;
  load.signal = {.kind = SignalKind::kSine};
  body.loads = {load};
  scene.bodies = {body};
  return scene;
}

class SceneBones : public ::testing::Test {
 protected:
  Result<SceneWorld> try_world(const Scene& scene) const {
    return SceneWorld::create(
        scene, [this](const SceneBody&) { return Result<Model::Pointer>(bar_.model); });
  }
  SceneWorld world_of(const Scene& scene) const {
    Result<SceneWorld> world = try_world(scene);
    EXPECT_TRUE(world) << (world ? "" : world.error().message);
    return std::move(*world);
  }
  void expect_refused(const Scene& scene, const std::string& words) const {
    const Result<SceneWorld> world = try_world(scene);
    ASSERT_FALSE(world) << words;
    EXPECT_NE(world.error().message.find(words), std::string::npos) << world.error().message;
    EXPECT_EQ(world.error().kind, ErrorKind::kContent);
  }

  testing::RiggedBar bar_ = testing::rigged_bar(5);
};

TEST_F(SceneBones, AccountClosesAndEveryCauseIsTold) {
  for (const char* method : {"avf", "ep2", "ep4"}) {
    Scene scene = arm_scene();
    scene.bodies[0].integrator = method;
    SceneWorld world = world_of(scene);
    double most = 0.0;
    for (int k = 0; k < 600; ++k) {
      ASSERT_TRUE(world.step().empty());
      const EnergyAccount account = world.account(0);
      most = std::max(most, account.total());
      ASSERT_LE(std::abs(account.remainder()), 1e-12 * most) << method << k;
    }
    const EnergyAccount account = world.account(0);
    EXPECT_GT(std::abs(account.support), 1e-3 * most);
    EXPECT_GT(std::abs(account.gravity), 1e-3 * most);
    EXPECT_GT(std::abs(account.load), 1e-6 * most);
    EXPECT_LT(account.damping, 0.0);
  }
}

// A box that is welded to the arm; a saved world continues with the same bits.
TEST_F(SceneBones, AWeldClosesTheAccountsAndIsRestored) {
  Scene scene = arm_scene();
  SceneBody box;
  box.name = "box";
  box.kind = FrameKind::kFree;
  box.rigid = RigidSolid{BoxShape{{0.03, 0.02, 0.01}}, {}, 0.3, {}, {}};
  box.pose.position = {1.0, -0.1, 1.1};
  scene.bodies.push_back(box);
  SceneJoint weld;
  weld.weld = true;
  weld.body = "box";
  weld.at = "x<-0.02";
  weld.to = "arm";
  weld.gap = 1.0;
  scene.joints = {weld};
  SceneWorld whole = world_of(scene), other = world_of(scene);
  double most = 0.0;
  for (int k = 0; k < 300; ++k) {
    ASSERT_TRUE(whole.step().empty());
    if (k < 40) {
      ASSERT_TRUE(other.step().empty());
    }
    for (std::size_t i = 0; i < 2; ++i) {
      most = std::max(most, std::abs(whole.account(i).total()));
      ASSERT_LE(std::abs(whole.account(i).remainder()), 1e-8 * most) << k;
    }
    if (k == 120) {
      const Status restored = other.restore(whole.save());
      ASSERT_TRUE(restored) << restored.error().message;
    }
    if (k > 120) {
      ASSERT_TRUE(other.step().empty());
    }
  }
  EXPECT_TRUE(whole.save() == other.save());
  EXPECT_GT(std::abs(whole.account(1).joint), 1e-3 * most);
  EXPECT_GT(whole.joint(0)->force.norm(), 0.1);
}

TEST_F(SceneBones, ChainIsTheProductOfTheTurnsAboutTheHeads) {
  const Scene scene = arm_scene();
  SceneWorld world = world_of(scene);
  for (int k = 0; k < 200; ++k) ASSERT_TRUE(world.step().empty());
  const double t = world.time();
  const SceneBody& body = scene.bodies[0];
  const Pose root = MotionPath::create(body.motion, body.pose)->pose(t);
  Eigen::Isometry3d chain = Eigen::Translation3d(root.position) * root.rotation;
  for (std::size_t b = 0; b < 3; ++b) {
    const Pose own = MotionPath::create(body.bones[b].motion)->pose(t);
    EXPECT_GT(turn_of(own.rotation).norm(), 0.01);
    chain = chain * Eigen::Translation3d(body.bones[b].head) * own.rotation *
            Eigen::Translation3d(-body.bones[b].head);
    const Pose& bone = world.body(0).pose(b);
    EXPECT_LE((bone.position - chain.translation()).norm(), 1e-14);
    EXPECT_LE((bone.rotation.toRotationMatrix() - chain.rotation()).norm(), 1e-14);
    // A joint holds together.
    if (b > 0) {
      const Vector3d joint = body.bones[b].head;
      EXPECT_LE((bone * joint - world.body(0).pose(b - 1) * joint).norm(), 1e-14);
    }
  }
}

TEST_F(SceneBones, OneBoneThatDoesNotMoveByItselfIsADrivenBody) {
  Scene boned = arm_scene(), driven = arm_scene();
  boned.bodies[0].bones.resize(1);
  boned.bodies[0].bones[0].head.setZero();
  boned.bodies[0].bones[0].motion = {};
  driven.bodies[0].bones.clear();
  for (Scene* scene : {&boned, &driven}) scene->bodies[0].settled = true;
  SceneWorld one = world_of(boned), other = world_of(driven);
  for (int k = 0; k < 200; ++k) {
    ASSERT_TRUE(one.step().empty());
    ASSERT_TRUE(other.step().empty());
  }
  const Eigen::VectorXd& q = other.body(0).state().q;
  EXPECT_GT(q.norm(), 1e-3);
  EXPECT_LE((one.body(0).state().q - q).norm(), 1e-12 * q.norm());
  EXPECT_LE((one.momenta(0).linear - other.momenta(0).linear).norm(), 1e-10);
  EXPECT_LE((one.momenta(0).angular - other.momenta(0).angular).norm(), 1e-10);
}

TEST_F(SceneBones, SettledBodyStaysWhereGravityHoldsItOnItsBentBones) {
  Scene scene = arm_scene();
  SceneBody& body = scene.bodies[0];
  body.motion = {};
  body.loads.clear();
  body.settled = true;
  for (SceneBone& bone : body.bones)
    bone.motion.parts = {KeyframeMotion{{{0.0, {{0.0, 0.0, 0.0}, turn_by({0.0, 0.4, 0.1})}}}}};
  SceneWorld world = world_of(scene);
  const Eigen::VectorXd q = world.body(0).state().q;
  EXPECT_GT(q.norm(), 1e-3);
  for (int k = 0; k < 200; ++k) ASSERT_TRUE(world.step().empty());
  EXPECT_LE((world.body(0).state().q - q).norm(), 1e-8 * q.norm());
}

TEST_F(SceneBones, MomentumOfStandingSharesIsTheMassTimesTheirVelocities) {
  // All bones move equally: the linear momentum is the mass times the velocity, and the vibration.
  Scene scene = arm_scene();
  for (SceneBone& bone : scene.bodies[0].bones) bone.motion = {};
  SceneWorld bones = world_of(scene);
  scene.bodies[0].bones.clear();
  SceneWorld driven = world_of(scene);
  for (int k = 0; k < 300; ++k) {
    ASSERT_TRUE(bones.step().empty());
    ASSERT_TRUE(driven.step().empty());
  }
  EXPECT_GT(driven.momenta(0).linear.norm(), 1.0);
  EXPECT_LE((bones.momenta(0).linear - driven.momenta(0).linear).norm(), 1e-9);
  EXPECT_LE((bones.momenta(0).angular - driven.momenta(0).angular).norm(), 1e-9);
}

TEST_F(SceneBones, RefusesBonesThatAreNone) {
  const auto with = [&](const auto& change) {
    Scene changed = arm_scene();
    change(changed.bodies[0].bones);
    return changed;
  };
  using Bones = std::vector<SceneBone>;
  expect_refused(with([](Bones& b) { b[1].parent = "shoulder"; }),
                 "body 'arm': bone 'lower': parent: there is no bone 'shoulder' before it");
  expect_refused(with([](Bones& b) { b[0].parent = "hand"; }), "there is no bone 'hand' before it");
  expect_refused(with([](Bones& b) { b[2].name = "upper"; }), "two bones are named 'upper'");
  expect_refused(with([](Bones& b) { b[2].name = ""; }), "a bone has no name");
  expect_refused(with([](Bones& b) { b[1].tail.y() = NAN; }),
                 "bone 'lower': its head or tail is not finite");
  Scene scene = arm_scene();
  scene.bodies[0].motion = {};
  scene.bodies[0].kind = FrameKind::kFixed;
  expect_refused(scene, "bones carry a driven body only");
  scene = arm_scene();
  scene.bodies[0].bone_weights = BoneWeights::Ones(4, 2);
  expect_refused(scene, "bone-weights: there are 2 columns for 3 bones");
  scene.bodies[0].bone_weights = BoneWeights::Constant(4, 3, 0.5);
  expect_refused(scene, "bone-weights: row 1: the weights sum to 1.5");
  scene.bodies[0].bone_weights = BoneWeights::Constant(4, 3, 1.0 / 3.0);
  expect_refused(scene, "bone-weights: there are weights of 4 vertices; the model draws");
  scene = arm_scene();
  Keyframe start, before{0.5, {}}, after{0.5, {}};
  after.pose.position.x() = 0.1;
  scene.bodies[0].bones[1].motion.parts = {KeyframeMotion{{start, before, after}}};
  expect_refused(scene, "bone 'lower': its motion jumps at t = 0.5 s");
  scene = arm_scene();
  start.pose.rotation.w() = 1.1;
  scene.bodies[0].bones[1].motion.parts = {KeyframeMotion{{start}}};
  expect_refused(scene, "bone 'lower': part 1 of the motion: key 1: the quaternion is of length");
  scene = arm_scene();
  scene.bodies[0].acceleration_limit = 5.0;
  expect_refused(scene, "bone 'hand': its motion accelerates it");
}

TEST_F(SceneBones, AnArmOnBonesMeetsAFloorAndAHandAndItsAccountCloses) {
  Scene scene = arm_scene();
  scene.bodies[0].integrator = "ep4";
  SceneCollider floor;
  floor.name = "floor";
  floor.pose.position.z() = 0.85;
  scene.colliders = {floor};
  scene.hands.resize(1);
  scene.hands[0].body = "arm";
  scene.hands[0].at = "near:0.6,0,0.12";
  scene.hands[0].stiffness = 10.0;
  SceneWorld world = world_of(scene);
  double most = 0.0, pushed = 0.0;
  for (int k = 0; k < 600; ++k) {
    ASSERT_TRUE(world.step().empty());
    const EnergyAccount account = world.account(0);
    most = std::max(most, account.total());
    pushed += world.body(0).contact_account().impulse;
    ASSERT_LE(std::abs(account.remainder()), 1e-9 * most) << k;
  }
  EXPECT_GT(pushed, 0.1);
  EXPECT_NE(world.body(0).contact_sums().hand, 0.0);
  // Without contact the scene has another motion.
  scene.bodies[0].feels_contact = false;
  scene.hands.clear();
  EXPECT_TRUE(try_world(scene));
}

TEST_F(SceneBones, RaysFindTheArmAndTheBodyBesideIt) {
  Scene scene = arm_scene();
  SceneBody straight = scene.bodies[0];
  straight.name = "straight";
  straight.bones.clear();
  straight.pose.position += Vector3d(0.0, 3.0, 0.0);
  scene.bodies.push_back(straight);
  SceneWorld world = world_of(scene);
  for (int k = 0; k < 100; ++k) ASSERT_TRUE(world.step().empty());
  for (std::size_t i = 0; i < 2; ++i) {
    const ContactBody& body = world.body(i);
    std::vector<double> places(3 * body.model().drawn().rest.size());
    ASSERT_TRUE(body.surface_positions(std::span<double>(places)));
    Eigen::Matrix3d corners;
    for (std::size_t k = 0; k < 3; ++k)
      corners.col(k) = Vector3d::Map(&places[3 * body.model().drawn().triangles[0][k]]);
    const Vector3d middle = corners.rowwise().mean();
    const Vector3d normal =
        (corners.col(1) - corners.col(0)).cross(corners.col(2) - corners.col(0)).normalized();
    const auto hit = world.pick(middle + 1e-3 * normal, -normal);
    ASSERT_TRUE(hit) << hit.error().message;
    ASSERT_TRUE(*hit);
    EXPECT_EQ((*hit)->body, i);
    EXPECT_EQ((*hit)->hit.place.triangle, 0U);
    EXPECT_LE(((*hit)->hit.point - middle).norm(), 1e-13);
    EXPECT_NEAR((*hit)->hit.distance, 1e-3, 1e-13);
  }
}

TEST(SwingMotion, TurnsToAndFroAboutItsPoint) {
  SwingMotion part = swing(Vector3d::UnitY(), 0.5);
  part.about = {0.1, 0.2, 0.3};
  Motion motion;
  motion.parts = {part};
  const MotionPath path = *MotionPath::create(motion);
  EXPECT_EQ(path.pose(0.05).rotation.vec().norm(), 0.0);
  for (const double t : {0.5, 0.77, 1.9}) {
    const double angle = 0.5 * std::sin(2.0 * M_PI * 1.5 * (t - 0.1) + 0.4);
    EXPECT_LE((turn_of(path.pose(t).rotation) - Vector3d(0.0, angle, 0.0)).norm(), 1e-14);
    EXPECT_LE((path.pose(t) * part.about - part.about).norm(), 1e-15);
  }
  part.course.ramp = 0.0;
  EXPECT_NE(part_problem(part).find("a start and a ramp"), std::string::npos);
  part.frequency = 0.0;
  EXPECT_NE(part_problem(part).find("frequency"), std::string::npos);
}

}  // namespace
}  // namespace tremolo
