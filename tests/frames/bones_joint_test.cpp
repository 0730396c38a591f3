// Joints and welds of bodies on several bones: agreement with a driven frame, weights, energy and
// the work of the bones, pairs on bones, saved states.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "runtime/bodies/reduced/rigid/rigid_solid.h"
#include "runtime/contact/islands/body_group.h"
#include "runtime/math/motion.h"
#include "runtime/scene/welds.h"
#include "tests/support/frames/rigged_model.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;
using testing::bar_skin;
using testing::make_framed;
using testing::make_rigged;
using testing::rigged_bar;
using testing::RiggedBar;

constexpr double kBoneStep = 1e-3;

const RiggedBar& joined_bar() {
  static const RiggedBar made = rigged_bar(5);
  return made;
}

IntegratorOptions bone_options() {
  return {.step = kBoneStep, .beta = 1e-3, .tolerance = 1e-12, .max_iterations = 60};
}

// The bar of 0.6 m along x, on bones or in one frame.
ContactBody joinable_bar(bool bones) {
  ContactBody body =
      bones ? make_rigged(joined_bar().model, bar_skin(joined_bar()), bone_options())
            : make_framed(joined_bar().model, FrameKind::kDriven, bone_options(), "ep4");
  EXPECT_TRUE(body.set_contact({.points = 20, .colliders = false}));
  return body;
}

ContactBody box_at(const Vector3d& place, double mass) {
  const Collider box = BoxShape{{0.03, 0.02, 0.01}};
  const Result<Model::Pointer> model =
      make_rigid_model({.shape = box, .mesh = {}, .mass = mass, .density = {}, .inertia = {}});
  ContactBody body =
      std::move(*ContactBody::create(*model, "ep4", bone_options(), FrameKind::kFree));
  EXPECT_TRUE(body.set_contact({.colliders = false}));
  EXPECT_TRUE(body.set_pose({place, Eigen::Quaterniond::Identity()}));
  return body;
}

// The vertex of the bar that is nearest to a position at rest.
VertexId bar_vertex(const Vector3d& where) {
  const VertexBlock& boundary = joined_bar().model->surface();
  std::size_t nearest = 0;
  for (std::size_t i = 0; i < boundary.rest.size(); ++i)
    if ((boundary.rest[i] - where).norm() < (boundary.rest[nearest] - where).norm()) nearest = i;
  return boundary.vertex_ids[nearest];
}

// Two bodies and the joints from the second to the first.
struct JoinedPair {
  ContactBody bar, other;
  BodyGroup group = {};
  std::vector<std::size_t> numbers = {};

  void join(const std::vector<Joint>& joints) {
    for (const Joint& joint : joints) numbers.push_back(group.join(1, 0, joint));
  }
  void step() {
    ContactBody* const bodies[] = {&bar, &other};
    StepReport reports[2];
    group.step(bodies, {}, reports);
    EXPECT_TRUE(reports[0].converged && reports[1].converged);
  }
  Joint sum() const {
    Joint all;
    for (const std::size_t number : numbers) add_joint(all, *group.joint(number));
    return all;
  }
};

enum class Kind { kStiff, kSpring, kString, kWeld };
constexpr Kind kKinds[] = {Kind::kStiff, Kind::kSpring, Kind::kString, Kind::kWeld};

// Joints of a body to the bar; `at`: a vertex of the bar.
std::vector<Joint> joints_of(Kind kind, const ContactBody& other, const ContactBody& bar,
                             VertexId at) {
  const std::vector<VertexId>& own = other.model().surface().vertex_ids;
  if (kind == Kind::kWeld) {
    Result<std::vector<Joint>> weld =
        make_weld(other, std::vector(own.begin(), own.begin() + 4), bar, {}, {}, 1.0);
    EXPECT_TRUE(weld) << (weld ? "" : weld.error().message);
    return std::move(*weld);
  }
  Result<Joint> joint =
      kind == Kind::kStiff ? make_joint(other, own[0], bar)
      : kind == Kind::kSpring
          ? make_joint(other, own[0], bar, at, {.stiffness = 300.0})
          : make_joint(other, own[0], bar, at, {.stiffness = 2e3, .damping = 1.0, .length = 0.1});
  EXPECT_TRUE(joint) << (joint ? "" : joint.error().message);
  return {std::move(*joint)};
}

