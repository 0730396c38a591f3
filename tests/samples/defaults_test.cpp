// Every public entry with nothing but its defaults, on every sample model under its own load.
#include <cmath>
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "common/energy.h"
#include "runtime/crowd.h"
#include "runtime/energy.h"
#include "runtime/tremolo.h"
#include "tests/support/run_program.h"

namespace tremolo {
namespace {

constexpr const char* kSampleNames[] = {"beam", "basket", "bridge", "horse", "tower", "heart"};
constexpr int kSteps = 3333;     // 10 s at the default step
constexpr int kPush = 100;       // steps: the square load lasts 0.3 s
constexpr int kFiner = 6;        // the reference's steps in one of the default
constexpr double kMost = 0.005;  // of the trajectory, relative
constexpr double kDrift = 1e-8;  // of the energy: the balance is exact up to the solve's rounding

// q after each step, r x steps, and T + V then, J. energy may be empty.
struct Orbit {
  Eigen::MatrixXd q;
  Eigen::VectorXd energy;
};

class Defaults : public ::testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    Result<Model::Pointer> model = Model::load(path());
    ASSERT_TRUE(model) << model.error().message;
    model_ = *model;
    ASSERT_EQ(model_->default_load().vertices.size(), 1u);
    vertex_ = model_->default_load().vertices[0];
    force_ = model_->default_load().forces[0];
    reference_ = reference();
  }

  std::string path() const { return std::string(TREMOLO_MODEL_DIR "/") + GetParam() + ".tremolo"; }

  Orbit make_orbit() const {
    return {Eigen::MatrixXd(model_->modes(), kSteps), Eigen::VectorXd(kSteps)};
  }

  // ep4 at 0.5 ms.
  Eigen::MatrixXd reference() const {
    Eigen::MatrixXd q(model_->modes(), kSteps);
    Body body = std::move(*Body::create(model_, "ep4", {.step = 3e-3 / kFiner}));
    EXPECT_TRUE(body.add_default_load({.kind = SignalKind::kSquare}));
    for (int k = 0; k < kSteps; ++k) {
      for (int part = 0; part < kFiner; ++part) EXPECT_TRUE(body.step().converged);
      q.col(k) = body.state().q;
    }
    return q;
  }

  // The mass matrix is the identity: its norm is the Euclidean one of q.
  void check(const char* entry, const Orbit& orbit) const {
    ASSERT_TRUE(orbit.q.allFinite()) << entry;
    ASSERT_TRUE(orbit.energy.allFinite()) << entry;
    const double error = (orbit.q - reference_).norm() / reference_.norm();
    const auto free = orbit.energy.tail(kSteps - kPush).array();
    const double start = orbit.energy[kPush - 1];
    const double drift = (free - start).abs().maxCoeff() / start;
    std::printf("%-7s %-8s error %.3f %%, energy %.6g J, drift %.1e\n", GetParam(), entry,
                100.0 * error, orbit.energy[kSteps - 1], drift);
    EXPECT_GT(start, 0.0) << entry;
    EXPECT_LE(error, kMost) << entry;
    EXPECT_LE(drift, kDrift) << entry;
  }

  void run_program();
  void run_body();
  void run_world();
  void run_body_from_c();
  void run_world_from_c();

  Model::Pointer model_;
  VertexId vertex_ = 0;
  Eigen::Vector3d force_;
  Eigen::MatrixXd reference_;
};

INSTANTIATE_TEST_SUITE_P(Six, Defaults, ::testing::ValuesIn(kSampleNames),
                         [](const auto& sample) { return std::string(sample.param); });

void Defaults::run_program() {
  const std::string folder = testing::fresh_folder();
  std::string command =
      TREMOLO_BIN_DIR "/tremolo run " + path() + " --duration 9.999 --json --out .";
  for (Eigen::Index i = 0; i < model_->modes(); ++i)
    command += " --coordinate " + std::to_string(i);
  const testing::ProgramResult result = testing::run_program(folder, command);
  ASSERT_EQ(result.code, 0) << result.err;
  const auto report = nlohmann::json::parse(result.out);
  EXPECT_EQ(report["integrator"], "ep4");
  EXPECT_LE(report["energy_drift_max"].get<double>(), kDrift);
  Orbit orbit = make_orbit();
  std::ifstream table(folder + "/run.csv");
  std::string line, cell;
  std::getline(table, line);
  ASSERT_EQ(line.substr(0, 26), "t,kinetic,potential,total,");
  std::getline(table, line);  // t = 0
  for (int k = 0; k < kSteps; ++k) {
    ASSERT_TRUE(std::getline(table, line)) << k;
    std::istringstream cells(line);
    for (int column = 0; std::getline(cells, cell, ','); ++column) {
      if (column == 3) orbit.energy[k] = std::stod(cell);
      if (column >= 7) orbit.q(column - 7, k) = std::stod(cell);
    }
  }
  check("program", orbit);
}

