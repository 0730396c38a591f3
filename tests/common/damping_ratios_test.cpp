#include "common/damping_ratios.h"

#include <gtest/gtest.h>

namespace tremolo {
namespace {

TEST(DampingOfModes, OneRatioIsThatOfEveryMode) {
  for (const char* text : {"2%", "0.02"}) {
    const Result<DampingRatios> ratios = parse_damping(text);
    ASSERT_TRUE(ratios) << text;
    EXPECT_TRUE(ratios->of_each_mode());
    for (const std::size_t mode : {0U, 7U}) EXPECT_DOUBLE_EQ(ratio_of(*ratios, mode, 3.0), 0.02);
  }
}

TEST(DampingOfModes, AListEndsWithTheRatioOfAllFurtherModes) {
  const Result<DampingRatios> ratios = parse_damping("2%,0.01,5%");
  ASSERT_TRUE(ratios);
  EXPECT_DOUBLE_EQ(ratio_of(*ratios, 0, 1.0), 0.02);
  EXPECT_DOUBLE_EQ(ratio_of(*ratios, 1, 1.0), 0.01);
  EXPECT_DOUBLE_EQ(ratio_of(*ratios, 2, 1.0), 0.05);
  EXPECT_DOUBLE_EQ(ratio_of(*ratios, 20, 1.0), 0.05);
}

TEST(DampingOfModes, ATableHasStraightLinesBetweenItsFrequencies) {
  const Result<DampingRatios> ratios = parse_damping("1:2%,10:1%,30:0.05");
  ASSERT_TRUE(ratios);
  EXPECT_DOUBLE_EQ(ratio_of(*ratios, 0, 0.5), 0.02);
  EXPECT_DOUBLE_EQ(ratio_of(*ratios, 0, 1.0), 0.02);
  EXPECT_DOUBLE_EQ(ratio_of(*ratios, 0, 5.5), 0.015);
  EXPECT_DOUBLE_EQ(ratio_of(*ratios, 0, 20.0), 0.03);
  EXPECT_DOUBLE_EQ(ratio_of(*ratios, 0, 50.0), 0.05);
}

TEST(DampingOfModes, TwoPairsAreRayleighDampingAlsoInPercent) {
  const Result<DampingRatios> ratios = parse_damping("1.5:2%,30:5%");
  const Result<RayleighDamping> rayleigh = parse_damping_ratios("1.5:0.02,30:0.05");
  ASSERT_TRUE(ratios);
  ASSERT_TRUE(rayleigh);
  EXPECT_FALSE(ratios->of_each_mode());
  EXPECT_DOUBLE_EQ(ratios->rayleigh.alpha, rayleigh->alpha);
  EXPECT_DOUBLE_EQ(ratios->rayleigh.beta, rayleigh->beta);
}

TEST(DampingOfModes, WrongTextsAreRefused) {
  for (const char* text : {"", "x", "2%,", "1:0.1", "1:0.1,0.2", "0.1,1:0.2", "%", "2%%", ":0.1"}) {
    const Result<DampingRatios> wrong = parse_damping(text);
    ASSERT_FALSE(wrong) << text;
    EXPECT_EQ(wrong.error().kind, ErrorKind::kUsage) << text;
  }
  for (const char* text :
       {"1", "-1%", "100%", "nan", "1:0.1,3:0.1,2:0.1", "0:0.1,1:0.1,2:0.1", "1:0.1,1:0.2"}) {
    const Result<DampingRatios> wrong = parse_damping(text);
    ASSERT_FALSE(wrong) << text;
    EXPECT_EQ(wrong.error().kind, ErrorKind::kContent) << text;
  }
}

}  // namespace
}  // namespace tremolo
