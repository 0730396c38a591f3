// Rayleigh damping has the requested ratios at both frequencies.
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "common/damping_ratios.h"

namespace tremolo {
namespace {

// Of a text of two pairs.
Result<RayleighDamping> rayleigh_of(const char* text) {
  const Result<DampingRatios> ratios = parse_damping(text);
  if (!ratios) return ratios.error();
  EXPECT_FALSE(ratios->of_each_mode()) << text;
  return ratios->rayleigh;
}

double ratio_at(const RayleighDamping& damping, double hertz) {
  const double w = 2 * std::numbers::pi * hertz;
  return damping.alpha / (2 * w) + damping.beta * w / 2;
}

TEST(DampingRatios, AreMetAtBothFrequencies) {
  const Result<RayleighDamping> damping = rayleigh_of("1.5:0.02,30:0.05");
  ASSERT_TRUE(damping) << damping.error().message;
  EXPECT_GT(damping->alpha, 0.0);
  EXPECT_GT(damping->beta, 0.0);
  EXPECT_NEAR(ratio_at(*damping, 1.5), 0.02, 1e-15);
  EXPECT_NEAR(ratio_at(*damping, 30), 0.05, 1e-15);
  EXPECT_LT(ratio_at(*damping, 7), 0.05);
  // In the other order they are the same.
  const Result<RayleighDamping> swapped = rayleigh_of("30:0.05,1.5:0.02");
  ASSERT_TRUE(swapped);
  EXPECT_NEAR(swapped->alpha, damping->alpha, 1e-15);
}

TEST(DampingRatios, ThatNeedOneOfTheTwoOnlyHaveTheOtherZero) {
  const Result<RayleighDamping> mass = rayleigh_of("2:0.1,20:0.01");
  ASSERT_TRUE(mass) << mass.error().message;
  EXPECT_NEAR(mass->beta, 0.0, 1e-17);
  EXPECT_NEAR(ratio_at(*mass, 2), 0.1, 1e-15);
  const Result<RayleighDamping> stiffness = rayleigh_of("2:0.01,20:0.1");
  ASSERT_TRUE(stiffness) << stiffness.error().message;
  EXPECT_NEAR(stiffness->alpha, 0.0, 1e-14);
}

TEST(DampingRatios, ThatNeedNegativeDampingAreRefusedWithTheBounds) {
  const Result<RayleighDamping> steep = rayleigh_of("1:0.01,10:0.5");
  ASSERT_FALSE(steep);
  EXPECT_EQ(steep.error().kind, ErrorKind::kContent);
  EXPECT_NE(steep.error().message.find("between 0.001 and 0.1"), std::string::npos)
      << steep.error().message;
}

TEST(DampingRatios, OfAnotherFormAreRefused) {
  for (const char* text : {"", "1:0.1", "1:0.1,", "1:0.1,2:x", "1:0.1,0.1", "1:0.1:0.1,2:0.1"}) {
    const Result<RayleighDamping> wrong = rayleigh_of(text);
    ASSERT_FALSE(wrong) << text;
    EXPECT_EQ(wrong.error().kind, ErrorKind::kUsage) << text;
  }
  for (const char* text :
       {"0:0.1,2:0.1", "1:0.1,1:0.2", "1:-0.1,2:0.1", "1:1,2:0.1", "inf:0.1,2:0.1"}) {
    const Result<RayleighDamping> wrong = rayleigh_of(text);
    ASSERT_FALSE(wrong) << text;
    EXPECT_EQ(wrong.error().kind, ErrorKind::kContent) << text;
  }
}

}  // namespace
}  // namespace tremolo
