// Scenes with colliders and hands: energy balances that close, events, refusals.
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "runtime/contact/solve/contact_step.h"
#include "runtime/world/scene_world.h"
#include "tests/support/frames/frame_scenes.h"
#include "tests/support/small_collider.h"
#include "tests/support/temporary_folder.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kFall = 9.81;

Result<Model::Pointer> cloud_model(const SceneBody& body) {
  return testing::cloud_file(body, 60.0, 300.0);
}

SceneBody cloud_body(const std::string& name, FrameKind kind) {
  return testing::cloud_body(name, kind, 1e-3);
}

SceneCollider floor_at(double z) {
  SceneCollider floor;
  floor.name = "floor";
  floor.pose.position.z() = z;
  floor.friction = 0.3;
  floor.restitution = 0.6;
  return floor;
}

// A free body above a floor.
Scene dropped() {
  Scene scene;
  scene.step = 1e-3;
  scene.duration = 1.0;
  scene.gravity.values = {{0.0, 0.0, -kFall}};
  SceneBody thrown = cloud_body("thrown", FrameKind::kFree);
  thrown.pose = {{0.0, 0.0, 0.7}, turn_by({0.3, 0.2, 0.0})};
  thrown.velocity = {0.5, 0.0, 0.0};
  thrown.spin = {0.0, 2.0, 1.0};
  scene.bodies = {thrown};
  scene.colliders = {floor_at(-0.1)};
  return scene;
}

SceneHand hand_on(const std::string& body, const std::string& at) {
  SceneHand hand;
  hand.body = body;
  hand.at = at;
  hand.stiffness = 300.0;
  hand.damping = 2.0;
  return hand;
}

// With a sphere that moves into a fixed body, which a hand pulls.
Scene everything() {
  Scene scene = dropped();
  SceneBody held = cloud_body("held", FrameKind::kDriven);
  held.pose.position = {3.0, 0.0, 0.0};
  held.motion.parts.push_back(
      ShakeMotion{{0.02, 0.0, 0.0}, 2.0, {.start = 0.1, .end = 2.0, .ramp = 0.5}});
  scene.bodies.push_back(held);
  SceneCollider sphere;
  sphere.name = "sphere";
  sphere.shape = SphereShape{0.2};
  sphere.pose.position = {5.0, 0.0, 0.1};
  sphere.motion.parts.push_back(GlideMotion{{-2.0, 0.0, 0.0}, {0.0, 0.75, 0.1}});
  scene.colliders.push_back(sphere);
  SceneHand hand = hand_on("held", "7");
  hand.from = 0.1;
  hand.until = 0.7;
  hand.motion.parts.push_back(ShakeMotion{{0.0, 0.05, 0.0}, 3.0, {0.1, 2.0, 0.2}});
  SceneHand other = hand_on("thrown", "5");
  other.position = Vector3d(0.2, 0.0, 1.0);
  other.from = 0.6;
  scene.hands = {hand, other};
  return scene;
}

SceneWorld touching_world(const Scene& scene) {
  Result<SceneWorld> world = SceneWorld::create(scene, cloud_model);
  EXPECT_TRUE(world) << (world ? "" : world.error().message);
  return std::move(*world);
}

void expect_refusal(const Scene& scene, const std::string& words,
                    ErrorKind kind = ErrorKind::kContent) {
  const Result<SceneWorld> world = SceneWorld::create(scene, cloud_model);
  ASSERT_FALSE(world) << words;
  EXPECT_EQ(world.error().kind, kind) << world.error().message;
  EXPECT_NE(world.error().message.find(words), std::string::npos) << world.error().message;
}

