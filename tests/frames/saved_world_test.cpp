// Worlds and bodies that are saved and put back: the same bits, or a refusal that changes nothing.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "common/hash.h"
#include "common/state_stream.h"
#include "formats/saved/saved_file.h"
#include "runtime/contact/solve/contact_step.h"
#include "runtime/world/scene_world.h"
#include "tests/support/frames/frame_models.h"
#include "tests/support/temporary_folder.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

// linear: the third letter of the model's name.
Result<Model::Pointer> saved_model(const SceneBody& body) {
  const bool free = body.model.starts_with("free");
  const double nonlinearity = body.model.ends_with("linear") ? 0.0 : 0.3;
  return testing::frame_model(5, free, 60.0, 300.0, nonlinearity, free ? 3 : 4);
}

SceneBody body_of(const std::string& name, FrameKind kind, const std::string& method) {
  SceneBody body;
  body.name = name;
  body.kind = kind;
  body.model = kind == FrameKind::kFree ? "free" : "held";
  body.integrator = method;
  return body;
}

// Bodies that fall on each other, one that shakes, one that is fixed and loaded; a hand, and a
// collider that moves. Every method of the energy-preserving family is there, damped and not.
Scene crowded() {
  Scene scene;
  scene.step = 1e-3;
  scene.gravity.times = {0.0, 0.3, 0.6};
  scene.gravity.values = {{0.0, 0.0, -9.81}, {0.0, 1.0, -9.81}, {0.0, 0.0, -9.0}};
  const std::vector<std::string> methods = {"ep4", "avf", "ep2"};
  for (int k = 0; k < 3; ++k) {
    SceneBody stone = body_of("stone" + std::to_string(k), FrameKind::kFree, methods[k]);
    stone.options.beta = k == 1 ? 0.0 : 1e-3;
    stone.pose = {{0.02 * k, 0.0, 0.6 + 0.8 * k}, turn_by({0.3 * k, 0.2, 0.0})};
    stone.spin = {0.0, 1.0, 0.2};
    stone.contact.shape = BoxShape{{0.4, 0.25, 0.15}};
    scene.bodies.push_back(stone);
  }
  SceneBody held = body_of("held", FrameKind::kDriven, "ep4");
  held.pose.position = {3.0, 0.0, 0.0};
  held.motion.parts = {SpinMotion{{0, 0, 1}, {3, 0, 0}, 2.0, {0.1, 2.0, 0.3}}};
  SceneLoad load;
  load.signal = {.kind = SignalKind::kSquare};
  held.loads = {load};
  scene.bodies.push_back(held);
  SceneCollider floor;
  floor.name = "floor";
  floor.pose.position.z() = -0.1;
  SceneCollider ball;
  ball.name = "ball";
  ball.shape = SphereShape{0.2};
  ball.pose.position = {4.2, 0.0, 0.1};
  ball.motion.parts.push_back(GlideMotion{{-1.0, 0.0, 0.0}, {0.0, 0.75, 0.1}});
  scene.colliders = {floor, ball};
  SceneHand hand;
  hand.body = "held";
  hand.at = "7";
  hand.stiffness = 300.0;
  hand.damping = 2.0;
  hand.from = 0.1;
  hand.until = 0.3;
  hand.motion.parts.push_back(ShakeMotion{{0.0, 0.05, 0.0}, 3.0, {0.1, 2.0, 0.2}});
  scene.hands = {hand};
  return scene;
}

SceneWorld saved_world_of(const Scene& scene) {
  Result<SceneWorld> world = SceneWorld::create(scene, saved_model);
  EXPECT_TRUE(world) << (world ? "" : world.error().message);
  return std::move(*world);
}

void run(SceneWorld& world, int steps) {
  for (int k = 0; k < steps; ++k) (void)world.step();
}

// All saved state, and all queries, bit for bit.
void expect_same(SceneWorld& a, SceneWorld& b) {
  EXPECT_EQ(state_bytes(a), state_bytes(b));
  EXPECT_EQ(a.steps(), b.steps());
  ASSERT_EQ(a.events().size(), b.events().size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a.body(i).state().q, b.body(i).state().q);
    EXPECT_EQ(a.body(i).pose().position, b.body(i).pose().position);
    EXPECT_EQ(a.account(i).total(), b.account(i).total());
    EXPECT_EQ(a.account(i).remainder(), b.account(i).remainder());
    EXPECT_EQ(a.contacts(i), b.contacts(i));
    EXPECT_EQ(a.asleep(i), b.asleep(i));
  }
  for (std::size_t k = 0; k < a.scene().hands.size(); ++k)
    EXPECT_EQ(a.hand_force(k), b.hand_force(k));
}

