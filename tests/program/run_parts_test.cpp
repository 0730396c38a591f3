// The parts of `tremolo run` by themselves.
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "common/processor.h"
#include "runtime/apps/tremolo/output/run_progress.h"
#include "runtime/apps/tremolo/run/follow.h"
#include "runtime/apps/tremolo/run/recorder.h"
#include "runtime/apps/tremolo/run/run_body.h"
#include "runtime/apps/tremolo/run/simulate.h"
#include "runtime/apps/tremolo/start/run_notes.h"
#include "runtime/scene/scene_start.h"
#include "tests/support/sample_basis.h"

namespace tremolo {
namespace {

const Eigen::Vector4d kOmega(20.0, 45.0, 90.0, 160.0);

testing::StrainModel strain_model() {
  return testing::random_strain_model(kOmega, 0.3, 7);
}

Model::Pointer make_model() {
  Result<Model::Pointer> model = Model::from_data(testing::sample_basis(strain_model()));
  EXPECT_TRUE(model);
  return *model;
}

// The world of one body of the model.
SceneWorld make_world(const Model::Pointer& model, const std::string& method,
                      const IntegratorOptions& options) {
  SceneBody body;
  body.name = "body";
  body.model = "known";
  body.integrator = method;
  body.options = options;
  Scene scene;
  scene.step = options.step;
  scene.bodies.push_back(std::move(body));
  Result<SceneWorld> world =
      SceneWorld::create(scene, [&](const SceneBody&) { return Result<Model::Pointer>(model); });
  EXPECT_TRUE(world);
  return std::move(*world);
}

// Keeps the moments of a world's first body, and how many there were at each look.
struct Keeper : WorldWatch {
  std::vector<Moment> moments;
  std::vector<std::size_t> looks;
  std::optional<StepReport> failed;

