// The hand's motion is written as a scene, and the scene repeats it, bit for bit.
#include "runtime/apps/view/live/hand_record.h"

#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>

#include "runtime/apps/view/live/runner.h"
#include "runtime/io/scenes/scene_reader.h"
#include "tests/viewer/viewer_files.h"

namespace tremolo {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using testing::fresh_folder;

GivenFlags no_flags() {
  return {RunOptions{}, [](const char*) { return false; }};
}

// A ray towards the middle of the triangle of the body's surface that is farthest along `way`.
CameraRay ray_at(const SceneWorld& world, std::size_t i, const Vector3d& way) {
  const ContactBody& body = world.body(i);
  const auto& rest = body.model().drawn().rest;
  Vector3d farthest = rest.front();
  for (const Vector3d& x : rest)
    if (way.dot(x) > way.dot(farthest)) farthest = x;
  const Vector3d aim = body.pose() * Vector3d(farthest - 1e-4 * way);
  return {aim + 2.0 * way, -way};
}

// Pulls the body twice, as a mouse would, and releases it in between; steps: their total number.
void play(LiveWorld& live, HandRecord& record, std::size_t body, const Vector3d& way, int steps) {
  for (int k = 0; k < steps; ++k) {
    if (k == 20 || k == 120) {
      const CameraRay ray = ray_at(live.world(), body, way);
      const auto hit = live.world().pick(ray.origin, ray.direction);
      ASSERT_TRUE(hit && *hit && (*hit)->body == body);
      const Status taken = live.hand().take(live.world(), **hit, k == 20 ? 1.0 : 3.0);
      ASSERT_TRUE(taken) << taken.error().message;
    }
    if (k % 5 == 0) live.hand().move(0.02 * std::sin(0.05 * k) * way + Vector3d(0, 0, 1e-4 * k));
    if (k == 90) live.hand().let_go(live.world());
    record.before_step(live);
    ASSERT_TRUE(live.step());
  }
  record.end(live.world().time());
}

void expect_replayed(const ViewedScene& viewed, const std::string& path, std::size_t body,
                     const Vector3d& way) {
  ModelCache models;
  auto live = LiveWorld::create(viewed, models);
  ASSERT_TRUE(live) << live.error().message;
  HandRecord record;
  constexpr int kSteps = 200;
  play(*live, record, body, way, kSteps);
  ASSERT_EQ(record.hands().size(), 2U);
  const Status written = write_recorded_scene(path, *live, record.hands());
  ASSERT_TRUE(written) << written.error().message;
  const auto file = read_world(path);
  ASSERT_TRUE(file) << file.error().message;
  auto again = SceneWorld::create(file->scene);
  ASSERT_TRUE(again) << again.error().message;
  for (int k = 0; k < kSteps; ++k) ASSERT_TRUE(again->step().empty());
  EXPECT_GT(std::abs(live->world().body(body).contact_sums().hand), 1e-9);
  for (std::size_t i = 0; i < again->size(); ++i) {
    EXPECT_EQ(again->body(i).state().q, live->world().body(i).state().q);
    EXPECT_EQ(again->body(i).state().p, live->world().body(i).state().p);
  }
}

TEST(HandRecord, OfABasisFileIsReplayedToTheBit) {
  RunOptions options;
  GivenFlags flags = no_flags();
  flags.values.integrator = "newmark";
  flags.values.beta = 1e-3;
  const auto viewed = read_viewed_scene(testing::sample_model("horse"), flags);
  ASSERT_TRUE(viewed) << viewed.error().message;
  expect_replayed(*viewed, fresh_folder() + "/hand.toml", 0, Vector3d(0, -1, 0));
}

// The scene is in another folder, with a floor, and has its own hand.
TEST(HandRecord, OfASceneKeepsTheSceneAndFindsItsFiles) {
  const std::string folder = fresh_folder();
  fs::create_directories(folder + "/scene");
  fs::create_directories(folder + "/elsewhere/deep");
  std::ofstream(folder + "/scene/scene.toml")
      << "step = 0.002\ngravity = [0, 0, -9.81]\n"
         "[[bodies]]\nname = 'heart'\nkind = 'free'\nmodel = '"
      << fs::relative(testing::sample_model("heart-free"), folder + "/scene").string()
      << "'\nposition = [0, 0, 0.02]\nbeta = 0.001\n"
         "[[colliders]]\nname = 'floor'\nshape = 'plane'\n"
         "[[hands]]\nbody = 'heart'\nat = 'near:0,0,0.3'\nstiffness = 50\ndamping = 1\nfrom = "
         "0.3\n";
  const auto viewed = read_viewed_scene(folder + "/scene/scene.toml", no_flags());
  ASSERT_TRUE(viewed) << viewed.error().message;
  expect_replayed(*viewed, folder + "/elsewhere/deep/hand.toml", 0, Vector3d(0, 0, 1));
  const auto file = read_world(folder + "/elsewhere/deep/hand.toml");
  ASSERT_TRUE(file);
  EXPECT_EQ(file->scene.hands.size(), 3U);
  EXPECT_EQ(file->scene.colliders.size(), 1U);
  EXPECT_EQ(file->scene.step, 0.002);
}

TEST(HandRecord, AnUnwritablePlaceIsNamed) {
  const auto viewed = read_viewed_scene(testing::sample_model("beam"), no_flags());
  ASSERT_TRUE(viewed);
  ModelCache models;
  const auto live = LiveWorld::create(*viewed, models);
  ASSERT_TRUE(live);
  const Status written = write_recorded_scene("/nonexistent/hand.toml", *live, {});
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().kind, ErrorKind::kSystem);
  EXPECT_NE(written.error().message.find("/nonexistent/hand.toml"), std::string::npos);
}