TEST(SavedWorld, GoesOnWithTheSameBits) {
  const Scene scene = crowded();
  SceneWorld straight = saved_world_of(scene);
  int done = 0;
  for (const int cut : {0, 1, 50, 150, 299, 301, 420, 700}) {
    run(straight, cut - done);
    done = cut;
    const std::vector<std::byte> bytes = straight.save();
    SceneWorld fresh = saved_world_of(scene);
    Status restored = fresh.restore(bytes);
    ASSERT_TRUE(restored) << restored.error().message;
    expect_same(straight, fresh);
    // A world that is somewhere else, ahead or behind.
    SceneWorld other = saved_world_of(scene);
    run(other, 350);
    ASSERT_TRUE(other.restore(bytes));
    SceneWorld reference = saved_world_of(scene);
    run(reference, cut);
    for (int k = 0; k < 120; ++k) {
      run(fresh, 1);
      run(other, 1);
      run(reference, 1);
    }
    expect_same(reference, fresh);
    expect_same(reference, other);
  }
  std::int64_t contacts = 0;
  for (std::size_t i = 0; i < straight.size(); ++i) contacts += straight.contacts(i);
  EXPECT_GT(contacts, 3);
}

TEST(SavedWorld, ThoseThatSleepGoOnSleeping) {
  Scene scene = crowded();
  scene.gravity = {};
  scene.gravity.values = {{0.0, 0.0, -9.81}};
  scene.bodies.resize(2);
  scene.hands.clear();
  scene.colliders.resize(1);
  scene.colliders[0].restitution = 0.0;
  scene.step = 2e-3;
  for (SceneBody& body : scene.bodies) {
    body.options.beta = 5e-3;
    body.spin.setZero();
    body.contact.restitution = 0.0;
  }
  scene.bodies[1].pose.position = {2.0, 0.0, 0.6};
  SceneWorld straight = saved_world_of(scene);
  for (int k = 0; k < 20'000 && !(straight.asleep(0) && straight.asleep(1)); ++k) run(straight, 1);
  ASSERT_TRUE(straight.asleep(0) && straight.asleep(1));
  SceneWorld fresh = saved_world_of(scene);
  ASSERT_TRUE(fresh.restore(straight.save()));
  // Something wakes one of them.
  for (SceneWorld* world : {&straight, &fresh}) {
    run(*world, 10);
    EXPECT_TRUE(world->asleep(0));
    ASSERT_TRUE(world->body(0).apply_force(5, {0.0, 0.0, 30.0}, 7));
    run(*world, 300);
  }
  expect_same(straight, fresh);
}

// Forces that still act come along; a world whose bodies got other loads is refused.
TEST(SavedWorld, ForcesComeAlongAndOtherLoadsAreRefused) {
  const Scene scene = crowded();
  SceneWorld straight = saved_world_of(scene);
  run(straight, 20);
  ASSERT_TRUE(straight.body(0).apply_force(4, {1.0, 2.0, 3.0}, 30));
  ASSERT_TRUE(straight.body(3).apply_force(4, {1.0, 2.0, 3.0}, 40));
  run(straight, 5);
  const std::vector<std::byte> bytes = straight.save();
  SceneWorld fresh = saved_world_of(scene);
  ASSERT_TRUE(fresh.restore(bytes));
  run(straight, 60);
  run(fresh, 60);
  expect_same(straight, fresh);
  SceneWorld loaded = saved_world_of(scene);
  ASSERT_TRUE(loaded.body(3).add_load({.kind = SignalKind::kSine}, 4, {1.0, 0.0, 0.0}));
  run(loaded, 3);
  const std::string before = state_bytes(loaded);
  const Status refused = loaded.restore(bytes);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("other loads"), std::string::npos);
  EXPECT_EQ(state_bytes(loaded), before);
}

