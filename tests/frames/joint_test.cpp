// Joints: their law, momenta and energy of bodies that they hold, known answers, scenes with them.
#include "runtime/contact/joint.h"

#include <array>
#include <cmath>
#include <random>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "common/state_stream.h"
#include "runtime/contact/islands/body_group.h"
#include "runtime/world/scene_world.h"
#include "tests/support/frames/frame_models.h"

namespace tremolo {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kJointStep = 1e-3;

Vector3d random_vector(std::mt19937& engine, double size) {
  std::uniform_real_distribution<double> spread(-size, size);
  return {spread(engine), spread(engine), spread(engine)};
}

// Both bodies get the energy that the joint had, less its damper's loss; and no torque remains.
TEST(Joints, GiveWhatTheyStored) {
  std::mt19937 engine(5);
  for (const double length : {0.0, 0.2})
    for (int k = 0; k < 200; ++k) {
      Joint joint;
      joint.stiffness = 300.0;
      joint.damping = k % 2 == 0 ? 0.0 : 4.0;
      joint.length = length;
      const Vector3d s0 = random_vector(engine, 0.3);
      const Vector3d s1 = s0 + random_vector(engine, k % 3 == 0 ? 0.3 : 1e-3);
      const Vector3d turn = random_vector(engine, 0.3);
      const JointForce now = joint_force(joint, s0, s1, turn, kJointStep);
      const double before = 0.5 * joint.stiffness * std::pow(s0.norm() - length, 2);
      const double work = now.force.dot(s1 - s0) + 2.0 * now.torque.dot(turn);
      const double scale = before + now.energy + now.damped;
      EXPECT_NEAR(work, before - now.energy - now.damped, 1e-13 * scale);
      EXPECT_GE(now.damped, 0.0);
      const Vector3d torque = 0.5 * (s0 + s1).cross(now.force) + 2.0 * now.torque;
      EXPECT_LT(torque.norm(), 1e-13 * now.force.norm());
    }
}

TEST(Joints, FallByTheirSlope) {
  std::mt19937 engine(8);
  for (const double length : {0.0, 0.2}) {
    Joint joint;
    joint.stiffness = 300.0;
    joint.length = length;
    const Vector3d s0 = random_vector(engine, 0.3), s1 = random_vector(engine, 0.3);
    const JointForce at = joint_force(joint, s0, s1, {0.0, 0.0, 0.0}, kJointStep);
    Matrix3d slope;
    constexpr double kMove = 1e-6;
    for (int i = 0; i < 3; ++i) {
      const Vector3d move = kMove * Vector3d::Unit(i), none = Vector3d::Zero();
      slope.col(i) = (joint_force(joint, s0, s1 - move, none, kJointStep).force -
                      joint_force(joint, s0, s1 + move, none, kJointStep).force) /
                     (2.0 * kMove);
    }
    EXPECT_LT((slope - at.slope).norm(), 1e-6 * slope.norm());
  }
}

ContactBody touching(const Model::Pointer& model, FrameKind kind, double step = kJointStep,
                     double beta = 0.0) {
  IntegratorOptions options;
  options.step = step;
  options.beta = beta;
  ContactBody body = testing::make_framed(model, kind, options);
  EXPECT_TRUE(body.set_contact());
  return body;
}

double balance_of(const ContactBody& body) {
  return body.energy().total() - body.sums().work + body.sums().dissipated;
}

// Soft bodies that tumble, with every kind of joint: both momenta stay, and the energy balance
// closes.
TEST(Joints, KeepBothMomentaAndTheEnergy) {
  const JointOptions kinds[] = {{},
                                {.stiffness = 200.0, .damping = 3.0},
                                {.stiffness = 2e4, .damping = 0.0, .length = 0.3},
                                {.stiffness = 500.0, .damping = 10.0, .length = 1.0}};
  for (const JointOptions& options : kinds)
    for (const double beta : {0.0, 1e-3}) {
      ContactBody one = touching(testing::frame_model(5, true, 30.0, 300.0, 0.3, 3),
                                 FrameKind::kFree, kJointStep, beta);
      ContactBody two = touching(testing::frame_model(6, true, 40.0, 200.0, 0.3, 7),
                                 FrameKind::kFree, kJointStep, beta);
      ASSERT_TRUE(two.set_pose({{0.8, 0.2, 0.1}, turn_by({0.3, 1.0, -0.4})}));
      ASSERT_TRUE(one.set_motion({0.4, -0.2, 0.1}, {1.0, 3.0, -2.0}));
      ASSERT_TRUE(two.set_motion({-0.3, 0.5, 0.0}, {-2.0, 0.5, 4.0}));
      const Result<Joint> made = options.stiffness ? make_joint(one, 4, two, 9, options)
                                                   : make_joint(one, 4, two, options);
      ASSERT_TRUE(made) << made.error().message;
      const double stored =
          0.5 * made->stiffness * std::pow(joint_distance(*made, one, two) - made->length, 2);
      BodyGroup group;
      const std::size_t number = group.join(0, 1, *made);
      const std::array<ContactBody*, 2> bodies = {&one, &two};
      std::array<StepReport, 2> reports;
      const auto linear = [&] { return Vector3d(one.momentum().linear + two.momentum().linear); };
      const auto angular = [&] {
        return Vector3d(one.momentum().angular + two.momentum().angular);
      };
      const Vector3d linear_start = linear(), angular_start = angular();
      const double alone_one = balance_of(one), alone_two = balance_of(two);
      const double start = one.energy().total() + two.energy().total() + stored;
      double worst_linear = 0.0, worst_angular = 0.0, worst_energy = 0.0, worst_alone = 0.0;
      std::int64_t iterations = 0;
      for (int k = 0; k < 2'000; ++k) {
        group.step(bodies, {}, reports);
        ASSERT_TRUE(reports[0].converged && reports[1].converged) << k;
        iterations += reports[0].iterations;
        const Joint& joint = *group.joint(number);
        const double all = one.energy().total() + two.energy().total() + joint.energy +
                           joint.damped + one.sums().dissipated + two.sums().dissipated;
        worst_linear = std::max(worst_linear, (linear() - linear_start).norm());
        worst_angular = std::max(worst_angular, (angular() - angular_start).norm());
        worst_energy = std::max(worst_energy, std::abs(all - start));
        worst_alone = std::max({worst_alone, std::abs(balance_of(one) - alone_one),
                                std::abs(balance_of(two) - alone_two)});
      }
      EXPECT_LT(worst_linear, 1e-11);
      EXPECT_LT(worst_angular, 1e-11);
      EXPECT_LT(worst_energy, 1e-9 * start);
      EXPECT_LT(worst_alone, 1e-9 * start);
      EXPECT_LT(iterations, 2'000 * 8);
      if (!options.stiffness) {
        EXPECT_LT(joint_distance(*group.joint(number), one, two), 1e-4);
      }
      EXPECT_GT(std::abs(one.contact_sums().joint), 1e-3 * start);
    }
}

// Two bodies on a spring between their centres: sqrt(k/mu), and the damper's e^(-c t/(2 mu)).
TEST(Joints, SwingAsASpringBetweenTwoMasses) {
  const Model::Pointer model = testing::frame_model(4, true, 3e3, 1e4, 0.0, 3);
  ContactBody one = touching(model, FrameKind::kFree), two = touching(model, FrameKind::kFree);
  const double mu = 0.5 * model->inertia()->mass, omega = 40.0, c = 2.0 * mu * 1.5;
  Joint joint;
  const auto centre = model->inertia_about_centre()->centre;
  joint.first.rest = joint.second.rest = centre;
  joint.first.rows.setZero(3, model->modes());
  joint.second.rows = joint.first.rows;
  joint.stiffness = mu * omega * omega;
  joint.damping = c;
  joint.length = 1.0;
  ASSERT_TRUE(two.set_pose({{1.05, 0.0, 0.0}, Eigen::Quaterniond::Identity()}));
  BodyGroup group;
  group.join(0, 1, joint);
  const std::array<ContactBody*, 2> bodies = {&one, &two};
  std::array<StepReport, 2> reports;
  const double damped = std::sqrt(omega * omega - 1.5 * 1.5);
  double worst = 0.0;
  for (int k = 1; k <= 1'000; ++k) {
    group.step(bodies, {}, reports);
    const double t = k * kJointStep;
    const double apart = (two.pose().position - one.pose().position).norm() - 1.0;
    const double exact =
        0.05 * std::exp(-1.5 * t) * (std::cos(damped * t) + 1.5 / damped * std::sin(damped * t));
    worst = std::max(worst, std::abs(apart - exact));
  }
  // The step's phase lags by (omega h)^2/12 of itself.
  EXPECT_LT(worst, 0.05 * 40.0 * 1.6e-3 / 12.0 * 1.5);
}

// A rigid body about a fixed pivot, by Runge and Kutta. arm: from the pivot to the centre; J: about
// the pivot; both along the body's axes.
struct Pendulum {
  Matrix3d J;
  Vector3d arm;
  double mass, gravity;
  Eigen::Quaterniond turn;
  Vector3d spin = Vector3d::Zero();

  void run(double time, int steps) {
    const double h = time / steps;
    const auto rate = [this](const Eigen::Vector4d& q, const Vector3d& w) {
      const Eigen::Quaterniond at(q[3], q[0], q[1], q[2]);
      const Vector3d pull = at.conjugate() * Vector3d(0.0, 0.0, -mass * gravity);
      const Vector3d moved = J.inverse() * ((J * w).cross(w) + arm.cross(pull));
      const Eigen::Quaterniond turning = at * Eigen::Quaterniond(0.0, w.x(), w.y(), w.z());
      return std::pair{Eigen::Vector4d(0.5 * turning.coeffs()), moved};
    };
    for (int k = 0; k < steps; ++k) {
      const Eigen::Vector4d q = turn.coeffs();
      const auto [q1, w1] = rate(q, spin);
      const auto [q2, w2] = rate(q + 0.5 * h * q1, spin + 0.5 * h * w1);
      const auto [q3, w3] = rate(q + 0.5 * h * q2, spin + 0.5 * h * w2);
      const auto [q4, w4] = rate(q + h * q3, spin + h * w3);
      turn.coeffs() = (q + h / 6.0 * (q1 + 2.0 * q2 + 2.0 * q3 + q4)).normalized();
      spin += h / 6.0 * (w1 + 2.0 * w2 + 2.0 * w3 + w4);
    }
  }
};

// A stiff body that hangs from a fixed one by a joint swings as a rigid one about that point.
TEST(Joints, SwingAsARigidPendulum) {
  const Model::Pointer model = testing::frame_model(4, true, 3e4, 1e5, 0.0, 3);
  const Model::Pointer held_model = testing::frame_model(4, false, 3e3, 1e4, 0.0, 5);
  constexpr double kGravity = 9.81, kTime = 1.5;
  const std::shared_ptr<const FrameInertia> inertia = model->inertia_about_centre();
  const Vector3d pivot = model->vertex(2)->rest;
  const Eigen::Quaterniond begun = turn_by({0.4, -0.8, 0.3});
  Pendulum exact{{}, inertia->centre - pivot, inertia->mass, kGravity, begun};
  const Matrix3d P = inertia->P0 + inertia->mass * exact.arm * exact.arm.transpose();
  exact.J = P.trace() * Matrix3d::Identity() - P;
  exact.run(kTime, 20'000);
  const Vector3d centre = exact.turn * exact.arm;
  double errors[2];
  for (const int fine : {0, 1}) {
    const double step = fine == 0 ? 2e-3 : 1e-3;
    ContactBody body = touching(model, FrameKind::kFree, step);
    ContactBody support = touching(held_model, FrameKind::kDriven, step);
    ASSERT_TRUE(body.set_gravity({0.0, 0.0, -kGravity}));
    ASSERT_TRUE(body.set_pose({-(begun * pivot), begun}));
    ASSERT_TRUE(support.set_pose({-held_model->vertex(0)->rest, Eigen::Quaterniond::Identity()}));
    const Result<Joint> joint = make_joint(body, 2, support, 0);
    ASSERT_TRUE(joint) << joint.error().message;
    BodyGroup group;
    group.join(0, 1, *joint);
    const std::array<ContactBody*, 2> bodies = {&body, &support};
    std::array<StepReport, 2> reports;
    const double start = balance_of(body);
    for (int k = 0; k < static_cast<int>(std::lround(kTime / step)); ++k) {
      group.step(bodies, {}, reports);
      ASSERT_TRUE(reports[0].converged && reports[1].converged) << k;
    }
    errors[fine] = (body.pose() * inertia->centre - centre).norm();
    EXPECT_NEAR(balance_of(body), start, 1e-8);
  }
  EXPECT_GT((centre - begun * exact.arm).norm(), 0.1);
  EXPECT_LT(errors[1], 1e-5 * exact.arm.norm());
  EXPECT_NEAR(errors[0] / errors[1], 4.0, 0.6);
}

// A body whose step has been changed solves for contact as one that was made with it.
TEST(Joints, AndHandsFollowAnotherStep) {
  const Model::Pointer model = testing::frame_model(5, true, 60.0, 300.0, 0.3, 3);
  ContactBody changed = touching(model, FrameKind::kFree, 1e-3);
  ASSERT_TRUE(changed.set_method("ep4", 4e-3));
  ContactBody made = touching(model, FrameKind::kFree, 4e-3);
  for (ContactBody* body : {&changed, &made}) {
    ASSERT_TRUE(body->set_motion({0.4, -0.2, 0.1}, {1.0, 3.0, -2.0}));
    ASSERT_TRUE(body->grab(4, 1e5, 10.0));
  }
  for (int k = 0; k < 100; ++k) {
    ASSERT_TRUE(changed.step().converged) << k;
    ASSERT_TRUE(made.step().converged) << k;
    ASSERT_EQ(changed.state().q, made.state().q) << k;
  }
  EXPECT_EQ(changed.counts().iterations, made.counts().iterations);
}

Result<Model::Pointer> joined_model(const SceneBody& body) {
  const bool free = body.kind == FrameKind::kFree;
  return testing::frame_model(5, free, 60.0, 300.0, 0.2, free ? 3 : 4);
}

// A chain that hangs from a shaken body above a floor; its last link is released.
Scene chain() {
  Scene scene;
  scene.step = 1e-3;
  scene.gravity.values = {{0.0, 0.0, -9.81}};
  for (int k = 0; k < 4; ++k) {
    SceneBody body;
    body.name = "link" + std::to_string(k);
    body.kind = k == 0 ? FrameKind::kDriven : FrameKind::kFree;
    body.model = k == 0 ? "held" : "free";
    body.options.beta = 1e-3;
    body.pose.position = {0.9 * k, 0.0, 2.0};
    if (k > 0) body.contact.shape = BoxShape{{0.4, 0.25, 0.15}};
    if (k == 0) body.motion.parts = {ShakeMotion{{0.0, 0.05, 0.02}, 2.0, {0.0, 5.0, 0.2}}};
    scene.bodies.push_back(body);
  }
  for (int k = 1; k < 4; ++k) {
    SceneJoint joint;
    joint.body = "link" + std::to_string(k);
    joint.at = "4";
    joint.to = "link" + std::to_string(k - 1);
    if (k == 3) joint.until = 0.3;
    scene.joints.push_back(joint);
  }
  SceneCollider floor;
  floor.name = "floor";
  floor.pose.position.z() = 0.2;
  scene.colliders = {floor};
  return scene;
}

SceneWorld chain_world(const Scene& scene) {
  Result<SceneWorld> world = SceneWorld::create(scene, joined_model);
  EXPECT_TRUE(world) << (world ? "" : world.error().message);
  return std::move(*world);
}

TEST(Joints, OfASceneHoldAreSavedAndLetGo) {
  const Scene scene = chain();
  SceneWorld world = chain_world(scene);
  double most = 0.0;
  for (int k = 0; k < 800; ++k) {
    if (k == 200 || k == 400) {
      SceneWorld other = chain_world(scene);
      for (int i = 0; i < 350; ++i) (void)other.step();
      const Status restored = other.restore(world.save());
      ASSERT_TRUE(restored) << restored.error().message;
      EXPECT_EQ(state_bytes(world), state_bytes(other));
      SceneWorld straight = chain_world(scene);
      for (int i = 0; i < k + 100; ++i) (void)straight.step();
      for (int i = 0; i < 100; ++i) (void)other.step();
      EXPECT_EQ(state_bytes(straight), state_bytes(other));
    }
    ASSERT_TRUE(world.step().empty()) << k;
    for (std::size_t i = 0; i < 3; ++i) {
      const Joint* joint = world.joint(i);
      ASSERT_EQ(joint != nullptr, i < 2 || k < 300) << i << " " << k;
      if (joint != nullptr && k % 50 == 0) {
        const double apart = joint_distance(*joint, world.body(i + 1), world.body(i));
        EXPECT_LT(apart, 1e-3);
      }
    }
    for (std::size_t i = 0; i < world.size(); ++i)
      most = std::max(most, std::abs(world.account(i).total()));
  }
  for (std::size_t i = 0; i < world.size(); ++i)
    EXPECT_LT(std::abs(world.account(i).remainder()), 1e-8 * most) << i;
  EXPECT_NE(world.account(1).joint, 0.0);
  // The released link has fallen.
  EXPECT_LT(world.body(3).pose().position.z(), world.body(2).pose().position.z());
}

TEST(Joints, DoNotDependOnTheOrderOfBodies) {
  const Scene scene = chain();
  Scene turned = scene;
  std::swap(turned.bodies[0], turned.bodies[3]);
  std::swap(turned.joints[0], turned.joints[2]);
  SceneWorld one = chain_world(scene), two = chain_world(turned);
  for (int k = 0; k < 400; ++k) {
    (void)one.step();
    (void)two.step();
  }
  for (std::size_t i = 0; i < one.size(); ++i)
    EXPECT_EQ(one.body(i).state().q, two.body(*two.find(one.name(i))).state().q);
}

TEST(Joints, ThatCannotBeAreRefused) {
  const auto expect_error = [](const Scene& scene, const std::string& words) {
    const Result<SceneWorld> world = SceneWorld::create(scene, joined_model);
    ASSERT_FALSE(world) << words;
    EXPECT_NE(world.error().message.find(words), std::string::npos) << world.error().message;
    EXPECT_NE(world.error().message.find("joint 1"), std::string::npos) << world.error().message;
  };
  const auto with = [](const auto& change) {
    Scene scene = chain();
    change(scene.joints[0]);
    return scene;
  };
  using J = SceneJoint;
  expect_error(with([](J& j) { j.to = "nobody"; }), "there is no body 'nobody'");
  expect_error(with([](J& j) { j.to = j.body; }), "to itself");
  expect_error(with([](J& j) { j.at = "99"; }), "99");
  expect_error(with([](J& j) { j.to_at = "5"; }), "apart at the start");
  expect_error(with([](J& j) { j.options.length = -1.0; }), "length");
  expect_error(with([](J& j) { j.options.stiffness = 0.0; }), "stiffness");
}

}  // namespace
}  // namespace tremolo