// Rises and falls, and turns about an inclined axis.
MotionPath swinging() {
  Motion motion;
  motion.parts.push_back(
      ShakeMotion{{0.01, 0.0, 0.06}, 2.0, {.start = 0.0, .end = 9.0, .ramp = 0.1}});
  motion.parts.push_back(SwingMotion{.axis = {0.2, 1.0, 0.1},
                                     .amplitude = 0.3,
                                     .frequency = 1.5,
                                     .course = {.start = 0.0, .ramp = 0.1}});
  return *MotionPath::create(motion, {{0.0, 0.0, 0.05}, turn_by({0.0, 0.3, 0.2})});
}

void move_bone(const MotionPath& path, std::size_t bone, ContactBody& body) {
  const double h = kBoneStep, t = body.time();
  const FrameMotion motion =
      motion_between(path.pose(t - h), path.pose(t), path.pose(t + h), path.pose(t + 2 * h), h);
  ASSERT_TRUE(body.move_to(path.pose(t + h), motion, bone));
}

// The elbow of the bar's bones is bent at x = 0.2, and back at x = 0.4.
std::vector<Pose> bent_arm(double angle) {
  const Eigen::Quaterniond turn = turn_by({0.0, -angle, 0.0});
  const Vector3d elbow(0.2, 0.05, 0.06), wrist(0.4, 0.05, 0.06);
  const Pose middle{elbow - turn * elbow, turn};
  return {{}, middle, {middle * wrist - wrist, Eigen::Quaterniond::Identity()}};
}

void bend(double angle, ContactBody& bar) {
  const std::vector<Pose> poses = bent_arm(angle);
  for (std::size_t b = 0; b < poses.size(); ++b) ASSERT_TRUE(bar.set_pose(poses[b], b));
}

TEST(BonesJoint, BonesThatMoveTogetherAreADrivenFrame) {
  const MotionPath path = swinging();
  const VertexId at = bar_vertex({0.4, 0.05, 0.12});
  for (const Kind kind : kKinds) {
    SCOPED_TRACE(static_cast<int>(kind));
    JoinedPair pairs[] = {{joinable_bar(false), box_at({0.4, 0.1, 0.1}, 0.5)},
                          {joinable_bar(true), box_at({0.4, 0.1, 0.1}, 0.5)}};
    for (JoinedPair& pair : pairs) {
      ASSERT_TRUE(pair.bar.set_pose(path.pose(0.0), kAllBones));
      for (ContactBody* body : {&pair.bar, &pair.other})
        ASSERT_TRUE(body->set_gravity({0.0, 0.0, -9.81}));
      pair.join(joints_of(kind, pair.other, pair.bar, at));
    }
    double most = 0.5 * 9.81;
    for (int k = 0; k < 300; ++k) {
      for (JoinedPair& pair : pairs) {
        move_bone(path, kAllBones, pair.bar);
        pair.step();
      }
      const RigidState one = pairs[0].other.rigid_state(), two = pairs[1].other.rigid_state();
      ASSERT_LE((one.centre - two.centre).norm(), 1e-9) << k;
      const Vector3d force = pairs[0].sum().force;
      most = std::max(most, force.norm());
      ASSERT_LE((force - pairs[1].sum().force).norm(), 1e-7 * most) << k;
    }
    const Eigen::VectorXd& q = pairs[0].bar.state().q;
    EXPECT_LE((pairs[1].bar.state().q - q).norm(), 1e-8 * q.norm());
    EXPECT_NEAR(pairs[0].bar.contact_sums().joint, pairs[1].bar.contact_sums().joint,
                1e-8 * std::abs(pairs[0].bar.contact_sums().joint));
    EXPECT_GT(std::abs(pairs[0].bar.contact_sums().joint), 1e-4);
  }
}

// A weight hangs on a bent arm: the joint carries it, and the arm is bent as by that force.
TEST(BonesJoint, AWeightOnASpringBendsTheArmAsItsForceDoes) {
  constexpr double kWeight = 0.2 * 9.81;
  for (const double x : {0.2, 0.4, 0.55}) {
    SCOPED_TRACE(x);
    const VertexId at = bar_vertex({x, 0.05, 0.0});
    ContactBody pushed = joinable_bar(true);
    bend(0.6, pushed);
    const Vector3d below = *pushed.position(at) - Vector3d(0.0, 0.0, kWeight / 200.0);
    JoinedPair pair{joinable_bar(true), box_at(below, 0.2)};
    bend(0.6, pair.bar);
    for (ContactBody* body : {&pair.bar, &pair.other, &pushed})
      ASSERT_TRUE(body->set_damping(30.0, 1e-3));
    ASSERT_TRUE(pair.other.set_gravity({0.0, 0.0, -9.81}));
    Joint joint;
    joint.first.rows.setZero(3, pair.other.model().modes());
    joint.second = *vertex_place(pair.bar, at);
    joint.stiffness = 200.0;
    joint.damping = 6.0;
    pair.join({joint});
    ASSERT_TRUE(pushed.apply_force(at, {0.0, 0.0, -kWeight}, 5000));
    for (int k = 0; k < 5000; ++k) {
      pair.step();
      ASSERT_TRUE(pushed.step().converged);
    }
    EXPECT_LE((pair.sum().force - Vector3d(0.0, 0.0, kWeight)).norm(), 1e-6 * kWeight);
    const double stretch =
        place_now(pair.bar, joint.second).z() - pair.other.rigid_state().centre.z();
    EXPECT_NEAR(stretch, kWeight / 200.0, 1e-6 * stretch);
    EXPECT_LE((pair.bar.state().q - pushed.state().q).norm(), 1e-5 * pushed.state().q.norm());
  }
}

