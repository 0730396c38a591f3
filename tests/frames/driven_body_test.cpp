// Bodies whose support moves: known answers, balances, orders.
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "runtime/math/motion.h"
#include "tests/support/dynamics.h"
#include "tests/support/frames/frame_models.h"
#include "tests/support/held_case.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;
using testing::frame_model;
using testing::kDrivenMethods;
using testing::make_framed;
using testing::steps_of;

// Shaken and rotated about an axis that does not pass through it, all smoothly.
MotionPath whirl() {
  Motion motion;
  motion.parts.push_back(
      ShakeMotion{{0.02, -0.01, 0.03}, 3.0, {.start = -1.0, .end = 100.0, .ramp = 0.5}});
  motion.parts.push_back(SpinMotion{
      {0.3, 0.5, 1.0}, {0.1, 0.2, -0.1}, 4.0, {.start = 0.05, .end = 100.0, .ramp = 0.4}});
  motion.parts.push_back(SpinMotion{{1.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, -2.0, {}});
  return *MotionPath::create(motion, {{0.2, 0.0, 0.1}, Eigen::Quaterniond(0.6, 0.0, 0.8, 0.0)});
}

// One step along the path with the poses around it.
StepReport step_along(const MotionPath& path, ContactBody& body) {
  const double h = body.options().step;
  const auto pose = [&](int k) {
    return path.pose(static_cast<double>(body.counts().steps + k) * h);
  };
  const FrameMotion motion = motion_between(pose(-1), pose(0), pose(1), pose(2), h);
  EXPECT_TRUE(body.move_to(pose(1), motion));
  return body.step();
}

// Newton's laws of the cloud's points in a frame that follows the path, by the classical method of
// Runge and Kutta: has no code in common with the tested method. The frame's rates are differences
// of poses.
class HeldCloud {
 public:
  HeldCloud(testing::PointCloud cloud, testing::StrainModel strain, MotionPath path)
      : cloud_(std::move(cloud)), strain_(std::move(strain)), path_(std::move(path)) {}

  State run(State s, const Vector3d& gravity, const testing::HeldCase& held, int steps) {
    return testing::runge_kutta(
        std::move(s), held.kTime, steps, [&](double at, const VectorXd& q, const VectorXd& v) {
          return State{v, acceleration(at, q, v, gravity) - held.damping(q, v)};
        });
  }

 private:
  Vector3d spin(double t) const {
    constexpr double kBit = 1e-4;
    return turn_of(path_.pose(t - kBit).rotation.conjugate() * path_.pose(t + kBit).rotation) /
           (2.0 * kBit);
  }

  VectorXd acceleration(double t, const VectorXd& q, const VectorXd& v, const Vector3d& gravity) {
    constexpr double kBit = 1e-3;
    const Pose here = path_.pose(t);
    const Vector3d c2 =
        (path_.pose(t - kBit).position - 2.0 * here.position + path_.pose(t + kBit).position) /
        (kBit * kBit);
    const Vector3d a = here.rotation.conjugate() * (c2 - gravity);
    const Vector3d w = spin(t), rate = (spin(t + kBit) - spin(t - kBit)) / (2.0 * kBit);
    VectorXd sum = -testing::strain_force(strain_, q);
    for (std::size_t k = 0; k < cloud_.masses.size(); ++k) {
      const Eigen::MatrixXd phi = cloud_.basis.middleRows(3 * static_cast<Eigen::Index>(k), 3);
      const Vector3d y = cloud_.places[k] + phi * q;
      const Vector3d felt =
          a + rate.cross(y) + w.cross(w.cross(y)) + 2.0 * w.cross(Vector3d(phi * v));
      sum -= cloud_.masses[k] * phi.transpose() * felt;
    }
    return sum;
  }

  testing::PointCloud cloud_;
  testing::StrainModel strain_;
  MotionPath path_;
};

TEST(DrivenBody, FollowsNewtonsLawsOfItsPointsInSecondOrder) {
  const Vector3d gravity(0.0, 2.0, -9.81);
  const testing::HeldCase held;
  const State exact =
      HeldCloud(held.cloud, held.strain, whirl()).run(held.start, gravity, held, 3000);
  for (const char* method : kDrivenMethods)
    testing::expect_second_order(method, exact.q, [&](int steps) {
      ContactBody body =
          make_framed(held.model, FrameKind::kDriven, testing::held_options(steps), method);
      EXPECT_TRUE(body.set_pose(whirl().pose(0.0)));
      EXPECT_TRUE(body.set_state(held.start.q, held.start.p));
      EXPECT_TRUE(body.set_gravity(gravity));
      for (int k = 0; k < steps; ++k) EXPECT_TRUE(step_along(whirl(), body).converged);
      return body.state().q;
    });
}

TEST(DrivenBody, BalanceClosesWithDampingLoadGravityAndATurningFrame) {
  for (const char* method : {"avf", "ep2", "ep4"}) {
    ContactBody body = make_framed(frame_model(6, false, 14.0, 200.0), FrameKind::kDriven,
                                   {.step = 3e-3, .alpha = 0.2, .beta = 1e-3}, method);
    const MotionPath path = whirl();
    ASSERT_TRUE(body.set_pose(path.pose(0.0)));
    ASSERT_TRUE(body.set_gravity({0.0, 2.0, -9.81}));
    ASSERT_TRUE(body.add_load({.kind = SignalKind::kSine}, 5, {3.0, 1.0, -2.0}));
    const auto balance = testing::balance_of(body, 2000, [&] { return step_along(path, body); });
    testing::expect_balance(balance, body, method);
  }
}

TEST(DrivenBody, SupportThatAcceleratesIsGravityTurnedRound) {
  const Vector3d acceleration(1.0, -2.0, 3.0);
  const Model::Pointer model = frame_model(4, false, 14.0, 90.0);
  for (const char* method : kDrivenMethods) {
    ContactBody driven = make_framed(model, FrameKind::kDriven, {.step = 3e-3}, method);
    ContactBody fixed = make_framed(model, FrameKind::kFixed, {.step = 3e-3}, method);
    ASSERT_TRUE(fixed.set_gravity(-acceleration));
    const double h = 3e-3;
    for (int k = 0; k < 300; ++k) {
      const double t = (k + 1) * h;
      ASSERT_TRUE(driven.move_to({0.5 * t * t * acceleration, Eigen::Quaterniond::Identity()},
                                 FrameMotion{acceleration, Vector3d::Zero(), Vector3d::Zero()}));
      ASSERT_TRUE(driven.step().converged);
      ASSERT_TRUE(fixed.step().converged);
    }
    EXPECT_GT(fixed.state().q.norm(), 1e-3);
    EXPECT_LE((driven.state().q - fixed.state().q).norm(), 1e-9 * fixed.state().q.norm()) << method;
  }
}

TEST(DrivenBody, FixedVerticesAreWhereThePoseSaysAtEveryStep) {
  ContactBody body =
      make_framed(frame_model(5, false, 14.0, 90.0), FrameKind::kDriven, {.step = 3e-3});
  const MotionPath path = whirl();
  ASSERT_TRUE(body.set_pose(path.pose(0.0)));
  const Vector3d rest = body.model().vertex(0)->rest;
  for (int k = 0; k < 500; ++k) {
    ASSERT_TRUE(step_along(path, body).converged);
    Pose pose = path.pose(body.time());
    pose.rotation.normalize();
    ASSERT_EQ(*body.position(0), pose * rest) << k;
  }
}

TEST(DrivenBody, TeleportsWithoutAKick) {
  for (const char* method : kDrivenMethods) {
    ContactBody body =
        make_framed(frame_model(4, false, 14.0, 90.0), FrameKind::kDriven, {}, method);
    for (int k = 0; k < 20; ++k) {
      const Pose pose{{100.0 * k, 3.0, -1.0 * k}, turn_by({0.1 * k, 1.0, 0.0})};
      ASSERT_TRUE(body.set_pose(pose));
      ASSERT_TRUE(body.step().converged);
      ASSERT_TRUE(body.move_to(pose));
      ASSERT_TRUE(body.step().converged);
    }
    EXPECT_TRUE(body.state().q.isZero(0.0)) << method;
    EXPECT_TRUE(body.state().p.isZero(0.0)) << method;
  }
}

TEST(DrivenBody, PosesAloneGiveAccelerationsOfSecondOrder) {
  const Model::Pointer model = frame_model(4, false, 14.0, 60.0);
  const auto orbit = [&](double h, bool known) {
    ContactBody body = make_framed(model, FrameKind::kDriven, {.step = h, .tolerance = 1e-11});
    Motion motion;  // from rest: the state before the first step is then known
    motion.parts.push_back(GlideMotion{{0.5, 0.2, -0.3}, {.start = 0.01, .ramp = 0.3}});
    motion.parts.push_back(
        SpinMotion{{0.3, 0.5, 1.0}, {0.1, 0.2, -0.1}, 3.0, {.start = 0.02, .ramp = 0.3}});
    const MotionPath path = *MotionPath::create(motion);
    for (int k = 0; k < std::lround(0.48 / h); ++k) {
      if (known)
        EXPECT_TRUE(step_along(path, body).converged);
      else {
        EXPECT_TRUE(body.move_to(path.pose(body.time() + h)));
        EXPECT_TRUE(body.step().converged);
      }
    }
    return body.state().q;
  };
  const VectorXd exact = orbit(1.25e-4, true);
  const double coarse = (orbit(4e-3, false) - exact).norm(),
               fine = (orbit(2e-3, false) - exact).norm();
  EXPECT_LE(fine, 2e-2 * exact.norm());
  EXPECT_GE(std::log2(coarse / fine), 1.7);
}

TEST(DrivenBody, FrameThatStandsStillCostsNoBit) {
  const Model::Pointer model = frame_model(5, false, 14.0, 90.0);
  for (const char* method : kDrivenMethods) {
    ContactBody fixed = make_framed(model, FrameKind::kFixed, {}, method);
    ContactBody driven = make_framed(model, FrameKind::kDriven, {}, method);
    for (ContactBody* body : {&fixed, &driven})
      ASSERT_TRUE(
          body->set_state(testing::random_vector(5, 0.02, 1), testing::random_vector(5, 0.3, 2)));
    steps_of(fixed, 200);
    steps_of(driven, 200);
    EXPECT_EQ(fixed.state().q, driven.state().q) << method;
    EXPECT_EQ(fixed.state().p, driven.state().p) << method;
  }
}

TEST(FixedBody, TakesTheBitsOfItsIntegratorAlone) {
  const Model::Pointer model = frame_model(5, false, 14.0, 90.0);
  for (const std::string_view method : integrator_names()) {
    ContactBody body = make_framed(model, FrameKind::kFixed, {.step = 1e-3}, method);
    ASSERT_TRUE(body.add_default_load({.kind = SignalKind::kSine}, 0.3));
    const std::unique_ptr<Integrator> alone = testing::make(method, model, {.step = 1e-3});
    const std::vector<Load> loads = {
        {{.kind = SignalKind::kSine}, *reduce_load(*model, model->default_load(), 0.3)}};
    State state{VectorXd::Zero(5), VectorXd::Zero(5)};
    testing::run(*alone, state, loads, 1e-3, 300);
    steps_of(body, 300);
    EXPECT_EQ(body.state().q, state.q) << method;
    EXPECT_EQ(body.state().p, state.p) << method;
  }
}

TEST(FixedBody, HangsInGravityAsItShould) {
  // A linear model at rest under gravity: Lambda q = s^T g.
  const Model::Pointer model = frame_model(4, false, 14.0, 90.0, 0.0);
  const Vector3d gravity(0.5, 1.0, -9.81);
  const VectorXd push = model->inertia()->linear.topRows<3>().transpose() * gravity;
  const VectorXd hanging = push.cwiseQuotient(model->lambda());
  for (const char* method : kDrivenMethods) {
    ContactBody body = make_framed(model, FrameKind::kFixed, {.alpha = 8.0}, method);
    ASSERT_TRUE(body.set_gravity(gravity));
    steps_of(body, 3000);
    EXPECT_LE((body.state().q - hanging).norm(), 1e-6 * hanging.norm()) << method;
    EXPECT_NEAR(body.sums().gravity, push.dot(hanging), 1e-5 * push.dot(hanging)) << method;
  }
}

TEST(DrivenBody, StepsTakenInPartsKeepTheBalance) {
  // One iteration is not enough for such a deformation, so that steps are cut.
  ContactBody body = make_framed(frame_model(5, false, 14.0, 200.0, 1.0), FrameKind::kDriven,
                                 {.step = 3e-2, .tolerance = 1e-9, .max_iterations = 4}, "ep2");
  const MotionPath path = whirl();
  ASSERT_TRUE(body.set_pose(path.pose(0.0)));
  ASSERT_TRUE(body.set_state(testing::random_vector(5, 0.3, 1), testing::random_vector(5, 6.0, 2)));
  const double start = body.energy().total();
  double most = start;
  for (int k = 0; k < 100; ++k) {
    ASSERT_TRUE(step_along(path, body).converged);
    most = std::max(most, body.energy().total());
  }
  EXPECT_GT(body.counts().halved, 5);
  EXPECT_NEAR(body.energy().total() - start, body.sums().work, 1e-11 * most);
}

TEST(DrivenBody, StepThatFailsLeavesTheFrameWhereItWas) {
  ContactBody body = make_framed(frame_model(4, false, 14.0, 90.0), FrameKind::kDriven, {});
  const MotionPath path = whirl();
  ASSERT_TRUE(body.set_pose(path.pose(0.0)));
  for (int k = 0; k < 5; ++k) ASSERT_TRUE(step_along(path, body).converged);
  const Pose pose = body.pose();
  const State state = body.state();
  const double support = body.sums().support;
  ASSERT_TRUE(body.apply_force(5, {1e150, 0.0, 0.0}));
  EXPECT_FALSE(step_along(path, body).converged);
  EXPECT_EQ(body.pose().position, pose.position);
  EXPECT_EQ(body.pose().rotation.coeffs(), pose.rotation.coeffs());
  EXPECT_EQ(body.state().q, state.q);
  EXPECT_EQ(body.state().p, state.p);
  EXPECT_EQ(body.sums().support, support);
  body.clear_forces();
  EXPECT_TRUE(step_along(path, body).converged);
}

TEST(DrivenBody, RefusesWhatItCannotBe) {
  const auto refused = [](const Model::Pointer& model, std::string_view method) {
    const Result<ContactBody> body = ContactBody::create(model, method, {}, FrameKind::kDriven);
    EXPECT_FALSE(body) << method;
    return body ? std::string() : body.error().message;
  };
  const Model::Pointer held = frame_model(3, false, 12.0, 160.0);
  for (const std::string_view name : integrator_names()) {
    bool known = false;
    for (const char* method : kDrivenMethods) known = known || name == method;
    if (known) continue;
    const std::string why = refused(held, name);
    EXPECT_NE(why.find("'" + std::string(name) + "'"), std::string::npos) << why;
    EXPECT_NE(why.find("newmark and imexv"), std::string::npos) << why;
  }
  EXPECT_NE(refused(frame_model(3, true, 12.0, 160.0), "ep4").find("--fix"), std::string::npos);
  const testing::StrainModel strain =
      testing::random_strain_model(testing::spread_omega(3, 12.0, 90.0), 0.1, 1);
  BasisData old = testing::basis_of(testing::random_cloud(3, false, 3), strain, false);
  old.inertia.reset();
  const Model::Pointer without = *Model::from_data(old);
  EXPECT_NE(refused(without, "ep4").find("inertia integrals"), std::string::npos);
  ContactBody fixed = make_framed(without, FrameKind::kFixed, {});
  EXPECT_TRUE(fixed.set_gravity(Vector3d::Zero()));
  const Status gravity = fixed.set_gravity({0.0, 0.0, -9.81});
  ASSERT_FALSE(gravity);
  EXPECT_NE(gravity.error().message.find("inertia integrals"), std::string::npos);
  ContactBody body = make_framed(held, FrameKind::kDriven, {});
  EXPECT_FALSE(body.move_to({{NAN, 0.0, 0.0}, Eigen::Quaterniond::Identity()}));
  EXPECT_FALSE(body.move_to({Vector3d::Zero(), Eigen::Quaterniond(2.0, 0.0, 0.0, 0.0)}));
  EXPECT_FALSE(body.set_motion(Vector3d::Zero(), Vector3d::Zero()));
}

}  // namespace
}  // namespace tremolo
