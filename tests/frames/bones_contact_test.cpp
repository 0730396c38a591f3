// Contact of bodies on several bones: agreement with a driven frame, momenta, balances, friction.
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "runtime/bodies/reduced/rigid/rigid_solid.h"
#include "runtime/contact/islands/body_group.h"
#include "runtime/contact/solve/contact_step.h"
#include "runtime/math/motion.h"
#include "tests/support/distance_fields.h"
#include "tests/support/frames/rigged_model.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;
using testing::bar_bones;
using testing::bar_skin;
using testing::make_framed;
using testing::make_rigged;
using testing::rigged_bar;
using testing::RiggedBar;

constexpr double kContactStep = 2e-3;

// All vertices have the same area.
const RiggedBar& bar() {
  static const RiggedBar made = [] {
    RiggedBar bar = rigged_bar(5);
    bar.data.triangles.clear();
    bar.model = *Model::from_data(bar.data);
    return bar;
  }();
  return made;
}

IntegratorOptions options_of(double step) {
  return {.step = step, .beta = 1e-3, .tolerance = 1e-12, .max_iterations = 60};
}

// The solid of the bar at rest, whose box begins at the origin.
Collider bar_shape() {
  static const auto grid = std::make_shared<const DistanceGrid>(
      testing::grid_of({{-0.1, -0.1, -0.1}, 0.0125, {65, 25, 27}}, [](const Vector3d& x) {
        return testing::box_formula({0.3, 0.05, 0.06})(x - Vector3d(0.3, 0.05, 0.06));
      }));
  return GridShape{grid};
}

ContactOptions contact_of(std::optional<Collider> shape = {}) {
  return {.points = 60, .shape = std::move(shape), .friction = 0.4, .restitution = 0.6};
}

Model::Pointer rigid_model(const Collider& shape, double mass) {
  RigidSolid solid;
  solid.shape = shape;
  solid.mass = mass;
  return *make_rigid_model(solid);
}

ContactBody ball_at(const Vector3d& place, double step, double mass = 0.5, double radius = 0.04) {
  const Collider sphere = SphereShape{radius};
  ContactBody ball = std::move(
      *ContactBody::create(rigid_model(sphere, mass), "ep4", options_of(step), FrameKind::kFree));
  EXPECT_TRUE(ball.set_contact(contact_of(sphere)));
  EXPECT_TRUE(ball.set_pose({place, Eigen::Quaterniond::Identity()}));
  return ball;
}

ContactBody block_at(const Vector3d& place, double friction) {
  const Collider box = BoxShape{{0.03, 0.02, 0.01}};
  ContactBody block = std::move(
      *ContactBody::create(rigid_model(box, 0.1), "ep4", options_of(1e-3), FrameKind::kFree));
  ContactOptions contact = contact_of(box);
  contact.friction = friction;
  EXPECT_TRUE(block.set_contact(contact));
  EXPECT_TRUE(block.set_pose({place, Eigen::Quaterniond::Identity()}));
  EXPECT_TRUE(block.set_gravity({0.0, 0.0, -9.81}));
  return block;
}

struct Pair {
  ContactBody bar, other;
  BodyGroup group;

  StepReport step(std::span<const PlacedCollider> colliders = {}) {
    ContactBody* const bodies[] = {&bar, &other};
    StepReport reports[2];
    group.step(bodies, colliders, reports);
    EXPECT_TRUE(reports[0].converged && reports[1].converged);
    return reports[0];
  }
};

// The bar, on bones or in one frame, with its shape.
ContactBody bar_of(bool bones, double step) {
  ContactBody body = bones ? make_rigged(bar().model, bar_skin(bar()), options_of(step))
                           : make_framed(bar().model, FrameKind::kDriven, options_of(step), "ep4");
  const Status made = body.set_contact(contact_of(bar_shape()));
  EXPECT_TRUE(made) << (made ? "" : made.error().message);
  return body;
}

