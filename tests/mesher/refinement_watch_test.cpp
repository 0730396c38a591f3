#include "precompute/mesher/cgal/refinement_watch.h"

#include <stdexcept>

#include <gtest/gtest.h>

namespace tremolo {
namespace {

// Questions until the watch ends it; 0 if it does not within `most`.
std::size_t questions_until_end(RefinementWatch& watch, std::size_t most, std::size_t each_vertex) {
  for (std::size_t i = 0; i < most; ++i) try {
      watch.step(1'000 + (each_vertex == 0 ? 0 : i / each_vertex));
    } catch (const std::runtime_error&) {
      return i + 1;
    }
  return 0;
}

TEST(RefinementWatch, EndsWhatStandsStillAfterTheSameCountEachTime) {
  RefinementWatch first({}), second({});
  const std::size_t end = questions_until_end(first, 1'000'000, 0);
  EXPECT_GT(end, 20'000U) << "scanning a mesh of 1 000 vertices is no standstill";
  EXPECT_LT(end, 100'000U);
  EXPECT_EQ(questions_until_end(second, 1'000'000, 0), end);
}

TEST(RefinementWatch, LetsWhatGoesOnGoOn) {
  RefinementWatch watch({});
  EXPECT_EQ(questions_until_end(watch, 1'000'000, 500), 0U);
}

TEST(RefinementWatch, EndsWhatGoesOnForEver) {
  RefinementWatch watch({.most_steps = 300'000});
  const std::size_t end = questions_until_end(watch, 1'000'000, 500);
  EXPECT_GE(end, 300'000U);
  EXPECT_LT(end, 302'000U);
  RefinementWatch crowded({.most_vertices = 1'500});
  EXPECT_GT(questions_until_end(crowded, 1'000'000, 500), 250'000U);
}

TEST(RefinementWatch, TellsHowFarItIsOnceItTakesLong) {
  testing::internal::CaptureStderr();
  RefinementWatch quick({.expected = 4'000});
  questions_until_end(quick, 10'000, 5);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  testing::internal::CaptureStderr();
  RefinementWatch slow({.expected = 4'000, .seconds = 1e-9});
  questions_until_end(slow, 10'000, 5);
  EXPECT_NE(testing::internal::GetCapturedStderr().find("of about 4000 vertices"),
            std::string::npos);
  EXPECT_EQ(progress_text(1'000, 4'000, 5),
            "meshing: 1000 of about 4000 vertices, 5 s, about 15 s more");
  EXPECT_NE(progress_text(5'000, 4'000, 5).find("more of them than usual"), std::string::npos);
}

}  // namespace
}  // namespace tremolo