// Bones that turn against each other: opposite impulses; the work on each of the two is its own
// energy; the joint's own energy follows from the positions of its ends.
TEST(BonesJoint, KeepsTheEnergyWithTheWorkOfTheBones) {
  const MotionPath path = swinging();
  for (const Kind kind : {Kind::kSpring, Kind::kString, Kind::kStiff, Kind::kWeld}) {
    SCOPED_TRACE(static_cast<int>(kind));
    JoinedPair pair{joinable_bar(true), box_at({0.42, 0.1, 0.15}, 0.5)};
    bend(0.4, pair.bar);
    ASSERT_TRUE(pair.bar.set_pose(path.pose(0.0), 2));
    pair.join(joints_of(kind, pair.other, pair.bar, bar_vertex({0.4, 0.05, 0.12})));
    Vector3d momentum = Vector3d::Zero();
    double most = 0.0, paid = 0.0, stored = 0.0;
    std::vector<Vector3d> apart;
    const auto separations = [&pair] {
      std::vector<Vector3d> now;
      for (const std::size_t number : pair.numbers) {
        const Joint& joint = *pair.group.joint(number);
        now.push_back(place_now(pair.other, joint.first) - place_now(pair.bar, joint.second));
      }
      return now;
    };
    apart = separations();
    const Joint& first = *pair.group.joint(pair.numbers.front());
    for (std::size_t i = 0; i < apart.size(); ++i) {
      const Joint& joint = *pair.group.joint(pair.numbers[i]);
      stored += 0.5 * joint.stiffness * std::pow(apart[i].norm() - joint.length, 2);
    }
    ASSERT_FALSE(first.second.bones.empty());
    for (int k = 0; k < 400; ++k) {
      move_bone(path, 2, pair.bar);
      pair.step();
      const Joint all = pair.sum();
      momentum += kBoneStep * all.force;
      ASSERT_LE((0.5 * pair.other.rigid_state().velocity - momentum).norm(), 1e-11) << k;
      const std::vector<Vector3d> now = separations();
      // Without the torque of dampers of joints that have no length.
      for (std::size_t i = 0; i < now.size(); ++i)
        paid -= pair.group.joint(pair.numbers[i])->force.dot(now[i] - apart[i]);
      apart = now;
      const BodySums sums = pair.bar.sums();
      const double bar = pair.bar.energy().total(), box = pair.other.energy().total();
      most = std::max({most, bar, box, stored});
      ASSERT_NEAR(bar, sums.support + pair.bar.contact_sums().joint - sums.dissipated, 1e-8 * most)
          << k;
      ASSERT_NEAR(box, pair.other.contact_sums().joint, 1e-8 * most) << k;
      if (kind == Kind::kSpring || kind == Kind::kString) {
        ASSERT_NEAR(all.energy + all.damped - stored, paid, 1e-8 * most) << k;
      }
    }
    EXPECT_GT(most, 1e-3);
    EXPECT_EQ(pair.sum().damped > 0.0, kind != Kind::kSpring);
  }
}

// The last bone rises uniformly; of a joint on it alone the bone pays the force times its path.
TEST(BonesJoint, TheBonesWorkIsTheForceTimesTheirPath) {
  Motion motion;
  motion.parts.push_back(GlideMotion{{0.1, 0.0, 0.8}, {}});
  const MotionPath path = *MotionPath::create(motion, {});
  JoinedPair pair{joinable_bar(true), box_at({0.56, 0.05, 0.21}, 0.5)};
  pair.join(joints_of(Kind::kSpring, pair.other, pair.bar, bar_vertex({0.6, 0.05, 0.12})));
  double pull = 0.0;
  for (int k = 0; k < 200; ++k) {
    const JointPlace& place = pair.group.joint(pair.numbers[0])->second;
    const Vector3d before = place_now(pair.bar, place);
    move_bone(path, 2, pair.bar);
    pair.step();
    const Vector3d force = -pair.sum().force;  // on the bar
    pull = std::max(pull, force.norm());
    const Vector3d own = place_now(pair.bar, place) - before - kBoneStep * Vector3d(0.1, 0.0, 0.8);
    ASSERT_NEAR(pair.bar.contact_account().joint_work, force.dot(own), 1e-12) << k;
  }
  EXPECT_GT(pull, 1.0);
}

