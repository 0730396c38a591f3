// Contact between bodies: momenta, energy, and bodies that come to rest.
#include <array>
#include <cmath>
#include <filesystem>

#include <gtest/gtest.h>

#include "runtime/contact/islands/body_group.h"
#include "runtime/contact/solve/contact_step.h"
#include "runtime/contact_body.h"
#include "runtime/world/scene_world.h"
#include "tests/support/meshes/made_cube.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;
using testing::balance;

// Its middle at the mesh's origin; nothing holds it.
Model::Pointer box(const std::string& young) {
  return testing::made_cube("box-" + young, Vector3d::Constant(-0.05), young, "none");
}

struct Kind {
  double step = 1e-3;
  double restitution = 1.0;
  double friction = 0.0;
  double alpha = 0.0, beta = 0.0;
};

ContactBody boxed(const Model::Pointer& model, const Kind& kind, const Pose& pose) {
  IntegratorOptions options;
  options.step = kind.step;
  options.alpha = kind.alpha;
  options.beta = kind.beta;
  Result<ContactBody> body = ContactBody::create(model, "ep4", options, FrameKind::kFree);
  EXPECT_TRUE(body) << body.error().message;
  ContactOptions contact;
  contact.shape = BoxShape{Vector3d::Constant(0.05)};
  contact.friction = kind.friction;
  contact.restitution = kind.restitution;
  EXPECT_TRUE(body->set_contact(contact));
  EXPECT_TRUE(body->set_pose(pose));
  return std::move(*body);
}

Pose at(const Vector3d& place) {
  Pose pose;
  pose.position = place;
  return pose;
}

struct Sum {
  Vector3d linear = Vector3d::Zero(), angular = Vector3d::Zero();
  double energy = 0.0;
};

Sum sum_of(std::span<ContactBody* const> bodies) {
  Sum sum;
  for (const ContactBody* body : bodies) {
    sum.linear += body->momentum().linear;
    sum.angular += body->momentum().angular;
    sum.energy += body->energy().total() + body->contact_account().energy;
  }
  return sum;
}

// Two soft boxes hit each other off their middles and turning.
TEST(BodiesInContact, KeepBothMomentaAndTheEnergy) {
  for (const double friction : {0.0, 0.5}) {
    const Kind kind{.restitution = 1.0, .friction = friction};
    const Model::Pointer model = box("1e5");
    ContactBody left = boxed(model, kind, at({-0.09, 0.01, -0.02}));
    ContactBody right = boxed(model, kind, at({0.09, -0.01, 0.03}));
    ASSERT_TRUE(left.set_motion({1.0, 0.2, 0}, {2, 5, -1}));
    ASSERT_TRUE(right.set_motion({-0.8, 0, 0.1}, {-3, 1, 4}));
    const std::array<ContactBody*, 2> bodies = {&left, &right};
    std::array<StepReport, 2> reports;
    BodyGroup group;
    const Sum start = sum_of(bodies);
    const Vector3d before = left.momentum().linear;
    std::size_t touched = 0;
    double worst_linear = 0.0, worst_angular = 0.0, worst_energy = 0.0;
    for (int i = 0; i < 400; ++i) {
      group.step(bodies, {}, reports);
      ASSERT_TRUE(reports[0].converged && reports[1].converged) << i;
      touched += group.touches().size();
      const Sum now = sum_of(bodies);
      const double taken = left.contact_sums().lost + left.contact_sums().friction_loss +
                           right.contact_sums().lost + right.contact_sums().friction_loss;
      const double error = left.contact_sums().error + right.contact_sums().error;
      worst_linear = std::max(worst_linear, (now.linear - start.linear).norm());
      worst_angular = std::max(worst_angular, (now.angular - start.angular).norm());
      worst_energy = std::max(worst_energy, std::abs(now.energy + taken - error - start.energy));
    }
    EXPECT_GT(touched, 5U);
    EXPECT_GT((left.momentum().linear - before).norm(), 0.5);
    EXPECT_LT(worst_linear, 1e-12);
    EXPECT_LT(worst_angular, 1e-12);
    EXPECT_LT(worst_energy, 1e-9 * start.energy);
    const double error = std::abs(left.contact_sums().error) + std::abs(right.contact_sums().error);
    EXPECT_LT(error, 1e-9 * start.energy);
  }
}