// Contact is solved to 1e-10 of the momenta in a step, over a thousand steps.
TEST(SceneContact, AccountsCloseWithEverythingAtOnce) {
  SceneWorld world = touching_world(everything());
  std::vector<double> most(world.size(), 0.0);
  for (int k = 0; k < 1'000; ++k) {
    const auto failed = world.step();
    ASSERT_TRUE(failed.empty()) << failure_message(failed[0].report, world.time()) << " of body "
                                << failed[0].body;
    for (std::size_t i = 0; i < world.size(); ++i) {
      const EnergyAccount account = world.account(i);
      most[i] = std::max(most[i], account.total());
      ASSERT_LE(std::abs(account.remainder()), 1e-8 * most[i]) << world.name(i) << " " << k;
    }
  }
  const EnergyAccount thrown = world.account(0), held = world.account(1);
  EXPECT_LT(thrown.restitution, 0.0);
  EXPECT_LT(thrown.friction, 0.0);
  EXPECT_NE(thrown.hand, 0.0);
  EXPECT_LE(std::abs(thrown.contact_error), 1e-9 * most[0]);
  EXPECT_NE(held.contact_given, 0.0);
  EXPECT_NE(held.hand, 0.0);
  EXPECT_NE(held.support, 0.0);
  EXPECT_GT(world.contacts(0), 0);
  EXPECT_GT(world.contacts(1), 0);
  // A fall from 0.8 m with 4 m/s, within a contact of some milliseconds, whatever the step.
  EXPECT_LT(world.penetration_max(0), 0.03);
}

TEST(SceneContact, StepsAreThoseOfABodyAmongTheSameColliders) {
  const Scene scene = dropped();
  SceneWorld world = touching_world(scene);
  IntegratorOptions options = scene.bodies[0].options;
  options.step = scene.step;
  ContactBody body =
      testing::make_framed(world.body(0).model().shared_from_this(), FrameKind::kFree, options);
  ASSERT_TRUE(body.set_contact());
  ASSERT_TRUE(body.set_gravity(scene.gravity.values[0]));
  ASSERT_TRUE(body.set_pose(world.body(0).pose()));
  ASSERT_TRUE(body.set_motion(scene.bodies[0].velocity, world.body(0).rigid_state().spin));
  const Pose at{Vector3d(0.0, 0.0, -0.1), Eigen::Quaterniond::Identity()};
  const std::vector<PlacedCollider> floor = {{PlaneShape{}, at, at, 0.3, 0.6}};
  for (int k = 0; k < 600; ++k) {
    ASSERT_TRUE(world.step().empty());
    ASSERT_TRUE(body.step(floor).converged);
  }
  EXPECT_GT(world.contacts(0), 0);
  EXPECT_EQ(world.body(0).state().q, body.state().q);
  EXPECT_EQ(world.body(0).pose().position, body.pose().position);
  EXPECT_EQ(world.account(0).restitution, 0.0 - body.contact_sums().lost);
}

TEST(SceneContact, BodyBouncesOnAMeshFromItsFile) {
  const std::string folder = testing::fresh_folder();
  ASSERT_TRUE(write_collider(folder + "/ball.collider", testing::small_collider()));
  Scene scene = dropped();
  scene.colliders[0].file = folder + "/ball.collider";
  scene.colliders[0].pose.position.z() = -1.0;  // a ball of radius 1
  SceneWorld world = touching_world(scene);
  double most = 0.0;
  for (int k = 0; k < 700; ++k) {
    ASSERT_TRUE(world.step().empty()) << k;
    const EnergyAccount account = world.account(0);
    most = std::max(most, account.total());
    ASSERT_LE(std::abs(account.remainder()), 1e-8 * most) << k;
  }
  EXPECT_GT(world.contacts(0), 0);
  EXPECT_GT(world.body(0).pose().position.z(), -1.0);
}

TEST(SceneContact, CollidersAreWhereTheirMotionSays) {
  const Scene scene = everything();
  SceneWorld world = touching_world(scene);
  const SceneCollider& sphere = scene.colliders[1];
  const MotionPath path = *MotionPath::create(sphere.motion, sphere.pose);
  for (int k = 0; k < 300; ++k) {
    const double before = world.time();
    world.step();
    EXPECT_EQ(world.colliders()[1].start.position, path.pose(before).position);
    EXPECT_EQ(world.colliders()[1].end.position, path.pose(world.time()).position);
  }
}