// Rises and falls, turns about an inclined axis.
MotionPath whole_path() {
  Motion motion;
  motion.parts.push_back(
      ShakeMotion{{0.01, 0.0, 0.06}, 2.0, {.start = 0.0, .end = 9.0, .ramp = 0.1}});
  motion.parts.push_back(SwingMotion{.axis = {0.2, 1.0, 0.1},
                                     .amplitude = 0.2,
                                     .frequency = 1.5,
                                     .course = {.start = 0.0, .ramp = 0.1}});
  return *MotionPath::create(motion, {{0.0, 0.0, 0.05}, Eigen::Quaterniond::Identity()});
}

// Moves all bones, or the frame, along the path in the next step.
void move_all(const MotionPath& path, ContactBody& body) {
  const double h = body.options().step, t = body.time();
  const FrameMotion motion =
      motion_between(path.pose(t - h), path.pose(t), path.pose(t + h), path.pose(t + 2 * h), h);
  ASSERT_TRUE(body.move_to(path.pose(t + h), motion));
}

TEST(BonesContact, OnAFloorBonesThatMoveTogetherAreADrivenFrame) {
  const MotionPath path = whole_path();
  ContactBody driven =
      make_framed(bar().model, FrameKind::kDriven, options_of(kContactStep), "ep4");
  ContactBody boned = make_rigged(bar().model, bar_skin(bar()), options_of(kContactStep));
  PlacedCollider floor{PlaneShape{}, {}, {}, 0.4, 0.6};
  double impulse = 0.0;
  for (ContactBody* body : {&driven, &boned}) {
    const Status made = body->set_contact(contact_of());
    ASSERT_TRUE(made) << made.error().message;
    ASSERT_TRUE(body->set_pose(path.pose(0.0), kAllBones));
    ASSERT_TRUE(body->set_gravity({0.0, 0.0, -9.81}));
  }
  for (int k = 0; k < 300; ++k) {
    for (ContactBody* body : {&driven, &boned}) {
      move_all(path, *body);
      ASSERT_TRUE(body->step({&floor, 1}).converged) << k;
    }
    const ContactAccount one = driven.contact_account(), other = boned.contact_account();
    impulse += one.impulse;
    ASSERT_NEAR(one.impulse, other.impulse, 1e-9 * (1.0 + impulse)) << k;
    ASSERT_NEAR(one.given, other.given, 1e-9) << k;
  }
  EXPECT_GT(impulse, 0.1);
  EXPECT_GT(driven.contact_sums().friction_loss, 1e-5);
  const Eigen::VectorXd& q = driven.state().q;
  EXPECT_LE((boned.state().q - q).norm(), 1e-9 * q.norm());
}

TEST(BonesContact, UnderABallBonesThatMoveTogetherAreADrivenFrame) {
  const MotionPath path = whole_path();
  Pair one{bar_of(false, kContactStep), ball_at({0.35, 0.05, 0.23}, kContactStep), {}};
  Pair other{bar_of(true, kContactStep), ball_at({0.35, 0.05, 0.23}, kContactStep), {}};
  double impulse = 0.0;
  for (Pair* pair : {&one, &other}) {
    ASSERT_TRUE(pair->bar.set_pose(path.pose(0.0), kAllBones));
    for (ContactBody* body : {&pair->bar, &pair->other})
      ASSERT_TRUE(body->set_gravity({0.0, 0.0, -9.81}));
  }
  for (int k = 0; k < 200; ++k) {
    for (Pair* pair : {&one, &other}) {
      move_all(path, pair->bar);
      pair->step();
    }
    impulse += one.other.contact_account().impulse;
    const RigidState left = one.other.rigid_state(), right = other.other.rigid_state();
    ASSERT_LE((left.velocity - right.velocity).norm(), 1e-7) << k;
    ASSERT_LE((left.centre - right.centre).norm(), 1e-8) << k;
    ASSERT_NEAR(one.bar.contact_account().given, other.bar.contact_account().given, 1e-8) << k;
  }
  EXPECT_GT(impulse, 0.5);
  EXPECT_GT(one.bar.state().q.norm(), 1e-4);
}