void Defaults::run_body() {
  Body body = std::move(*Body::create(model_));
  ASSERT_TRUE(body.add_default_load({.kind = SignalKind::kSquare}));
  Orbit orbit = make_orbit();
  DriftMeter drift;
  drift.observe(0.0, 0.0, 0.0, true);
  for (int k = 0; k < kSteps; ++k) {
    const StepReport report = body.step();
    ASSERT_TRUE(report.converged) << failure_message(report, body.time());
    orbit.q.col(k) = body.state().q;
    orbit.energy[k] = body.energy().total();
    drift.observe(orbit.energy[k], body.sums().work, body.sums().dissipated, body.load_to_come());
  }
  EXPECT_LE(drift.worst(), kDrift);
  check("Body", orbit);
}

void Defaults::run_world() {
  Crowd world = std::move(*Crowd::create());
  const BodyId body = *world.add_body(*world.add_group(model_, {}));
  ASSERT_TRUE(world.apply_force(body, vertex_, force_, kPush));
  Orbit orbit = make_orbit();
  for (int k = 0; k < kSteps; ++k) {
    ASSERT_TRUE(world.step().failed.empty());
    orbit.q.col(k) = world.state(body)->q;
    orbit.energy[k] = world.energy(body)->total();
  }
  EXPECT_TRUE(*world.is_awake(body));
  check("Crowd", orbit);
}

void Defaults::run_body_from_c() {
  tremolo_model* model = nullptr;
  tremolo_body* body = nullptr;
  ASSERT_EQ(tremolo_model_load(path().c_str(), 0, &model), TREMOLO_OK) << tremolo_last_error();
  ASSERT_EQ(tremolo_body_create(model, nullptr, &body), TREMOLO_OK) << tremolo_last_error();
  tremolo_model_release(model);
  const auto vertex = static_cast<std::uint32_t>(vertex_);
  ASSERT_EQ(tremolo_body_apply_force(body, vertex, force_.data(), kPush), TREMOLO_OK);
  Orbit orbit = make_orbit();
  for (int k = 0; k < kSteps; ++k) {
    double kinetic = 0.0, potential = 0.0;
    ASSERT_EQ(tremolo_body_step(body, 1, nullptr), TREMOLO_OK) << tremolo_last_error();
    ASSERT_EQ(tremolo_body_state(body, orbit.q.col(k).data(), nullptr,
                                 static_cast<std::size_t>(model_->modes())),
              TREMOLO_OK);
    ASSERT_EQ(tremolo_body_energy(body, &kinetic, &potential, nullptr), TREMOLO_OK);
    orbit.energy[k] = kinetic + potential;
  }
  tremolo_body_destroy(body);
  check("C body", orbit);
}

void Defaults::run_world_from_c() {
  tremolo_model* model = nullptr;
  tremolo_crowd* world = nullptr;
  std::uint32_t group = 0, body = 0;
  ASSERT_EQ(tremolo_model_load(path().c_str(), 0, &model), TREMOLO_OK) << tremolo_last_error();
  ASSERT_EQ(tremolo_crowd_create(1, &world), TREMOLO_OK);
  ASSERT_EQ(tremolo_crowd_add_group(world, model, nullptr, nullptr, &group), TREMOLO_OK);
  tremolo_model_release(model);
  ASSERT_EQ(tremolo_crowd_add_body(world, group, &body), TREMOLO_OK);
  const auto vertex = static_cast<std::uint32_t>(vertex_);
  ASSERT_EQ(tremolo_crowd_apply_force(world, body, vertex, force_.data(), kPush), TREMOLO_OK);
  Orbit orbit = make_orbit();
  for (int k = 0; k < kSteps; ++k) {
    double kinetic = 0.0, potential = 0.0;
    ASSERT_EQ(tremolo_crowd_step(world, nullptr, 0, nullptr), TREMOLO_OK) << tremolo_last_error();
    ASSERT_EQ(tremolo_crowd_state(world, body, orbit.q.col(k).data(), nullptr,
                                  static_cast<std::size_t>(model_->modes())),
              TREMOLO_OK);
    ASSERT_EQ(tremolo_crowd_energy(world, body, &kinetic, &potential, nullptr), TREMOLO_OK);
    orbit.energy[k] = kinetic + potential;
  }
  tremolo_crowd_destroy(world);
  check("C world", orbit);
}