// The thread keeps the clock's pace, stops on request, steps once, and begins again.
TEST(Runner, FollowsTheClockAndDoesWhatItIsTold) {
  const auto viewed = read_viewed_scene(testing::sample_model("beam"), no_flags());
  ASSERT_TRUE(viewed);
  ModelCache models;
  auto live = LiveWorld::create(*viewed, models);
  ASSERT_TRUE(live);
  Runner runner(std::move(*live), 1.0, true, false);
  std::this_thread::sleep_for(std::chrono::milliseconds(30));
  EXPECT_EQ(runner.report().steps, 0);
  runner.step_once();
  while (runner.report().steps < 1) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  std::this_thread::sleep_for(std::chrono::milliseconds(30));
  EXPECT_EQ(runner.report().steps, 1);
  runner.set_rate(0.25);
  const auto begun = Runner::Clock::now();
  runner.set_paused(false);
  std::this_thread::sleep_for(std::chrono::milliseconds(400));
  runner.set_paused(true);
  const double passed = std::chrono::duration<double>(Runner::Clock::now() - begun).count();
  runner.settle();
  const RunnerReport report = runner.report();
  // The time given up is reported; a step more or less at each end.
  EXPECT_NEAR(report.time + 0.25 * report.lost, 0.003 + 0.25 * passed, 0.02);
  WorldMoment moment;
  runner.look(moment);
  EXPECT_LE(moment.time, report.time);
  runner.post([&models](LiveWorld& world) {
    ASSERT_TRUE(world.world().set_method(0, "implicit-euler"));
    ASSERT_TRUE(world.world().set_step(0.001));
    ASSERT_TRUE(world.begin_again(models));
  });
  runner.settle();
  EXPECT_EQ(runner.report().time, 0.0);
  EXPECT_EQ(runner.method_of(0), "implicit-euler");
  const LiveWorld ended = runner.stop();
  EXPECT_EQ(ended.world().step_size(), 0.001);
}

}  // namespace
}  // namespace tremolo