// The elbow of bar_bones() is bent by `angle` at x = 0.2, and back at x = 0.4: the last bone is
// level and higher.
std::vector<Pose> stair(double angle) {
  const Eigen::Quaterniond turn = turn_by({0.0, -angle, 0.0});
  const Vector3d elbow(0.2, 0.05, 0.06), wrist(0.4, 0.05, 0.06);
  const Pose middle{elbow - turn * elbow, turn};
  return {{}, middle, {middle * wrist - wrist, Eigen::Quaterniond::Identity()}};
}

// The bar's contact points in a step of bones that move differently.
struct MovedPoints {
  ContactBody body = bar_of(true, kContactStep);
  PresentPlace place;

  MovedPoints() {
    const std::vector<Pose> poses = stair(0.5);
    for (std::size_t b = 0; b < poses.size(); ++b) EXPECT_TRUE(body.set_pose(poses[b], b));
    for (std::size_t b = 0; b < poses.size(); ++b) {
      const auto number = static_cast<double>(b);
      EXPECT_TRUE(body.move_to({poses[b].position + Vector3d(0.001, 0.0, 0.002 * number),
                                poses[b].rotation * turn_by({0.01 * number, 0.02, 0.0})},
                               {}, b));
    }
    place = body.present_place();
  }
  const BonePoints& bones() const { return *place.bones; }
};

TEST(BonesContact, PositionsOfTheWorldBelongToThoseAtRest) {
  const MovedPoints moved;
  const ContactPoints& points = *moved.body.contact()->surface().points;
  double most = 0.0, alone = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vector3d x = moved.body.contact_point(i);
    const double off = (moved.bones().into_rest(x, false) - points.rest[i]).norm();
    most = std::max(most, off);
    // In the middle of the last bone its pose's inverse.
    if (points.rest[i].x() > 0.55) alone = std::max(alone, off);
  }
  EXPECT_LT(alone, 1e-5);
  EXPECT_LT(most, 0.012);
}

TEST(BonesContact, SlopesAreDifferencesAndTheMotionKeepsThePosition) {
  const MovedPoints moved;
  constexpr double kBit = 1e-6;
  for (std::size_t i = 0; i < 60; i += 7) {
    const Vector3d x = moved.body.contact_point(i) + Vector3d(0.004, -0.003, 0.005);
    for (const bool at_end : {false, true}) {
      Eigen::Matrix3d slope, differences;
      moved.bones().into_rest(x, at_end, slope);
      for (Eigen::Index k = 0; k < 3; ++k) {
        const Vector3d bit = kBit * Vector3d::Unit(k);
        differences.col(k) =
            (moved.bones().into_rest(x + bit, at_end) - moved.bones().into_rest(x - bit, at_end)) /
            (2.0 * kBit);
      }
      EXPECT_LE((slope - differences).norm(), 1e-7);
    }
    const StepPoses motion = moved.bones().motion_at(x);
    const Vector3d y = moved.bones().into_rest(x, false);
    EXPECT_LE((motion.start * y - x).norm(), 1e-14);
    EXPECT_LE((moved.bones().into_rest(motion.end * y, true) - y).norm(), 1e-12);
  }
}

TEST(BonesContact, ABlockRestsOnTheLastBoneOfABentArm) {
  const std::vector<Pose> poses = stair(0.4);
  const Vector3d top = poses[2].position + Vector3d(0.52, 0.05, 0.12);
  Pair pair{bar_of(true, 1e-3), block_at(top + Vector3d(0.0, 0.0, 0.012), 0.4), {}};
  for (std::size_t b = 0; b < poses.size(); ++b) ASSERT_TRUE(pair.bar.set_pose(poses[b], b));
  ASSERT_TRUE(pair.bar.set_damping(40.0, 0.0));
  const double weight = 0.1 * 9.81 * 1e-3;
  Vector3d push = Vector3d::Zero();
  for (int k = 0; k < 2000; ++k) {
    pair.step();
    if (k >= 1900) push += pair.other.contact_account().impulse_vector / 100.0;
  }
  EXPECT_LE((push - Vector3d(0.0, 0.0, weight)).norm(), 1e-3 * weight);
  // The block is on the surface, within the margin, and the bar hardly yields.
  EXPECT_LE((pair.other.rigid_state().centre - top - Vector3d(0.0, 0.0, 0.01)).norm(), 0.003);
  EXPECT_LE(pair.other.rigid_state().velocity.norm(), 1e-4);
}

