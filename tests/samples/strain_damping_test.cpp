// Stiffness damping of the samples: the decay of the first mode does not depend on how far it
// swings, and the notes before a run give the limit of its explicit half.
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "runtime/apps/tremolo/start/run_notes.h"
#include "runtime/apps/tremolo/start/start_state.h"
#include "runtime/body.h"
#include "tests/support/run_program.h"

namespace tremolo {
namespace {

constexpr double kRatio = 0.0135;  // of critical damping in the first mode
constexpr int kCrossings = 6;      // three periods

Model::Pointer model_named(const std::string& name) {
  const auto model = Model::load(std::string(TREMOLO_MODEL_DIR) + "/" + name + ".tremolo");
  EXPECT_TRUE(model) << model.error().message;
  return *model;
}

// The speed in coordinate 0 that moves some vertex by a fraction of the body's size.
double speed_for(const Model& model, double share) {
  const VertexBlock& surface = model.surface();
  Eigen::Vector3d low = surface.rest[0], high = low;
  double farthest = 0.0;
  for (std::size_t v = 0; v < surface.rest.size(); ++v) {
    low = low.cwiseMin(surface.rest[v]);
    high = high.cwiseMax(surface.rest[v]);
    farthest =
        std::max(farthest, surface.rows.block(3 * static_cast<Eigen::Index>(v), 0, 3, 1).norm());
  }
  return share * (high - low).norm() / farthest * std::sqrt(model.lambda()[0]);
}

// Energy left when coordinate 0 is zero for the sixth time, of the kick at the start.
double energy_left(const Model::Pointer& model, const char* method, double share) {
  const double omega = std::sqrt(model->lambda()[0]);
  auto body = Body::create(model, method, {.step = 3e-3, .beta = 2.0 * kRatio / omega});
  EXPECT_TRUE(body) << body.error().message;
  Eigen::VectorXd q = Eigen::VectorXd::Zero(model->modes()), p = q;
  p[0] = speed_for(*model, share);
  EXPECT_TRUE(body->set_state(q, p));
  const double start = body->energy().total();
  double before = start, q_before = 0.0;
  for (int crossings = 0;;) {
    EXPECT_TRUE(body->step().converged);
    const double now = body->energy().total(), q_now = body->state().q[0];
    if (body->counts().steps > 1 && (q_now < 0.0) != (q_before < 0.0) &&
        ++crossings == kCrossings) {
      const double part = q_before / (q_before - q_now);
      return (before + part * (now - before)) / start;
    }
    q_before = q_now;
    before = now;
    if (body->counts().steps > 100000) return 0.0;
  }
}

double linear_theory() {
  return std::exp(-2.0 * kCrossings * std::numbers::pi * kRatio / std::sqrt(1.0 - kRatio * kRatio));
}

TEST(StrainDampingOfSamples, ABeamLosesWhatLinearTheorySaysHoweverFarItSwings) {
  const Model::Pointer beam = model_named("beam");
  for (const char* method : {"ep4", "ep2", "newmark", "midpoint"})
    for (const double share : {0.01, 0.03, 0.1, 0.2})
      EXPECT_NEAR(energy_left(beam, method, share) / linear_theory(), 1.0, 0.02)
          << method << ", " << share;
}

// Beyond, the horse's modes exchange energy: at 10 and 20 % its undamped motion has 8 and 30 % in
// other coordinates at the end, and those die sooner.
TEST(StrainDampingOfSamples, AHorseDoesWhileItsModesKeepToThemselves) {
  const Model::Pointer horse = model_named("horse");
  for (const char* method : {"ep4", "ep2", "newmark", "midpoint"})
    for (const double share : {0.01, 0.03})
      EXPECT_NEAR(energy_left(horse, method, share) / linear_theory(), 1.0, 0.02)
          << method << ", " << share;
}

// Shaken along z at its first frequency the coordinate 0 swings by s A/(2 zeta), s its part in a
// motion of the support by A: 3 % of the size at some vertex. The transient has died by exp(-10).
TEST(StrainDampingOfSamples, AShakenBeamSwingsAtResonanceAsTheClosedFormSays) {
  const Model::Pointer beam = model_named("beam");
  const double omega = std::sqrt(beam->lambda()[0]);
  const Eigen::Vector3d along = beam->inertia()->linear.col(0).head<3>();
  const double expected = speed_for(*beam, 0.03) / omega;
  const double amplitude = expected * 2.0 * kRatio / along.norm();
  for (const char* method : {"ep4", "ep2", "newmark"}) {
    auto body = Body::create(beam, method, {.step = 3e-3, .beta = 2.0 * kRatio / omega},
                             FrameKind::kDriven);
    ASSERT_TRUE(body) << body.error().message;
    const int steps = static_cast<int>(10.0 / (kRatio * omega) / 3e-3);
    const int period = static_cast<int>(2.0 * std::numbers::pi / omega / 3e-3) + 1;
    double most = 0.0;
    for (int k = 1; k <= steps; ++k) {
      const double t = k * 3e-3, middle = t - 1.5e-3;
      FrameMotion motion;
      motion.acceleration =
          -amplitude * omega * omega * std::sin(omega * middle) * along.normalized();
      const Eigen::Vector3d place = amplitude * std::sin(omega * t) * along.normalized();
      ASSERT_TRUE(body->move_to({place, Eigen::Quaterniond::Identity()}, motion));
      ASSERT_TRUE(body->step().converged);
      if (k > steps - period) most = std::max(most, std::abs(body->state().q[0]));
    }
    EXPECT_NEAR(most / expected, 1.0, 0.005) << method;
  }
}

std::vector<std::string> notes_of(const char* method, double bend) {
  const Model::Pointer beam = model_named("beam");
  auto body = Body::create(beam, method, {});
  EXPECT_TRUE(body);
  const Eigen::VectorXd no_load = Eigen::VectorXd::Zero(beam->modes());
  const auto start = start_state("vertex:496=0,0,-" + std::to_string(bend), *beam, no_load);
  EXPECT_TRUE(start) << start.error().message;
  EXPECT_TRUE(body->set_state(start->q, start->p));
  return notes_before(*body, no_load);
}

TEST(StrainDampingOfSamples, ANoteTellsWhetherTheExplicitHalfWillStandTheStart) {
  EXPECT_TRUE(notes_of("imexv", 0.08).empty());
  ASSERT_EQ(notes_of("imexv", 0.1).size(), 1U);
  EXPECT_NE(notes_of("imexv", 0.1)[0].find("0.0028 s"), std::string::npos)
      << notes_of("imexv", 0.1)[0];
  for (const char* method : {"ep4", "newmark", "imexv-adaptive"})
    EXPECT_TRUE(notes_of(method, 0.1).empty()) << method;
}

// The kicks of a split and what is between them balance each other in stiff coordinates. Damping
// within the kicks of imexv-linear took a thousand times the energy that was there.
TEST(StrainDampingOfSamples, TheSplitsTakeAsMuchAsTheDefault) {
  const Model::Pointer beam = model_named("beam");
  const auto start =
      start_state("vertex:496=0,0,-0.02", *beam, Eigen::VectorXd::Zero(beam->modes()));
  ASSERT_TRUE(start);
  const auto taken = [&](const char* method, double step) {
    auto body = Body::create(beam, method, {.step = step, .beta = 1e-3});
    EXPECT_TRUE(body && body->set_state(start->q, start->p));
    const auto steps = static_cast<int>(std::lround(2.1 / step));
    for (int k = 0; k < steps; ++k) EXPECT_TRUE(body->step().converged);
    return body->sums().dissipated;
  };
  const double expected = taken("ep4", 0.75e-3);
  for (const char* method : {"imexv-linear", "imexv", "imexv-coupled"})
    for (const double step : {3e-3, 1.5e-3, 0.75e-3})
      EXPECT_NEAR(taken(method, step), expected, 2e-3 * expected) << method << ", " << step;
}

TEST(StrainDampingOfSamples, WhatANoteAnnouncesHappensAndWhatItDoesNotDoesNot) {
  const Model::Pointer beam = model_named("beam");
  for (const double bend : {0.08, 0.1}) {
    auto body = Body::create(beam, "imexv", {});
    ASSERT_TRUE(body);
    const auto start = start_state("vertex:496=0,0,-" + std::to_string(bend), *beam,
                                   Eigen::VectorXd::Zero(beam->modes()));
    ASSERT_TRUE(start);
    ASSERT_TRUE(body->set_state(start->q, start->p));
    bool broke_off = false;
    for (int k = 0; k < 1000 && !broke_off; ++k) broke_off = !body->step().converged;
    EXPECT_EQ(broke_off, bend > 0.09) << bend;
  }
}

}  // namespace
}  // namespace tremolo