void expect_refused(SceneWorld& world, std::span<const std::byte> bytes, const std::string& words) {
  const std::string before = state_bytes(world);
  const Status refused = world.restore(bytes);
  ASSERT_FALSE(refused) << words;
  EXPECT_EQ(refused.error().kind, ErrorKind::kContent);
  EXPECT_NE(refused.error().message.find(words), std::string::npos) << refused.error().message;
  EXPECT_EQ(state_bytes(world), before);
}

TEST(SavedWorld, AnotherSceneIsToldByWhatDiffers) {
  const Scene scene = crowded();
  SceneWorld saved = saved_world_of(scene);
  run(saved, 30);
  const std::vector<std::byte> bytes = saved.save();
  const auto refused = [&bytes](const Scene& other, const std::string& words) {
    SceneWorld world = saved_world_of(other);
    run(world, 5);
    expect_refused(world, bytes, words);
  };
  Scene other = scene;
  other.gravity.values[1].x() = 0.1;
  refused(other, "another step or gravity");
  other = scene;
  other.bodies[1].options.beta = 2e-3;
  refused(other, "another body 'stone1'");
  other = scene;
  other.bodies[2].model = "free linear";
  refused(other, "another body 'stone2'");
  other = scene;
  other.colliders[1].friction = 0.25;
  refused(other, "another collider 'ball'");
  other = scene;
  other.hands[0].motion = {};
  refused(other, "another hand 1");
  other = scene;
  other.hands.clear();
  refused(other, "with hand 1, which is not here");
  other = scene;
  other.bodies.push_back(body_of("new", FrameKind::kFixed, "ep4"));
  refused(other, "without body 'new'");
  other = scene;
  other.duration = 5.0;  // the duration is not part of the identity
  SceneWorld longer = saved_world_of(other);
  EXPECT_TRUE(longer.restore(bytes));
}

TEST(SavedWorld, DamagedAndTruncatedFilesAreRefused) {
  SceneWorld world = saved_world_of(crowded());
  run(world, 120);
  std::vector<std::byte> bytes = world.save();
  run(world, 10);
  const std::string before = state_bytes(world);
  for (std::size_t length = 0; length < bytes.size(); length += length < 2'000 ? 1 : 997)
    ASSERT_FALSE(world.restore(std::span(bytes).first(length))) << length;
  std::mt19937 generator(5);
  for (int trial = 0; trial < 2'000; ++trial) {
    const std::size_t at = generator() % bytes.size();
    const std::byte kept = bytes[at];
    bytes[at] ^= std::byte(1U << (generator() % 8U));
    // Padding between sections is ignored; other damage is detected.
    if (world.restore(bytes)) {
      ASSERT_EQ(kept, std::byte{0});
      bytes[at] = kept;
      SceneWorld other = saved_world_of(crowded());
      ASSERT_TRUE(other.restore(bytes));
      ASSERT_EQ(state_bytes(world), state_bytes(other));
      StateStream stream = StateStream::reading(std::as_bytes(std::span(before)));
      world.carry(stream);
    }
    bytes[at] = kept;
  }
  EXPECT_EQ(state_bytes(world), before);
}

// Forged states with correct checksums: refused, or a world that steps.
TEST(SavedWorld, ForgedStatesDoNotCrash) {
  SceneWorld world = saved_world_of(crowded());
  run(world, 350);
  const Result<SavedState> saved = read_saved(world.save(), "test");
  ASSERT_TRUE(saved);
#ifdef TREMOLO_LONG_TESTS
  constexpr int kTrials = 300;
#else
  constexpr int kTrials = 100;
#endif
  std::mt19937 generator(7);
  int refused = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    SavedState forged = *saved;
    for (int k = 0; k < 3; ++k)
      forged.state[generator() % forged.state.size()] = static_cast<char>(generator());
    if (trial % 7 == 0) forged.state.resize(generator() % forged.state.size());
    SceneWorld other = saved_world_of(crowded());
    if (!other.restore(encode_saved(forged))) {
      ++refused;
      continue;
    }
    run(other, 2);
  }
  EXPECT_GT(refused, kTrials / 8);
}