TEST_P(Defaults, EveryPublicEntryIsAccurateAndKeepsTheEnergy) {
  run_program();
  run_body();
  run_world();
  run_body_from_c();
  run_world_from_c();
}

// Their own method is imexv: its energy is printed, and has to stay in its bound.
class Scenes : public ::testing::TestWithParam<const char*> {};

INSTANTIATE_TEST_SUITE_P(Six, Scenes, ::testing::ValuesIn(kSampleNames),
                         [](const auto& sample) { return std::string(sample.param); });

TEST_P(Scenes, RunForTenSecondsInsideTheirBound) {
  const std::string scene =
      std::string(TREMOLO_SOURCE_DIR "/assets/scenes/") + GetParam() + ".toml";
  const testing::ProgramResult result = testing::run_program(
      testing::fresh_folder(), TREMOLO_BIN_DIR "/tremolo run " + scene + " --duration 10 --json");
  ASSERT_EQ(result.code, 0) << result.err;
  const auto report = nlohmann::json::parse(result.out);
  std::printf("%-7s scene    %s, energy %.6g J, drift %.1e\n", GetParam(),
              report["integrator"].get<std::string>().c_str(), report["energy_final"].get<double>(),
              report["energy_drift_max"].get<double>());
  EXPECT_NEAR(report["reached"].get<double>(), 10.0, 2e-3);
  EXPECT_LE(report["energy_drift_max"].get<double>(), 0.05);
}

// The fast methods are used, and their failures are detected.
TEST(LanesUnderTheSamplesLoads, AreWatchedAndPutBackToASoundStateWhereTheyExplode) {
  std::size_t exploded = 0;
  for (const char* name : kSampleNames) {
    Result<Model::Pointer> model =
        Model::load(std::string(TREMOLO_MODEL_DIR "/") + name + ".tremolo");
    ASSERT_TRUE(model) << model.error().message;
    // The energy that the load puts in, by the method that balances it.
    Body measure = std::move(*Body::create(*model));
    ASSERT_TRUE(measure.add_default_load({.kind = SignalKind::kSquare}));
    double most = 0.0;
    for (int k = 0; k < kPush; ++k) {
      ASSERT_TRUE(measure.step().converged);
      most = std::max(most, measure.sums().work);
    }
    const double largest = measure.state().q.norm();
    for (const LanePrecision precision : {LanePrecision::kDouble, LanePrecision::kFloat}) {
      Crowd world = std::move(*Crowd::create());
      const GroupId group =
          *world.add_group(*model, {.integrator = "imexv-linear", .precision = precision});
      const BodyId body = *world.add_body(group);
      const DefaultLoad& load = (*model)->default_load();
      ASSERT_TRUE(world.apply_force(body, load.vertices[0], load.forces[0], kPush));
      int step = 0;
      bool failed = false;
      for (; step < kSteps && !failed; ++step) {
        const CrowdReport& report = world.step();
        failed = !report.failed.empty();
        if (failed) {
          EXPECT_EQ(report.why[0], StepFailure::kEnergy) << name;
        }
      }
      if (!failed) continue;
      ++exploded;
      const State state = *world.state(body);
      std::printf("%-7s exploded by %.2f s, is at |q| = %.2g (largest under the load %.2g)\n", name,
                  3e-3 * step, state.q.norm(), largest);
      EXPECT_FALSE(*world.is_awake(body));
      EXPECT_LE(world.energy(body)->total(), 10.0 * 1.5 * most) << name;
      EXPECT_LE(state.q.norm(), 10.0 * largest) << name;
    }
  }
  EXPECT_GE(exploded, 4u);  // else the test checks nothing
}

}  // namespace
}  // namespace tremolo