  void note(const SceneWorld& world) override {
    if (world.failed(0)) return;
    moments.emplace_back();
    look_at(world.body(0), moments.back());
  }
  Status look(const SceneWorld&, std::span<const SceneWorld::Failure> failures,
              WorldEnding& ending) override {
    looks.push_back(moments.size());
    if (failures.empty()) return Success{};
    failed = failures.front().report;
    ending.exit_code = exit_code(ErrorKind::kSolver);
    return Success{};
  }
};

WorldEnding follow_by(SceneWorld& world, std::int64_t steps, std::int64_t block, Keeper& keeper) {
  ToldProgress progress("body", 1.0);
  const Result<WorldEnding> ending =
      follow(world, {static_cast<double>(steps) * world.step_size(), block, 1, &progress, nullptr},
             keeper);
  EXPECT_TRUE(ending);
  return *ending;
}

TEST(Follow, ABodyInItsWorldMovesAsByItself) {
  const Model::Pointer model = make_model();
  for (const char* method : {"ep4", "imexv-thesis", "verlet", "imexv-adaptive"}) {
    IntegratorOptions options;
    options.step = 2e-3;
    SceneWorld one = make_world(model, method, options);
    Result<Body> other = Body::create(model, method, options);
    ASSERT_TRUE(other);
    const Load load{{.kind = SignalKind::kSquare, .duration = 0.05}, Eigen::Vector4d(3, 2, 1, 5)};
    ASSERT_TRUE(one.body(0).add_load(load) && other->add_load(load));
    Keeper keeper;
    const WorldEnding ending = follow_by(one, 100, 7, keeper);
    ASSERT_EQ(keeper.moments.size(), 101U);  // and the start
    Eigen::VectorXd momentum(4);
    for (std::int64_t k = 1; k <= 100; ++k) {
      const Moment& moment = keeper.moments[static_cast<std::size_t>(k)];
      ASSERT_TRUE(other->step().converged);
      other->integrator().synchronized_momentum(other->state(), momentum);
      EXPECT_EQ(moment.steps, k);
      EXPECT_EQ(moment.time, other->time());
      EXPECT_EQ(moment.state.q, other->state().q) << method;
      EXPECT_EQ(moment.state.p, momentum) << method;
      EXPECT_EQ(moment.work, other->sums().work);
      EXPECT_EQ(moment.loaded, other->load_to_come());
    }
    EXPECT_EQ(ending.steps, 100);
    EXPECT_GT(ending.seconds, 0.0);
  }
}

TEST(Follow, ABlockIsAsLongAsAskedForAndOnlyTheLastOneIsShorter) {
  SceneWorld world = make_world(make_model(), "verlet", {});
  Keeper keeper;
  follow_by(world, 20, 7, keeper);
  EXPECT_EQ(keeper.looks, (std::vector<std::size_t>{1, 8, 15, 21}));
  EXPECT_EQ(world.steps(), 20);
}

TEST(Follow, StopsAtAStepThatDoesNotConvergeWithTheMomentsBeforeIt) {
  IntegratorOptions options;
  options.max_iterations = 1;
  options.halvings = 0;
  SceneWorld world = make_world(make_model(), "midpoint", options);
  const Load load{{.kind = SignalKind::kConstant, .start = 0.03}, 1e5 * Eigen::Vector4d::Ones()};
  ASSERT_TRUE(world.body(0).add_load(load));
  Keeper keeper;
  const WorldEnding ending = follow_by(world, 1000, 64, keeper);
  ASSERT_TRUE(keeper.failed);
  EXPECT_FALSE(keeper.failed->converged);
  ASSERT_EQ(static_cast<std::int64_t>(keeper.moments.size()), world.body(0).counts().steps + 1);
  EXPECT_EQ(ending.steps, world.body(0).counts().steps + 1);  // the one that failed was tried
  EXPECT_GE(keeper.moments.size(), 11u);
}

TEST(Statics, TheShapeUnderALoadBalancesIt) {
  const Model::Pointer model = make_model();
  for (const double scale : {1e-6, 1.0, 100.0}) {
    const Eigen::VectorXd force = scale * Eigen::Vector4d(1.0, -2.0, 3.0, 4.0);
    const Result<Eigen::VectorXd> q = standing_shape(model->potential(), force);
    ASSERT_TRUE(q) << q.error().message;
    EXPECT_LE((testing::strain_force(strain_model(), *q) - force).norm(), 1e-10 * force.norm());
  }
}

TEST(Statics, AHeldShapeHasWhatIsHeldThereAndTheLeastEnergyOfAllSuch) {
  const Model::Pointer model = make_model();
  const Hold hold{Eigen::MatrixXd::Ones(1, 4), Eigen::VectorXd::Constant(1, 0.1)};
  const Result<Eigen::VectorXd> q =
      standing_shape(model->potential(), Eigen::VectorXd::Zero(4), hold);
  ASSERT_TRUE(q) << q.error().message;
  EXPECT_NEAR(q->sum(), 0.1, 1e-14);
  const double least = testing::strain_energy(strain_model(), *q);
  for (const Eigen::Vector4d& other :
       {Eigen::Vector4d(1, -1, 0, 0), Eigen::Vector4d(0, 1, -1, 0), Eigen::Vector4d(0, 0, 1, -1)})
    for (const double step : {-1e-3, 1e-3})
      EXPECT_GT(testing::strain_energy(strain_model(), *q + step * other), least);
  const Hold twice{Eigen::MatrixXd::Ones(2, 4), Eigen::VectorXd::Constant(2, 0.1)};
  const auto refused = standing_shape(model->potential(), Eigen::VectorXd::Zero(4), twice);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, ErrorKind::kContent);
}

TEST(LoadSearch, FindsTheFactorOfACurveWithinAPercent) {
  const auto curve = [](double scale) -> Result<LoadAttempt> {
    return LoadAttempt{scale, 0.2 * scale / std::sqrt(1.0 + scale)};
  };
  for (const double wanted : {1e-4, 0.05, 0.3, 2.0}) {
    const Result<LoadScale> found = search_load_scale(wanted, curve);
    ASSERT_TRUE(found);
    ASSERT_GT(found->scale, 0.0) << found->trouble;
    EXPECT_NEAR(curve(found->scale)->amplitude, wanted, 0.01 * wanted);
  }
}

TEST(LoadSearch, SaysWhyThereIsNone) {
  const auto still = [](double scale) -> Result<LoadAttempt> { return LoadAttempt{scale, 0.0}; };
  EXPECT_NE(search_load_scale(0.05, still)->trouble.find("does not move"), std::string::npos);
  const auto breaks = [](double scale) -> Result<LoadAttempt> {
    if (scale < 1.0) return LoadAttempt{scale, 0.01 * scale};
    return LoadAttempt{scale, std::numeric_limits<double>::infinity(), "it broke"};
  };
  EXPECT_NE(search_load_scale(0.05, breaks)->trouble.find("it broke"), std::string::npos);
}

TEST(RunProgress, ShortRunsSayNothingAndLongOnesHowLongTheyWillTake) {
  RunProgress lines("horse", 30.0, false);
  EXPECT_EQ(lines.due(9.9, 10.0), "");
  EXPECT_EQ(lines.due(10.0, 7.5), "  horse: 25 %, 7.5 of 30 s, about 30 s left\n");
  EXPECT_EQ(lines.due(39.0, 20.0), "");
  EXPECT_NE(lines.due(40.0, 28.0), "");
  EXPECT_EQ(lines.end(), "");
  RunProgress terminal("horse", 30.0, true);
  EXPECT_EQ(terminal.due(0.9, 1.0), "");
  EXPECT_EQ(terminal.due(1.0, 0.01), "  horse: 0 %, 0.01 of 30 s, about 50 min left\r");
  const std::string shorter = terminal.due(2.0, 29.0);
  EXPECT_TRUE(shorter.ends_with(" \r")) << "the longer line before must not show behind it";
  EXPECT_FALSE(terminal.end().empty());
  EXPECT_EQ(terminal.end(), "");
}

TEST(RunBody, CoordinatesAndSharesAreReadAsTheyAreWritten) {
  EXPECT_EQ(*coordinates_of({"3", "0-2", "1"}, 4), (std::vector<int>{3, 0, 1, 2}));
  EXPECT_EQ(*coordinates_of({"all"}, 3), (std::vector<int>{0, 1, 2}));
  for (const char* text : {"", "-1", "2-", "2-1", "a", "1,2"})
    EXPECT_FALSE(coordinates_of({text}, 4));
  EXPECT_DOUBLE_EQ(*parse_share("5%"), 0.05);
  EXPECT_DOUBLE_EQ(*parse_share("0.05"), 0.05);
  for (const char* text : {"", "%", "5 %", "-1%", "0", "nan"})
    EXPECT_FALSE(parse_share(text)) << text;
}

// The flags that are in `given` over the table's options.
RunOptions put_over_table(const RunOptions& flags, const std::set<std::string>& given,
                          const std::string& keys) {
  const auto tables = parse_scene("[a]\nmodel = \"m\"\n" + keys, "s.toml");
  EXPECT_TRUE(tables) << (tables ? "" : tables.error().message);
  RunOptions options = tables->front();
  put_over({flags, [&given](const char* flag) { return given.contains(flag); }}, options);
  return options;
}

TEST(BodyOptions, AFlagReplacesTheKeysOfItsQuantityAndNoOther) {
  RunOptions flags;
  flags.step = 1e-3;
  flags.load = "chirp";
  flags.alpha = 2.0;
  flags.scale = 3.0;
  flags.probes = {"7"};
  const std::string keys =
      "step = 2e-3\nload = \"sine\"\nfrequency = 4\nload-duration = 5\ndamping-ratio = "
      "\"1:0.1,2:0.1\"\ndeflect = \"5%\"\nprobe = [1, 2]\nmodes = 3\n";
  const RunOptions none = put_over_table(flags, {}, keys);
  EXPECT_EQ(none.step, 2e-3);
  EXPECT_EQ(none.load, "sine");
  EXPECT_EQ(none.probes.size(), 2U);
  const RunOptions some =
      put_over_table(flags, {"--step", "--load", "--alpha", "--scale", "--probe"}, keys);
  EXPECT_EQ(some.step, 1e-3);
  EXPECT_EQ(some.load, "chirp");
  EXPECT_FALSE(some.shape.frequency) << "the sine's";
  EXPECT_EQ(some.shape.duration, 5.0);
  EXPECT_EQ(some.alpha, 2.0);
  EXPECT_EQ(some.damping_ratio, "");
  EXPECT_EQ(some.scale, 3.0);
  EXPECT_EQ(some.deflect, "");
  EXPECT_EQ(some.probes, std::vector<std::string>{"7"});
  EXPECT_EQ(some.modes, 3);
  EXPECT_EQ(put_over_table(flags, {"--deflect"}, "scale = 2\n").scale, 1.0);
  EXPECT_EQ(put_over_table(flags, {"--load"}, "signal = \"a.csv\"\n").signal, "");
}

TEST(BodyOptions, DampingRatiosAreTextsOrNumbers) {
  const auto settings_of = [](const std::string& keys) {
    const Result<BodyScene> scene = body_scene(put_over_table({}, {}, keys));
    EXPECT_TRUE(scene) << scene.error().message;
    return scene->settings();
  };
  EXPECT_EQ(settings_of("damping-ratio = \"2%\"\n").ratios.of_modes, std::vector<double>{0.02});
  EXPECT_EQ(settings_of("damping-ratio = 0.02\n").ratios.of_modes, std::vector<double>{0.02});
  EXPECT_EQ(settings_of("damping-ratio = [0.02, 0.01]\n").ratios.of_modes.size(), 2U);
  EXPECT_EQ(settings_of("damping-ratio = \"1:1%,5:2%,9:1%\"\n").ratios.table.size(), 3U);
  EXPECT_GT(settings_of("damping-ratio = \"1:1%,5:2%\"\n").beta, 0.0);
}

TEST(BodyOptions, SoundWithoutAStepChoosesTheStep) {
  RunOptions flags;
  flags.wav = "a.wav";
  flags.step = 1e-4;
  const RunOptions chosen = put_over_table(flags, {"--wav"}, "step = 2e-3\n");
  EXPECT_EQ(chosen.step, 1.0 / 48000.0);
  EXPECT_EQ(chosen.sound_steps, 0);
  EXPECT_EQ(put_over_table(flags, {"--wav", "--step"}, "").step, 1e-4);
}

TEST(BodyScene, HasWhatTheOptionsSay) {
  RunOptions options;
  options.name = "a";
  options.model = "m";
  options.integrator = "newmark";
  options.step = 1e-3;
  options.duration = 2.0;
  options.modes = 4;
  options.load = "ramp";
  options.at = "x>0";
  options.force = "1,2,3";
  options.scale = 0.5;
  options.alpha = 0.25;
  options.split = "3";
  options.safety = 0.5;
  options.coordinates = {"all"};
  options.velocities = true;
  options.out = "there";
  options.every = 5;
  const Result<BodyScene> scene = body_scene(options);
  ASSERT_TRUE(scene) << scene.error().message;
  EXPECT_EQ(scene->body().name, "a");
  EXPECT_EQ(scene->body().model_options.modes, 4);
  EXPECT_EQ(scene->settings().step, 1e-3);
  EXPECT_EQ(scene->settings().alpha, 0.25);
  EXPECT_EQ(scene->settings().split.count, 3);
  EXPECT_EQ(scene->settings().split.safety, 0.5);
  EXPECT_EQ(scene->load().signal.kind, SignalKind::kRamp);
  EXPECT_EQ(scene->load().signal.duration, 2.0) << "a ramp rises all the time";
  EXPECT_EQ(scene->load().force, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(scene->load().scale, 0.5);
  EXPECT_EQ(scene->load_name, "ramp");
  EXPECT_TRUE(scene->body().columns.velocities);
  EXPECT_EQ(scene->file.outputs.out, "there");
  EXPECT_EQ(scene->file.outputs.every, 5);
  options.load = "none";
  options.force = "x";  // of no load
  EXPECT_EQ(body_scene(options)->load().signal.kind, SignalKind::kNone);
  options.every = 0;
  EXPECT_EQ(body_scene(options).error().kind, ErrorKind::kContent);
  options.integrator = "euler";
  EXPECT_EQ(body_scene(options).error().kind, ErrorKind::kUsage);
}

// A box of 1 x 2 x 3 m with one coordinate that no load excites: all of a load is lost.
TEST(RigidLoss, IsThatOfTheSolidWithinTheBoundary) {
  BasisData data = testing::sample_basis(
      testing::random_strain_model(Eigen::VectorXd::Constant(1, 10.0), 0.0, 1));
  data.surface.vertex_ids.clear();
  data.surface.rest.clear();
  for (int v = 0; v < 8; ++v) {
    data.surface.vertex_ids.push_back(v);
    data.surface.rest.emplace_back(5.0 + (v & 1), 2.0 * ((v >> 1) & 1), 3.0 * ((v >> 2) & 1));
  }
  data.vertex_count = 8;
  data.interior = {};
  data.render.reset();
  data.surface.rows = BasisRows::Zero(24, 1);
  data.surface.rows(2, 0) = 1.0;  // vertex 0 along z
  data.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  data.load = {};
  Result<Model::Pointer> model = Model::from_data(data);
  ASSERT_TRUE(model) << model.error().message;
  const double mass = 12.0, f = 7.0;
  const RigidLoss loss = rigid_loss(**model, {{0}, {{0.0, 0.0, f}}}, mass, 6);
  EXPECT_NEAR(loss.force, f, 1e-12);
  // The arm is (-1/2, -1, -3/2): torque (-1, 1/2, 0) f.
  EXPECT_NEAR(loss.torque, f * std::sqrt(1.25), 1e-12);
  const double ix = mass / 12 * (4 + 9), iy = mass / 12 * (1 + 9);
  const double whole = f * f * (1 / mass + 1 / ix + 0.25 / iy);
  EXPECT_NEAR(loss.share, whole / (whole + f * f), 1e-12);
  EXPECT_TRUE(std::isnan(rigid_loss(**model, {{0}, {{0.0, 0.0, f}}}, mass, 12).share));
}

}  // namespace
}  // namespace tremolo