// Sums that are not finite would pass every comparison of a balance.
TEST(SavedWorld, SumsThatAreNoNumbersAreRefused) {
  SceneWorld world = saved_world_of(crowded());
  run(world, 350);
  const Result<SavedState> saved = read_saved(world.save(), "test");
  ASSERT_TRUE(saved);
  const ContactBody& stone = world.body(0);
  int forged_sums = 0;
  for (const double sum : {stone.sums().gravity, stone.sums().work, stone.contact_sums().work,
                           world.account(0).at_start, world.body(3).sums().support}) {
    std::string bytes(sizeof(sum), '\0');
    std::memcpy(bytes.data(), &sum, sizeof(sum));
    const std::size_t at = saved->state.find(bytes);
    if (sum == 0.0 || at == std::string::npos) continue;
    ++forged_sums;
    for (const double wrong : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
      SavedState forged = *saved;
      std::memcpy(forged.state.data() + at, &wrong, sizeof(wrong));
      const std::string before = state_bytes(world);
      EXPECT_FALSE(world.restore(encode_saved(forged))) << sum;
      EXPECT_EQ(state_bytes(world), before);
    }
  }
  EXPECT_GE(forged_sums, 4);
}

TEST(SavedWorld, FilesAppearWholeAndComeBack) {
  const testing::TemporaryFolder folder;
  const std::string path = folder.file("world.saved");
  SceneWorld world = saved_world_of(crowded());
  run(world, 60);
  ASSERT_TRUE(world.save(path));
  SceneWorld fresh = saved_world_of(crowded());
  ASSERT_TRUE(fresh.restore(path));
  expect_same(world, fresh);
  EXPECT_EQ(fresh.restore(folder.file("none")).error().kind, ErrorKind::kSystem);
  EXPECT_FALSE(world.save(folder.file("no/such/folder")));
}

// ---- one body, every method ----

struct BodyCase {
  std::string method;
  FrameKind frame = FrameKind::kFixed;
  double alpha = 0.0, beta = 0.0;
  double nonlinearity = 0.3;
};

ContactBody body_of(const BodyCase& c, bool loaded) {
  const auto model =
      testing::frame_model(6, c.frame == FrameKind::kFree, 30.0, 400.0, c.nonlinearity);
  IntegratorOptions options;
  options.alpha = c.alpha;
  options.beta = c.beta;
  options.step = 1e-3;
  ContactBody body = testing::make_framed(model, c.frame, options, c.method);
  if (loaded) {
    const Signal sine{.kind = SignalKind::kSine, .frequency = 3.0};
    EXPECT_TRUE(body.add_load(sine, 5, {40.0, -30.0, 60.0}));
  }
  if (c.frame == FrameKind::kFree) {
    EXPECT_TRUE(body.set_motion({1.0, 0.0, 0.0}, {2.0, 1.0, 3.0}));
  }
  return body;
}

void advance(const BodyCase& c, ContactBody& body, int steps) {
  for (int k = 0; k < steps; ++k) {
    const double t = body.time();
    if (c.frame == FrameKind::kDriven) {
      ASSERT_TRUE(body.move_to({{0.1 * std::sin(3.0 * t), 0.0, 0.0}, turn_by({0.2 * t, 0.0, t})}));
    }
    (void)body.step();
  }
}

TEST(SavedBody, EveryMethodGoesOnWithTheSameBits) {
  std::vector<BodyCase> cases;
  for (const std::string_view method : integrator_names())
    for (const double beta : {0.0, 2e-3})
      for (const double nonlinearity : {0.0, 0.3})
        cases.push_back({std::string(method), FrameKind::kFixed, beta * 100.0, beta, nonlinearity});
  for (const char* method : {"avf", "ep2", "ep4", "newmark", "imexv"})
    cases.push_back({method, FrameKind::kDriven, 0.0, 1e-3});
  for (const char* method : {"avf", "ep2", "ep4"}) cases.push_back({method, FrameKind::kFree});
  for (const BodyCase& c : cases)
    for (const bool loaded : {false, true}) {
      SCOPED_TRACE(c.method + (loaded ? " loaded" : "") + " beta " + std::to_string(c.beta));
      ContactBody straight = body_of(c, loaded);
      ASSERT_TRUE(straight.apply_force(5, {30.0, 20.0, -50.0}, 25));
      advance(c, straight, 40);
      const std::vector<std::byte> bytes = straight.save();
      advance(c, straight, 1);
      ContactBody fresh = body_of(c, loaded);
      const Status restored = fresh.restore(bytes);
      ASSERT_TRUE(restored) << restored.error().message;
      advance(c, fresh, 1);
      ASSERT_EQ(state_bytes(straight), state_bytes(fresh));
      advance(c, straight, 60);
      advance(c, fresh, 60);
      ASSERT_EQ(state_bytes(straight), state_bytes(fresh));
    }
}