// Equal masses that meet head-on: the one at rest moves on and the other stops.
TEST(BodiesInContact, ExchangeTheirMomentum) {
  const Kind kind{.step = 2e-4};
  const Model::Pointer model = box("1e10");
  ContactBody left = boxed(model, kind, at({-0.06, 0, 0})),
              right = boxed(model, kind, at({0.06, 0, 0}));
  ASSERT_TRUE(left.set_motion({1.0, 0, 0}, {0, 0, 0}));
  const std::array<ContactBody*, 2> bodies = {&left, &right};
  std::array<StepReport, 2> reports;
  BodyGroup group;
  for (int i = 0; i < 1'000; ++i) {
    group.step(bodies, {}, reports);
    ASSERT_TRUE(reports[0].converged && reports[1].converged) << i;
  }
  EXPECT_NEAR(left.rigid_state().velocity.x(), 0.0, 0.01);
  EXPECT_NEAR(right.rigid_state().velocity.x(), 1.0, 0.01);
}

// A bar of 0.04 x 0.04 x length m and 1000 kg/m^3 along z, its middle at the mesh's origin, in
// which waves run at 31.6 m/s. cells: along it.
Model::Pointer bar(double length, int cells) {
  static const std::string folder = fresh_folder();
  const std::string name = "bar-" + std::to_string(cells);
  TetMesh mesh = box_mesh({2, 2, cells}, {0.04, 0.04, length});
  for (Vector3d& x : mesh.vertices) x -= 0.5 * Vector3d(0.04, 0.04, length);
  testing::write_veg(folder + "/" + name + ".veg", mesh);
  const ProgramResult made =
      run_program(folder, kPrecompute + name +
                              ".veg --threads 1 --order 2 --young 1e6 --poisson 0 --density 1000 "
                              "--fix none --linear-modes 110 --linear -o " +
                              name + ".tremolo");
  EXPECT_EQ(made.code, 0) << made.err;
  Result<Model::Pointer> model = Model::load(folder + "/" + name + ".tremolo");
  EXPECT_TRUE(model) << model.error().message;
  return *model;
}

ContactBody free_bar(const Model::Pointer& model, double length, double middle) {
  Result<ContactBody> body = ContactBody::create(model, "ep4", {.step = 5e-5}, FrameKind::kFree);
  EXPECT_TRUE(body) << body.error().message;
  ContactOptions contact;
  contact.margin = 5e-4;                   // little relative to the impact's compression,
  contact.stiffness = 16.0 * 60.0 * 60.0;  // as its contact is, of 50 us instead of 3 ms
  contact.shape = BoxShape{{0.02, 0.02, 0.5 * length}};
  contact.friction = 0.0;
  contact.restitution = 1.0;
  EXPECT_TRUE(body->set_contact(contact));
  EXPECT_TRUE(body->set_pose(at({0, 0, middle})));
  return std::move(*body);
}