// Without friction a plane pushes along its normal alone.
TEST(SceneContact, EventsBeginAndEndAndTheirImpulsesAreTheChangeOfMomentum) {
  Scene scene = dropped();
  scene.colliders[0].friction = 0.0;
  scene.colliders[0].restitution = 1.0;
  SceneWorld world = touching_world(scene);
  const double start = world.body(0).momentum().linear.z();
  const double mass = world.body(0).model().inertia()->mass;
  bool touching = false;
  double impulse = 0.0;
  int begun = 0;
  for (int k = 0; k < 3'000 && (k < 1'000 || touching); ++k) {
    ASSERT_TRUE(world.step().empty());
    for (const ContactEvent& event : world.events()) {
      EXPECT_EQ(event.body, 0U);
      EXPECT_EQ(event.collider, 0U);
      EXPECT_EQ(event.kind == ContactEvent::Kind::kBegin, !touching);
      EXPECT_GT(event.place.impulse, 0.0);
      touching = event.kind == ContactEvent::Kind::kBegin;
      begun += touching ? 1 : 0;
      if (!touching) impulse += event.place.impulse;
      EXPECT_LT((event.place.normal - Vector3d::UnitZ()).norm(), 1e-9);
      EXPECT_NEAR(event.place.push.z(), event.place.impulse, 1e-6 * event.place.impulse);
      const std::vector<ContactedPoint> points = world.points_of(event);
      EXPECT_EQ(points.empty(), !touching);
      Vector3d push = Vector3d::Zero(), low = event.place.position, high = low;
      for (const ContactedPoint& point : points) {
        push += point.impulse;
        low = low.cwiseMin(point.position);
        high = high.cwiseMax(point.position);
      }
      if (touching) {
        EXPECT_LT((push - event.place.push).norm(), 1e-12 * push.norm());
      }
      // A mean of the points lies among them.
      EXPECT_TRUE((event.place.position - low).minCoeff() >= 0.0);
      EXPECT_TRUE((high - event.place.position).minCoeff() >= 0.0);
    }
  }
  EXPECT_GT(begun, 1);
  EXPECT_EQ(begun, world.contacts(0));
  const double change = world.body(0).momentum().linear.z() - start;
  EXPECT_NEAR(impulse, change + mass * kFall * world.time(), 1e-9 * impulse);
}

TEST(SceneContact, HandHoldsFromItsTimeUntilItsTime) {
  Scene scene;
  scene.step = 1e-3;
  scene.bodies = {cloud_body("held", FrameKind::kFixed)};
  SceneHand hand = hand_on("held", "7");
  hand.from = 0.05;
  hand.until = 0.4;
  KeyframeMotion keys;
  keys.keys = {{0.0, {}}, {0.2, {Vector3d(0.0, 0.01, 0.0), Eigen::Quaterniond::Identity()}}};
  hand.motion.parts.push_back(keys);
  scene.hands = {hand};
  SceneWorld world = touching_world(scene);
  const Vector3d rest = *world.body(0).position(7);
  for (int k = 0; k < 50; ++k) {
    world.step();
    ASSERT_FALSE(world.hand(0).holds());
    ASSERT_TRUE(world.hand_force(0).isZero(0.0));
  }
  EXPECT_TRUE(world.body(0).state().q.isZero(0.0));
  for (int k = 0; k < 350; ++k) {
    world.step();
    ASSERT_TRUE(world.hand(0).holds());
  }
  EXPECT_GT(world.hand_force(0).y(), 0.0);
  EXPECT_GT((*world.body(0).position(7) - rest).y(), 0.0);
  const double work = world.account(0).hand;
  EXPECT_GT(work, 0.0);
  for (int k = 0; k < 50; ++k) world.step();
  EXPECT_FALSE(world.hand(0).holds());
  EXPECT_TRUE(world.hand_force(0).isZero(0.0));
  EXPECT_EQ(world.account(0).hand, work);
  EXPECT_LE(std::abs(world.account(0).remainder()), 1e-10 * work);
}