// A place of a weld between vertices on other bones is where it was asked for.
TEST(BonesJoint, PlacesOnABentArmAreWhereTheyWereAsked) {
  ContactBody bar = joinable_bar(true);
  bend(0.8, bar);
  const Result<WeldVertices> all = WeldVertices::create(bar, {});
  ASSERT_TRUE(all) << all.error().message;
  for (const double x : {0.15, 0.2, 0.33, 0.41, 0.58}) {
    const VertexId near = bar_vertex({x, 0.05, 0.12});
    const Vector3d where = *bar.position(near) + Vector3d(0.013, 0.007, 0.004);
    double offset = 0.0;
    EXPECT_LE((place_now(bar, all->at(where, offset)) - where).norm(), 1e-14);
    EXPECT_LT(offset, 0.03);
    EXPECT_LE((place_now(bar, place_at(bar, where)) - where).norm(), 1e-14);
    EXPECT_LE((place_now(bar, vertex_near(bar, *bar.position(near))) - *bar.position(near)).norm(),
              1e-15);
  }
}

// Two bent arms on a string whose bones rest keep their energy with that of the string.
TEST(BonesJoint, TwoArmsKeepTheirEnergy) {
  JoinedPair pair{joinable_bar(true), joinable_bar(true)};
  bend(0.3, pair.bar);
  const std::vector<Pose> poses = bent_arm(-0.2);
  for (std::size_t b = 0; b < poses.size(); ++b)
    ASSERT_TRUE(
        pair.other.set_pose({poses[b].position + Vector3d(0.0, 0.4, 0.0), poses[b].rotation}, b));
  const JointOptions options{.stiffness = 500.0, .damping = 2.0, .length = 0.2};
  pair.join({*make_joint(pair.other, bar_vertex({0.4, 0.0, 0.12}), pair.bar,
                         bar_vertex({0.4, 0.1, 0.12}), options)});
  const JointPlace first = pair.group.joint(pair.numbers[0])->first;
  const JointPlace second = pair.group.joint(pair.numbers[0])->second;
  const double stiffness = pair.group.joint(pair.numbers[0])->stiffness;
  const auto stored = [&] {
    const double far = (place_now(pair.other, first) - place_now(pair.bar, second)).norm();
    return 0.5 * stiffness * std::pow(far - 0.2, 2);
  };
  const double start = stored();
  double most = start;
  for (int k = 0; k < 300; ++k) {
    pair.step();
    const Joint all = pair.sum();
    const double bodies = pair.bar.energy().total() + pair.other.energy().total();
    most = std::max(most, bodies);
    ASSERT_NEAR(all.energy, stored(), 1e-10 * most) << k;
    ASSERT_NEAR(bodies + all.energy + all.damped + pair.bar.sums().dissipated +
                    pair.other.sums().dissipated,
                start, 1e-9 * most)
        << k;
  }
  EXPECT_GT(start, 0.1);
}

TEST(BonesJoint, ContinuesFromASavedState) {
  const MotionPath path = swinging();
  const auto made = [] {
    JoinedPair pair{joinable_bar(true), box_at({0.42, 0.1, 0.15}, 0.5)};
    bend(0.4, pair.bar);
    pair.join(joints_of(Kind::kWeld, pair.other, pair.bar, 0));
    return pair;
  };
  JoinedPair whole = made(), other = made();
  const auto steps = [&path](JoinedPair& pair, int count) {
    for (int k = 0; k < count; ++k) {
      move_bone(path, 0, pair.bar);
      pair.step();
    }
  };
  steps(whole, 60);
  steps(other, 25);
  ASSERT_TRUE(other.bar.restore(whole.bar.save()));
  ASSERT_TRUE(other.other.restore(whole.other.save()));
  steps(whole, 40);
  steps(other, 40);
  EXPECT_EQ(whole.bar.state().q, other.bar.state().q);
  EXPECT_EQ(whole.bar.state().p, other.bar.state().p);
  EXPECT_EQ(whole.sum().force, other.sum().force);
  EXPECT_EQ(whole.sum().energy, other.sum().energy);
}

}  // namespace
}  // namespace tremolo