// The last bone of an arm swings up and kicks a ball that lies at rest.
MotionPath kick_path(double height) {
  Motion motion;
  KeyframeMotion keys;
  keys.keys = {{0.0, {}},
               {0.05, {}},
               {0.15, {{0.0, 0.0, height}, turn_by({0.0, -0.2, 0.0})}},
               {0.4, {{0.0, 0.0, height}, turn_by({0.0, -0.2, 0.0})}}};
  motion.parts.push_back(keys);
  return *MotionPath::create(motion, {});
}

// Moves the bone `b` along the path in the next step; the others rest.
void move_one(const MotionPath& path, std::size_t b, ContactBody& body) {
  const double h = body.options().step, t = body.time();
  const FrameMotion motion =
      motion_between(path.pose(t - h), path.pose(t), path.pose(t + h), path.pose(t + 2 * h), h);
  ASSERT_TRUE(body.move_to(path.pose(t + h), motion, b));
}

Pair kick_pair(double step) {
  return {bar_of(true, step), ball_at({0.5, 0.05, 0.165}, step), {}};
}

TEST(BonesContact, AKickKeepsMomentumAndTheEnergyOfThePair) {
  const MotionPath path = kick_path(0.05);
  Pair pair = kick_pair(1e-3);
  Vector3d momentum = Vector3d::Zero();
  double taken = 0.0, given = 0.0, largest = 0.0;
  for (int k = 0; k < 300; ++k) {
    move_one(path, 2, pair.bar);
    pair.step();
    const ContactAccount a = pair.bar.contact_account(), b = pair.other.contact_account();
    ASSERT_LE((a.impulse_vector + b.impulse_vector).norm(), 1e-13);
    momentum += b.impulse_vector;
    given += a.given + b.given;
    taken += a.lost + b.lost + a.friction_loss + b.friction_loss;
    const RigidState ball = pair.other.rigid_state();
    ASSERT_LE((0.5 * ball.velocity - momentum).norm(), 1e-10);
    const double energy =
        pair.bar.energy().total() + pair.other.energy().total() + a.energy + b.energy;
    largest = std::max(largest, energy);
    // The work of the bones on the vibration is `support`.
    ASSERT_NEAR(energy, given - taken + pair.bar.sums().support - pair.bar.sums().dissipated,
                1e-8 * largest)
        << k;
  }
  EXPECT_GT(pair.other.rigid_state().velocity.z(), 0.5);
  EXPECT_GT(given, 0.05);
}

TEST(BonesContact, TheBonesWorkIsTheImpulseTimesTheirSpeed) {
  // The last bone rises uniformly; the ball falls onto its end, where it has the whole weight.
  Motion motion;
  motion.parts.push_back(GlideMotion{{0.1, 0.0, 0.8}, {}});
  const MotionPath path = *MotionPath::create(motion, {});
  Pair pair{bar_of(true, 1e-3), ball_at({0.56, 0.05, 0.21}, 1e-3), {}};
  double sum = 0.0;
  for (int k = 0; k < 150; ++k) {
    move_one(path, 2, pair.bar);
    pair.step();
    const ContactAccount a = pair.bar.contact_account(), b = pair.other.contact_account();
    const double work = b.impulse_vector.dot(Vector3d(0.1, 0.0, 0.8));
    sum += std::abs(work);
    ASSERT_NEAR(a.given + b.given, work, 1e-9 + 1e-6 * std::abs(work)) << k;
  }
  EXPECT_GT(sum, 0.1);
}

TEST(BonesContact, TheSpeedOfAKickedBallSettlesAsTheStepIsHalved) {
  const MotionPath path = kick_path(0.05);
  std::vector<double> speeds;
  for (const double step : {2e-3, 1e-3, 5e-4, 2.5e-4}) {
    Pair pair = kick_pair(step);
    const int steps = static_cast<int>(std::lround(0.3 / step));
    for (int k = 0; k < steps; ++k) {
      move_one(path, 2, pair.bar);
      pair.step();
    }
    speeds.push_back(pair.other.rigid_state().velocity.z());
  }
  const double last = std::abs(speeds[3] - speeds[2]);
  EXPECT_LT(last, 0.01 * speeds[3]);
  EXPECT_LT(last, 0.6 * std::abs(speeds[1] - speeds[0]));
}

