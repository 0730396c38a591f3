// The orbits that the viewer plays in place of a body's state.
#include "runtime/apps/view/live/mode_orbits.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "runtime/response/orbit.h"
#include "runtime/response/probe.h"
#include "tests/support/dynamics.h"

namespace tremolo {
namespace {

Model::Pointer small_model() {
  return testing::make_model(
      testing::random_strain_model(testing::spread_omega(3, 6.0, 30.0), 0.3, 3));
}

TEST(ModeOrbits, AMotionOfAnyAmplitudeIsFreeMotionOfTheBody) {
  const Model::Pointer model = small_model();
  const Result<ModeOrbits> orbits = mode_orbits(*model, 0);
  ASSERT_TRUE(orbits) << orbits.error().message;
  EXPECT_NEAR(orbits->linear_hz, 6.0 / (2.0 * std::numbers::pi), 1e-12);
  const double share = 0.5 * orbits->largest();
  const CurvePoint point = orbits->at(share);
  EXPECT_NEAR(point.amplitude, share * extent_of(*model), 1e-12);
  const State start = orbit_state(point, 0.0);
  constexpr int kSteps = 1000;
  Result<Body> body = Body::create(
      model, "ep4", {.step = 2.0 * std::numbers::pi / point.omega / kSteps, .tolerance = 1e-10});
  ASSERT_TRUE(body);
  ASSERT_TRUE(body->set_state(start.q, start.p));
  for (int n = 0; n < kSteps; ++n) ASSERT_TRUE(body->step().converged);
  // Between two points of the curve, 5 % apart, the motion is interpolated: an error below 1 %.
  EXPECT_LE((body->state().q - start.q).norm(), 1e-2 * start.q.norm());
}

TEST(ModeOrbits, TheFinderFindsThemOnItsOwnThreadAndEndsWhenItIsDestroyed) {
  const Model::Pointer model = small_model();
  OrbitFinder finder;
  EXPECT_FALSE(finder.take_found());
  finder.find(*model, 1);
  std::optional<Result<ModeOrbits>> found;
  while (!found) found = finder.take_found();
  ASSERT_TRUE(*found) << found->error().message;
  EXPECT_EQ((*found)->mode, 1);
  EXPECT_FALSE(finder.searches());
  finder.find(*model, 0);
}

TEST(ModeOrbits, WrongRequestsAreRefused) {
  EXPECT_EQ(mode_orbits(*small_model(), 3).error().kind, ErrorKind::kContent);
  for (const char* text : {"1", "1:", ":8%", "1:8%x", "one:8%"})
    EXPECT_EQ(parse_orbit_request(text).error().kind, ErrorKind::kUsage) << text;
  for (const char* text : {"0:8%", "1.5:8%", "1:0%", "1:-2%", "1:16%", "1:nan"})
    EXPECT_EQ(parse_orbit_request(text).error().kind, ErrorKind::kContent) << text;
  const Result<OrbitRequest> request = parse_orbit_request("2:8%");
  ASSERT_TRUE(request);
  EXPECT_EQ(request->mode, 1);
  EXPECT_NEAR(request->share, 0.08, 1e-15);
  EXPECT_NEAR(parse_orbit_request("2:0.05")->share, 0.05, 1e-15);
}

}  // namespace
}  // namespace tremolo