// A step at rest evaluates nothing. What the next ones read is that of the present state all the
// same, also in a body that was restored and never evaluated anything.
TEST(SavedBody, AtRestItIsStruckWithTheSameBits) {
  for (const char* method : {"avf", "ep2", "ep4"})
    for (const FrameKind frame : {FrameKind::kFixed, FrameKind::kFree})
      for (const int steps : {4, 5}) {
        SCOPED_TRACE(std::string(method) + " after " + std::to_string(steps));
        const auto make = [&] {
          IntegratorOptions options;
          options.step = 1e-3;
          return testing::make_framed(
              testing::frame_model(6, frame == FrameKind::kFree, 30.0, 400.0, 0.3), frame, options,
              method);
        };
        ContactBody straight = make();
        for (int k = 0; k < steps; ++k) (void)straight.step();
        ContactBody fresh = make();
        ASSERT_TRUE(fresh.restore(straight.save()));
        for (ContactBody* body : {&straight, &fresh}) {
          for (int k = 0; k < 3; ++k) (void)body->step();
          ASSERT_TRUE(body->apply_force(5, {30.0, 20.0, -50.0}, 2));
          for (int k = 0; k < 20; ++k) (void)body->step();
        }
        EXPECT_EQ(state_bytes(straight), state_bytes(fresh));
      }
}

// A step whose solve fails is subdivided, and the integrators of its parts have saved state too.
TEST(SavedBody, StepsInPartsComeAlong) {
  for (const char* method : {"ep4", "newmark", "midpoint"}) {
    const auto make = [method] {
      const auto model = testing::frame_model(6, false, 30.0, 400.0, 3.0);
      IntegratorOptions options;
      options.step = 0.02;
      options.max_iterations = 3;
      ContactBody body = testing::make_framed(model, FrameKind::kFixed, options, method);
      EXPECT_TRUE(
          body.add_load({.kind = SignalKind::kSine, .frequency = 2.0}, 5, {900.0, -700.0, 800.0}));
      return body;
    };
    ContactBody straight = make();
    for (int k = 0; k < 60; ++k) (void)straight.step();
    EXPECT_GT(straight.counts().halved, 0) << method;
    ContactBody fresh = make();
    ASSERT_TRUE(fresh.restore(straight.save()));
    for (int k = 0; k < 60; ++k) {
      (void)straight.step();
      (void)fresh.step();
    }
    EXPECT_EQ(state_bytes(straight), state_bytes(fresh)) << method;
    // Back in a body whose parts go deeper, and in one that has none yet.
    ContactBody young = make();
    const std::vector<std::byte> early = young.save();
    ASSERT_TRUE(straight.restore(early));
    for (int k = 0; k < 60; ++k) {
      (void)straight.step();
      (void)young.step();
    }
    EXPECT_EQ(state_bytes(straight), state_bytes(young)) << method;
  }
}

TEST(SavedBody, OtherBodiesAreRefused) {
  const BodyCase c{"ep4"};
  ContactBody body = body_of(c, false);
  advance(c, body, 10);
  const std::vector<std::byte> bytes = body.save();
  const auto refused = [&bytes](ContactBody other, const std::string& words) {
    const std::string before = state_bytes(other);
    const Status status = other.restore(bytes);
    ASSERT_FALSE(status);
    EXPECT_NE(status.error().message.find(words), std::string::npos) << status.error().message;
    EXPECT_EQ(state_bytes(other), before);
  };
  refused(body_of({"ep2"}, false), "another method or frame");
  refused(body_of({"ep4", FrameKind::kDriven}, false), "another method or frame");
  refused(body_of({"ep4", FrameKind::kFixed, 0.0, 0.0, 0.5}, false), "another model");
  refused(body_of(c, true), "other loads");
  SceneWorld world = saved_world_of(crowded());
  expect_refused(world, bytes, "the state of a body, not of a world");
}

}  // namespace
}  // namespace tremolo