TEST(BonesContact, ABlockOnAMovingBoneIsDraggedByMuN) {
  Motion motion;
  motion.parts.push_back(GlideMotion{{0.0, 0.5, 0.0}, {.start = 0.3, .ramp = 0.02}});
  const MotionPath path = *MotionPath::create(motion, {});
  Pair pair{bar_of(true, 1e-3), block_at({0.54, 0.05, 0.1305}, 0.1), {}};
  ASSERT_TRUE(pair.bar.set_damping(400.0, 0.0));
  double push = 0.0, drag = 0.0;
  Vector3d whole = Vector3d::Zero();
  for (int k = 0; k < 430; ++k) {
    move_one(path, 2, pair.bar);
    pair.step();
    if (k < 330) continue;
    whole += pair.other.contact_account().impulse_vector;
    // The bar is tilted by its load: across and along the surface.
    for (const ContactBody* body : {&pair.bar, &pair.other})
      for (const ContactedPoint& point : body->contact()->record().contacted) {
        const double across = point.impulse.dot(point.normal);
        push += across;
        drag += (point.impulse - across * point.normal).norm();
      }
  }
  // mu = (0.1 0.4)^(1/2).
  EXPECT_NEAR(drag, 0.2 * push, 1e-3 * push);
  EXPECT_NEAR(whole.y(), 0.2 * whole.z(), 0.01 * whole.z());
  EXPECT_LT(pair.other.rigid_state().velocity.y(), 0.4);
}

TEST(BonesContact, SavedInContactItContinuesWithTheSameBits) {
  const MotionPath path = kick_path(0.05);
  const PlacedCollider lid{PlaneShape{},
                           {{0.0, 0.0, 0.16}, turn_by({M_PI, 0.0, 0.0})},
                           {{0.0, 0.0, 0.16}, turn_by({M_PI, 0.0, 0.0})},
                           0.3,
                           0.5};
  ContactBody body = bar_of(true, 1e-3), other = bar_of(true, 1e-3);
  const auto steps = [&](ContactBody& one, int count) {
    for (int k = 0; k < count; ++k) {
      move_one(path, 2, one);
      ASSERT_TRUE(one.step({&lid, 1}).converged);
    }
  };
  steps(body, 105);
  EXPECT_GT(body.contact_account().active, 0);
  ASSERT_TRUE(other.restore(body.save()));
  steps(body, 50);
  steps(other, 50);
  EXPECT_EQ(body.state().q, other.state().q);
  EXPECT_EQ(body.state().p, other.state().p);
  EXPECT_EQ(body.contact_sums().given, other.contact_sums().given);
}

TEST(BonesContact, AHandHoldsAVertexOnItsBones) {
  const std::vector<Pose> poses = stair(0.4);
  ContactBody body = bar_of(true, 1e-3);
  for (std::size_t b = 0; b < poses.size(); ++b) ASSERT_TRUE(body.set_pose(poses[b], b));
  const VertexId vertex = bar().model->default_load().vertices.front();
  const Vector3d start = *body.position(vertex);
  const Result<std::size_t> hand = body.pin(vertex);
  ASSERT_TRUE(hand) << hand.error().message;
  for (int k = 1; k <= 200; ++k) {
    ASSERT_TRUE(body.move_hand(*hand, start + Vector3d(0.0, 0.0, 1e-5 * k)));
    ASSERT_TRUE(body.step().converged);
  }
  EXPECT_LE((*body.position(vertex) - start - Vector3d(0.0, 0.0, 2e-3)).norm(), 1e-4);
  EXPECT_GT(body.hand_force(*hand).z(), 0.0);
  EXPECT_EQ(body.grab(SurfacePlace{}, 1.0).error().kind, ErrorKind::kUsage);
}

}  // namespace
}  // namespace tremolo
