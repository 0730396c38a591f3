#include "runtime/split.h"

#include <numbers>

#include <gtest/gtest.h>

namespace tremolo {
namespace {

// h omega of 0.5, 1.79, 1.81, 3, 6.28, 6.29 at h = 1.
const Eigen::VectorXd kLambda =
    Eigen::Vector<double, 6>(0.5, 1.79, 1.81, 3.0, 6.28, 6.29).cwiseAbs2();

TEST(Split, DefaultTakesWhatIsStableWithAMargin) {
  const Result<Split> split = choose_split(kLambda, 1.0, {});
  EXPECT_EQ(split->low, 2);
  EXPECT_EQ(split->high, 4);
}

TEST(Split, SafetyOneIsTheStabilityLimit) {
  EXPECT_EQ(choose_split(kLambda, 1.0, {.safety = 1.0})->low, 3);
}

TEST(Split, ThesisRuleComparesTheFrequencyWithTheStepRate) {
  // 2 pi = 6.283...: the fifth is below, the sixth above.
  EXPECT_EQ(choose_split(kLambda, 1.0, {.rule = SplitRule::kThesis})->low, 5);
}

TEST(Split, ScalesWithTheStep) {
  EXPECT_EQ(choose_split(kLambda, 0.1, {})->low, 6);
  EXPECT_EQ(choose_split(kLambda, 10.0, {})->low, 0);
}

TEST(Split, CountIsTakenAsGivenWithinTheModel) {
  EXPECT_EQ(choose_split(kLambda, 1.0, {.rule = SplitRule::kCount, .count = 6})->high, 0);
  EXPECT_EQ(choose_split(kLambda, 1.0, {.rule = SplitRule::kCount, .count = 7}).error().kind,
            ErrorKind::kUsage);
}

TEST(Split, RefusesASafetyOutsideItsRange) {
  EXPECT_FALSE(choose_split(kLambda, 1.0, {.safety = 0.0}));
  EXPECT_FALSE(choose_split(kLambda, 1.0, {.safety = 1.01}));
}

TEST(Split, IsReadFromItsName) {
  EXPECT_EQ(parse_split("default")->rule, SplitRule::kDefault);
  EXPECT_EQ(parse_split("thesis")->rule, SplitRule::kThesis);
  EXPECT_EQ(parse_split("9")->count, 9);
  for (const char* bad : {"", "-1", "9x", "half", "99999999999"})
    EXPECT_EQ(parse_split(bad).error().kind, ErrorKind::kUsage) << bad;
}

}  // namespace
}  // namespace tremolo