// In its first step the hand goes from the vertex to its own position.
TEST(SceneContact, HandAtAPlacePullsAsItsSpringAndDamperDo) {
  Scene scene = dropped();
  scene.gravity.values.clear();
  scene.colliders.clear();
  SceneHand hand = hand_on("thrown", "5");
  hand.position = Vector3d(1.0, 2.0, 3.0);
  scene.hands = {hand};
  SceneWorld world = touching_world(scene);
  Vector3d from = Vector3d::Zero(), momentum = world.body(0).momentum().linear;
  for (int k = 0; k < 300; ++k) {
    ASSERT_TRUE(world.step().empty());
    const Vector3d to = *world.body(0).position(5) - *hand.position;
    const Vector3d expected =
        -0.5 * hand.stiffness * (from + to) - hand.damping / scene.step * (to - from);
    ASSERT_LE((world.hand_force(0) - expected).norm(), 1e-8 * expected.norm()) << k;
    momentum += scene.step * world.hand_force(0);
    ASSERT_LE((world.body(0).momentum().linear - momentum).norm(), 1e-9 * momentum.norm()) << k;
    from = to;
  }
}

TEST(SceneContact, BodyThatFeelsNoContactFallsThroughTheFloor) {
  Scene scene = dropped();
  scene.bodies[0].feels_contact = false;
  SceneWorld world = touching_world(scene);
  for (int k = 0; k < 1'000; ++k) world.step();
  EXPECT_LT(world.body(0).pose().position.z(), -3.0);
  EXPECT_EQ(world.contacts(0), 0);
  EXPECT_TRUE(world.events().empty());
}

TEST(SceneContact, BodyMayBeginWithinTheMargin) {
  Scene scene = dropped();
  std::vector<double> places(3 * 12);
  const SceneWorld before = touching_world(scene);
  ASSERT_TRUE(before.body(0).surface_positions(places, SurfaceKind::kBoundary));
  double lowest = places[2];
  for (std::size_t i = 2; i < places.size(); i += 3) lowest = std::min(lowest, places[i]);
  const double margin = before.body(0).contact()->surface().law.margin;
  scene.colliders[0].pose.position.z() = lowest + 0.5 * margin;
  SceneWorld world = touching_world(scene);
  // Its contact begins where it is, with no energy that nobody put in.
  EXPECT_EQ(world.account(0).contact, 0.0);
  EXPECT_EQ(world.account(0).remainder(), 0.0);
  double most = 0.0;
  for (int k = 0; k < 100; ++k) {
    ASSERT_TRUE(world.step().empty());
    const EnergyAccount account = world.account(0);
    most = std::max(most, account.total());
    ASSERT_LE(std::abs(account.remainder()), 1e-9 * most);
    ASSERT_LE(std::abs(account.contact_error), 1e-9 * most);
  }
  scene.colliders[0].pose.position.z() = lowest + 0.05;
  expect_refusal(scene, "body 'thrown': it begins 0.05 m (");
  expect_refusal(scene, "inside collider 'floor', more than its contact-margin of ");
  scene.bodies[0].feels_contact = false;
  EXPECT_TRUE(SceneWorld::create(scene, cloud_model));
}

TEST(SceneContact, OrderOfCollidersAndHandsAndOtherBodiesChangeNoBitOfAccounts) {
  const Scene scene = everything();
  Scene turned = scene;
  std::swap(turned.bodies[0], turned.bodies[1]);
  std::swap(turned.hands[0], turned.hands[1]);
  SceneWorld one = touching_world(scene), other = touching_world(turned);
  for (int k = 0; k < 400; ++k) {
    one.step();
    other.step();
  }
  for (std::size_t i = 0; i < one.size(); ++i) {
    const std::size_t j = *other.find(one.name(i));
    EXPECT_EQ(one.body(i).state().q, other.body(j).state().q) << one.name(i);
    EXPECT_EQ(one.account(i).contact_given, other.account(j).contact_given);
  }
}

// A ball of a point cloud shot at a plate, so fast that it would be behind it a step later.
Scene shot(double speed) {
  Scene scene = dropped();
  scene.gravity = {};
  scene.bodies[0].velocity = {0.0, 0.0, -speed};
  scene.bodies[0].spin.setZero();
  scene.bodies[0].contact.restitution = 0.0;
  scene.bodies[0].contact.points = 12;
  SceneCollider& plate = scene.colliders[0];
  plate.name = "plate";
  plate.shape = BoxShape{{3.0, 3.0, 0.01}};
  return scene;
}

TEST(SceneContact, APlateStopsWhatWouldBeBehindItWithinAStep) {
  Result<SceneWorld> slow = SceneWorld::create(shot(2.0), cloud_model);
  Result<SceneWorld> fast = SceneWorld::create(shot(100.0), cloud_model);
  ASSERT_TRUE(slow && fast);
  EXPECT_DOUBLE_EQ(slow->contact_speed_limit(), 10.0);
  for (int k = 0; k < 500; ++k) {
    ASSERT_TRUE(slow->step().empty());
    ASSERT_TRUE(fast->step().empty());
  }
  EXPECT_GT(slow->contacts(0), 0);
  EXPECT_EQ(slow->passed_through(0), 0);
  EXPECT_LT(slow->contact_speed_max(0), slow->contact_speed_limit());
  EXPECT_GT(slow->body(0).pose().position.z(), -0.1);
  EXPECT_EQ(fast->passed_through(0), 0);
  EXPECT_GT(fast->contact_speed_max(0), fast->contact_speed_limit());
  EXPECT_GT(fast->body(0).pose().position.z(), 0.0);
}

// Neither the body that is pulled beyond all numbers nor the body in contact with it has moved.
TEST(SceneContact, AnIslandThatIsNotSolvedStaysWhereItWas) {
  Scene scene = dropped();
  scene.bodies[0].spin.setZero();
  scene.bodies[0].pose.rotation.setIdentity();
  scene.bodies[0].pose.position = {0.0, 0.0, 0.0};
  scene.bodies[0].contact.shape = BoxShape{{0.4, 0.25, 0.15}};
  SceneBody other = scene.bodies[0];
  other.name = "other";
  other.pose.position.z() = 0.5;
  scene.bodies.push_back(other);
  other.name = "far";
  other.pose.position = {5.0, 0.0, 1.0};
  scene.bodies.push_back(other);
  Result<SceneWorld> world = SceneWorld::create(scene, cloud_model);
  ASSERT_TRUE(world) << world.error().message;
  const auto touch = [&] {
    for (const ContactEvent& event : world->events())
      if (event.collider == ContactEvent::kNone && event.kind == ContactEvent::Kind::kBegin)
        return true;
    return false;
  };
  int k = 0;
  for (; k < 1'000 && !touch(); ++k) ASSERT_TRUE(world->step().empty()) << k;
  ASSERT_LT(k, 1'000);
  const auto thrown = *world->find("thrown"), above = *world->find("other");
  const State one = world->body(thrown).state(), two = world->body(above).state();
  const Pose pose = world->body(above).pose();
  const double energy = world->account(above).total();
  ASSERT_TRUE(world->body(thrown).apply_force(5, {1e150, 0.0, 0.0}));
  EXPECT_EQ(world->step().size(), 2U);
  EXPECT_EQ(world->body(thrown).state().q, one.q);
  EXPECT_EQ(world->body(thrown).state().p, one.p);
  EXPECT_EQ(world->body(above).state().q, two.q);
  EXPECT_EQ(world->body(above).state().p, two.p);
  EXPECT_EQ(world->body(above).pose().position, pose.position);
  EXPECT_EQ(world->account(above).total(), energy);
  EXPECT_FALSE(world->failed(*world->find("far")));
  EXPECT_TRUE(world->step().empty());
}

TEST(SceneContact, RefusesCollidersThatAreNone) {
  const auto with = [](const auto& change) {
    Scene scene = dropped();
    change(scene.colliders[0]);
    return scene;
  };
  using C = SceneCollider;
  expect_refusal(with([](C& c) { c.name.clear(); }), "a collider has no name");
  expect_refusal(with([](C& c) { c.shape = SphereShape{-1.0}; }), "collider 'floor': ");
  expect_refusal(with([](C& c) { c.shape = SphereShape{kNaN}; }), "radius");
  expect_refusal(with([](C& c) { c.shape = BoxShape{{1.0, 0.0, 1.0}}; }), "half");
  expect_refusal(with([](C& c) { c.shape = GridShape{}; }), "grid");
  expect_refusal(with([](C& c) { c.friction = -0.1; }), "friction is -0.1");
  expect_refusal(with([](C& c) { c.friction = kNaN; }), "friction");
  expect_refusal(with([](C& c) { c.restitution = 1.01; }), "restitution is 1.01");
  expect_refusal(with([](C& c) { c.restitution = kNaN; }), "restitution");
  expect_refusal(with([](C& c) { c.pose.position.x() = kNaN; }), "the pose is not finite");
  expect_refusal(with([](C& c) {
                   c.motion.parts.push_back(GlideMotion{{kNaN, 0, 0}, {}});
                 }),
                 "collider 'floor': ");
  KeyframeMotion jump;
  jump.interpolation = Interpolation::kLinear;
  const Eigen::Quaterniond upright = Eigen::Quaterniond::Identity();
  jump.keys = {{0.5, {Vector3d(0.0, 0.0, 0.0), upright}},
               {0.5, {Vector3d(0.0, 0.0, 1.0), upright}}};
  expect_refusal(with([&](C& c) { c.motion.parts.push_back(jump); }),
                 "collider 'floor': its pose jumps at t = 0.5 s");
  Scene scene = dropped();
  scene.colliders.push_back(scene.colliders[0]);
  expect_refusal(scene, "two colliders are named 'floor'");
  scene = dropped();
  scene.colliders[0].file = "nowhere/rock.collider";
  expect_refusal(scene,
                 "collider 'floor': nowhere/rock.collider: there is no such collider file; make it "
                 "with `tremolo-precompute collider SURFACE -o nowhere/rock.collider`",
                 ErrorKind::kSystem);
  scene.colliders[0].made_by = "./demo";
  expect_refusal(scene, "make it with `./demo`", ErrorKind::kSystem);
}

TEST(SceneContact, RefusesHandsThatHoldNothing) {
  const auto with = [](const auto& change) {
    Scene scene = everything();
    change(scene.hands[0]);
    return scene;
  };
  using H = SceneHand;
  expect_refusal(with([](H& h) { h.body = "nobody"; }), "hand 1: body: there is no body 'nobody'");
  expect_refusal(with([](H& h) { h.at.clear(); }), "hand 1: at: it is empty");
  expect_refusal(with([](H& h) { h.at = "x>-9"; }), "is 12 vertices, a hand holds one");
  expect_refusal(with([](H& h) { h.at = "999"; }), "hand 1: at: ");
  expect_refusal(with([](H& h) { h.at = "0"; }), "the vertex does not move, it is fixed");
  expect_refusal(with([](H& h) { h.stiffness = 0.0; }), "stiffness must be positive");
  expect_refusal(with([](H& h) { h.damping = kNaN; }), "damping must be finite");
  expect_refusal(with([](H& h) { h.from = -1.0; }), "from must be finite and not negative");
  expect_refusal(with([](H& h) { h.until = h.from; }), "until must be behind from");
  expect_refusal(with([](H& h) { h.position = Vector3d(kNaN, 0, 0); }), "position is not finite");
}

TEST(SceneContact, RefusesMethodsThatContactDoesNotGoWith) {
  Scene scene = everything();
  scene.bodies[1].integrator = "newmark";
  expect_refusal(scene, "body 'held': integrator: ");
  expect_refusal(scene, "contact = false");
  scene.bodies[1].feels_contact = false;
  expect_refusal(scene, "body 'held': integrator: ");  // a hand is on it
  scene.hands.clear();
  EXPECT_TRUE(SceneWorld::create(scene, cloud_model));
  const auto with = [](const auto& change) {
    Scene changed = dropped();
    change(changed.bodies[0].contact);
    return changed;
  };
  using C = ContactOptions;
  expect_refusal(with([](C& c) { c.points = 0; }),
                 "body 'thrown': contact-points must be at least 1");
  expect_refusal(with([](C& c) { c.margin = kNaN; }), "contact-margin must be above 0");
  expect_refusal(with([](C& c) { c.stiffness = 0.0; }), "contact-stiffness must be positive");
  expect_refusal(with([](C& c) { c.friction = -0.1; }), "body 'thrown': friction is -0.1");
  expect_refusal(with([](C& c) { c.friction = kNaN; }), "friction is nan");
  expect_refusal(with([](C& c) { c.restitution = 1.01; }), "restitution is 1.01");
  expect_refusal(with([](C& c) { c.restitution = kNaN; }), "restitution is nan");
}

}  // namespace
}  // namespace tremolo
