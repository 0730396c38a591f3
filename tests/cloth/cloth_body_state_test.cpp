// The state of a cloth between steps (ClothBody::carry): a cloth that is put back continues with
// the same bits, by every method.
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "common/state_stream.h"
#include "runtime/bodies/cloth/cloth_body.h"

namespace tremolo {
namespace {

constexpr int kBefore = 23, kAfter = 30;

// A long step where the method allows it, s: methods then guard their energy.
double step_of(std::string_view method) {
  return stability_number(method) < HUGE_VAL ? 5e-5 : 4e-3;
}

// A sheet in the wind with a corner that is released later, and one that moves.
ClothBody waving_sheet(std::string_view method, NodalSolver solver = NodalSolver::kAutomatic,
                       std::size_t side = 6, double stiffness = 100.0) {
  ClothScene scene;
  scene.integrator = method;
  scene.options.step = step_of(method);
  scene.options.solver = solver;
  scene.gravity = {{0.0, 1.0}, {{0.0, 0.0, -9.81}, {3.0, 0.0, -9.81}}};
  scene.wind = {2.0, 5.0, 0.0};
  scene.gust = 0.8;
  scene.gust_hz = 20.0;
  SceneCloth cloth;
  cloth.grid = {side, side, 0.3, 0.3};
  cloth.structural = {stiffness, 0.01};
  cloth.shear = {30.0, 0.01};
  cloth.bend = {1.0, 0.001};
  cloth.crumple = 0.1;
  ClothPin soon, moved;
  soon.particles = {0};
  soon.until = (kBefore + 5) * scene.options.step;
  moved.particles = {side - 1};
  moved.motion.parts = {GlideMotion{{0.0, 0.0, 0.3}, {}}};
  cloth.pins = {soon, moved};
  scene.cloths = {cloth};
  Result<ClothBody> body = ClothBody::create(scene);
  EXPECT_TRUE(body) << method << body.error().message;
  return std::move(*body);
}

void advance(ClothBody& body, int steps) {
  for (int i = 0; i < steps; ++i) {
    body.begin_step();
    ASSERT_TRUE(body.step().made) << body.integrator();
  }
}

TEST(ClothBodyState, ContinuesWithTheSameBitsByEveryMethod) {
  for (const std::string_view method : nodal_integrator_names())
    for (const NodalSolver solver : {NodalSolver::kAutomatic, NodalSolver::kConjugateGradients}) {
      ClothBody whole = waving_sheet(method, solver);
      advance(whole, kBefore);
      const std::string saved = state_bytes(whole);
      advance(whole, kAfter);
      ClothBody rest = waving_sheet(method, solver);
      ASSERT_TRUE(restore_state(rest, saved)) << method;
      EXPECT_EQ(state_bytes(rest), saved) << method;
      advance(rest, kAfter);
      EXPECT_EQ(state_bytes(rest), state_bytes(whole)) << method;
      // Back to before the pin was released.
      ASSERT_TRUE(restore_state(whole, saved)) << method;
      advance(whole, kAfter);
      EXPECT_EQ(state_bytes(rest), state_bytes(whole)) << method;
    }
}

// Its solver has given conjugate gradients up for some systems.
TEST(ClothBodyState, ContinuesWithTheSameBitsOnALargeSheet) {
  constexpr std::size_t kSide = 40;
  ClothBody whole = waving_sheet("implicit-euler", NodalSolver::kAutomatic, kSide, 1e5);
  advance(whole, 3);
  const std::string saved = state_bytes(whole);
  advance(whole, 2);
  ClothBody rest = waving_sheet("implicit-euler", NodalSolver::kAutomatic, kSide, 1e5);
  ASSERT_TRUE(restore_state(rest, saved));
  advance(rest, 2);
  EXPECT_TRUE(state_bytes(rest) == state_bytes(whole));
}

TEST(ClothBodyState, OfBytesThatAreCutOrNoNumbersIsRefused) {
  ClothBody body = waving_sheet("bdf2");
  advance(body, kBefore);
  const std::string saved = state_bytes(body);
  for (std::size_t size = 0; size < saved.size(); size += 97)
    EXPECT_FALSE(restore_state(body, saved.substr(0, size))) << size;
  EXPECT_FALSE(restore_state(body, saved + "x"));
  std::string bad = saved;
  bad.replace(16, 8, std::string(8, '\xff'));  // not a number
  EXPECT_FALSE(restore_state(body, bad));
  EXPECT_EQ(state_bytes(body), saved);
}

}  // namespace
}  // namespace tremolo