// Contact time of two bars, s. The lower one arrives with `speed`, m/s, and the measurement ends
// when they have been apart for 10 ms.
double time_of_impact(ContactBody& lower, ContactBody& upper, double speed) {
  EXPECT_TRUE(lower.set_motion({0, 0, speed}, Vector3d::Zero()));
  const std::array<ContactBody*, 2> bodies = {&lower, &upper};
  std::array<StepReport, 2> reports;
  BodyGroup group;
  double begin = 0.0, end = 0.0;
  for (int i = 0; begin == 0.0 || lower.time() < end + 0.01; ++i) {
    group.step(bodies, {}, reports);
    const bool made = reports[0].converged && reports[1].converged;
    EXPECT_TRUE(made && i < 3'000) << i;
    if (!made || i == 3'000) return 0.0;
    if (group.touches().empty()) continue;
    if (begin == 0.0) begin = lower.time();
    end = lower.time();
  }
  return end - begin;
}

// St. Venant's impact of two equal bars: they are in contact for 2 L/c, the arriving one stops, the
// other continues with its speed, and neither vibrates.
TEST(BodiesInContact, EqualBarsExchangeTheirMotionInTwoRunsOfTheWave) {
  const double length = 0.4, speed = 0.1, c = std::sqrt(1e6 / 1000.0);
  const Model::Pointer model = bar(length, 24);
  ContactBody lower = free_bar(model, length, 0.0), upper = free_bar(model, length, length + 0.004);
  const double touched = time_of_impact(lower, upper, speed);
  EXPECT_NEAR(touched, 2.0 * length / c, 0.05 * 2.0 * length / c);
  EXPECT_NEAR(lower.rigid_state().velocity.z(), 0.0, 0.03 * speed);
  EXPECT_NEAR(upper.rigid_state().velocity.z(), speed, 0.03 * speed);
  const double whole = 0.5 * 1000.0 * 0.04 * 0.04 * length * speed * speed;
  EXPECT_LT(lower.energy().total(), 0.06 * whole);
}

// The same for a bar that hits one of twice its length: it stops after 2 L/c, the long one
// continues with half of the speed, and half of the energy vibrates in it.
TEST(BodiesInContact, AShortBarStandsAndALongOneKeepsHalfOfTheEnergyAsVibration) {
  const double length = 0.4, speed = 0.1;
  ContactBody lower = free_bar(bar(length, 24), length, 0.0);
  ContactBody upper = free_bar(bar(2.0 * length, 48), 2.0 * length, 1.5 * length + 0.004);
  (void)time_of_impact(lower, upper, speed);
  EXPECT_NEAR(lower.rigid_state().velocity.z(), 0.0, 0.03 * speed);
  EXPECT_NEAR(upper.rigid_state().velocity.z(), 0.5 * speed, 0.03 * speed);
  const double mass = 1000.0 * 0.04 * 0.04 * length, whole = 0.5 * mass * speed * speed;
  EXPECT_LT(lower.energy().total(), 0.06 * whole);
  const double v = upper.rigid_state().velocity.z();
  EXPECT_NEAR(upper.energy().total() - mass * v * v, 0.5 * whole, 0.05 * whole);
}

TEST(BodiesInContact, AStackOfTenStandsForAMinuteAndSleeps) {
  const Kind kind{.step = 3e-3, .restitution = 0.2, .friction = 0.5, .alpha = 0.2, .beta = 1e-3};
  // A column of ten softer ones, E = 1e6, buckles under its own weight: Greenhill's height is 0.87
  // m.
  const Model::Pointer model = box("1e8");
  std::vector<ContactBody> boxes;
  for (int i = 0; i < 10; ++i) {
    boxes.push_back(boxed(model, kind, at({0.003 * (i % 2), 0, 0.052 + 0.102 * i})));
    ASSERT_TRUE(boxes.back().set_gravity({0, 0, -9.81}));
  }
  std::vector<ContactBody*> bodies;
  for (ContactBody& body : boxes) bodies.push_back(&body);
  std::vector<StepReport> reports(bodies.size());
  const std::vector<PlacedCollider> floor = {{PlaneShape{}, {}, {}, 0.5, 0.2}};
  BodyGroup group;
  int awake = 0;
  for (int steps = 0; steps < 20'000; ++steps) {
    group.step(bodies, floor, reports);
    for (const StepReport& report : reports) ASSERT_TRUE(report.converged) << steps;
    awake += group.asleep(0) ? 0 : 1;
  }
  EXPECT_LT(awake, 3'000);
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    EXPECT_TRUE(group.asleep(i));
    EXPECT_NEAR(boxes[i].rigid_state().centre.z(), 0.05 + 0.1 * static_cast<double>(i), 0.01) << i;
    EXPECT_NEAR(balance(boxes[i]), 0.0, 1e-9) << i;
  }
  // A push wakes them.
  ASSERT_TRUE(boxes[9].set_motion({0, 0, -1}, Vector3d::Zero()));
  group.wake(9);
  group.step(bodies, floor, reports);
  EXPECT_FALSE(group.asleep(0));
}

// Three boxes fly into each other in a scene: the result does not depend on their order in it.
Scene three_boxes(const std::array<int, 3>& order) {
  Scene scene;
  scene.step = 1e-3;
  scene.duration = 0.3;
  for (const int k : order) {
    SceneBody body;
    body.name = std::string("box-") + static_cast<char>('a' + k);
    body.model = "box";
    body.kind = FrameKind::kFree;
    body.pose = at({0.13 * k, 0.02 * k, 0.01 * k * k});
    body.velocity = {0.9 - 0.8 * k, 0.0, 0.05};
    body.spin = {1.0, 2.0 - k, 0.5 * k};
    body.contact.shape = BoxShape{Vector3d::Constant(0.05)};
    scene.bodies.push_back(body);
  }
  return scene;
}

Result<Model::Pointer> box_source(const SceneBody&) {
  return box("1e5");
}

TEST(BodiesInContact, DoNotDependOnTheirOrderInAScene) {
  std::array<Eigen::VectorXd, 3> first;
  for (const std::array<int, 3>& order :
       {std::array{0, 1, 2}, std::array{2, 0, 1}, std::array{1, 2, 0}}) {
    Result<SceneWorld> world = SceneWorld::create(three_boxes(order), box_source);
    ASSERT_TRUE(world) << world.error().message;
    int begun = 0, ended = 0;
    for (int i = 0; i < 300; ++i) {
      ASSERT_TRUE(world->step().empty()) << i;
      for (const ContactEvent& event : world->events()) {
        EXPECT_EQ(event.collider, ContactEvent::kNone);
        EXPECT_LT(event.body, event.other);
        EXPECT_GT(event.place.impulse, 0.0);
        Vector3d push = Vector3d::Zero();
        for (const ContactedPoint& point : world->points_of(event)) push += point.impulse;
        if (event.kind == ContactEvent::Kind::kBegin) {
          EXPECT_LT((push - event.place.push).norm(), 1e-12 * push.norm());
          // The normal points from the other one to the body.
          EXPECT_GT(event.place.normal.dot(world->body(event.body).rigid_state().centre -
                                           world->body(event.other).rigid_state().centre),
                    0.0);
        }
        (event.kind == ContactEvent::Kind::kBegin ? begun : ended) += 1;
      }
    }
    EXPECT_GE(begun, 2);
    EXPECT_LE(ended, begun);
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t k = order[i];
      const Eigen::VectorXd& q = world->body(i).state().q;
      if (first[k].size() == 0) first[k] = q;
      EXPECT_EQ(q, first[k]) << k;
      const EnergyAccount account = world->account(i);
      EXPECT_LT(std::abs(account.remainder()), 1e-9 * account.at_start);
    }
  }
}

TEST(BodiesInContact, MayNotBeginInsideEachOther) {
  Scene scene = three_boxes({0, 1, 2});
  scene.bodies[1].pose.position.x() = 0.05;
  const Result<SceneWorld> world = SceneWorld::create(scene, box_source);
  ASSERT_FALSE(world);
  EXPECT_NE(world.error().message.find("inside body 'box-"), std::string::npos)
      << world.error().message;
}

}  // namespace
}  // namespace tremolo
