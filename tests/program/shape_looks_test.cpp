// The times at which a run checks the shape; a check changes nothing.
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "runtime/apps/tremolo/output/stretch.h"
#include "tests/support/sample_basis.h"

namespace tremolo {
namespace {

Model::Pointer small_model() {
  Result<Model::Pointer> model = Model::from_data(testing::sample_basis(
      testing::random_strain_model(Eigen::Vector3d(10.0, 20.0, 30.0), 0.0, 1)));
  EXPECT_TRUE(model);
  return *model;
}

TEST(ShapeLooks, AreEveryTenthStepOfAShortRunAndAThousandOfALongOne) {
  const Model::Pointer model = small_model();
  const Eigen::VectorXd still = Eigen::VectorXd::Zero(3);
  for (const auto& [steps, looks] : {std::pair{1'000, 100}, {10'000, 1'000}, {144'000, 1'000}}) {
    ShapeLooks due(*model, 10, steps);
    int seen = 0;
    for (int k = 0; k < steps; ++k) seen += due.due(k, still) ? 1 : 0;
    EXPECT_EQ(seen, looks) << steps;
  }
}

// A blow rings on: its maximum is found to a twentieth, wherever it is between the checks.
TEST(ShapeLooks, TheLargestMotionOfALongRunIsSeen) {
  const Model::Pointer model = small_model();
  constexpr int kSteps = 1'000'000;
  for (const int peak : {501, 123'457}) {
    ShapeLooks looks(*model, 10, kSteps);
    double largest = 0.0, seen = 0.0;
    int count = 0;
    for (int k = 0; k < kSteps; ++k) {
      const double x = (k - peak) / 200.0;
      const Eigen::Vector3d q(std::exp(-x * x), 0.0, 0.0);
      largest = std::max(largest, q[0]);
      if (!looks.due(k, q)) continue;
      seen = std::max(seen, q[0]);
      ++count;
    }
    EXPECT_GE(seen, largest / 1.05) << peak;
    EXPECT_LT(count, 2'000) << peak;
  }
}

// A look that is left out would have changed neither the displacement nor the stretches.
TEST(ShapeLooks, ALookIsLeftOutOnlyWhereItChangesNothing) {
  const Model::Pointer model = small_model();
  Result<Body> body = Body::create(model, "verlet", {});
  ASSERT_TRUE(body);
  SurfaceStretch stretch(*model);
  ShapeLooks looks(*model, 10, 100);
  std::mt19937 generator(5);
  std::normal_distribution<double> normal;
  StretchRange range;
  double farthest = 0.0;
  int left_out = 0;
  for (int k = 0; k < 2'000; ++k) {
    const double size = std::exp(-k / 300.0);
    const Eigen::Vector3d q =
        size * Eigen::Vector3d(normal(generator), normal(generator), normal(generator));
    ASSERT_TRUE(body->set_state(q, Eigen::Vector3d::Zero()));
    const StretchRange now = stretch.measure(*body);
    const double here = stretch.farthest().distance;
    if (!looks.can_exceed(q, farthest, range)) {
      ++left_out;
      EXPECT_LE(here, farthest * (1.0 + 1e-12));
      EXPECT_LE(now.largest, range.largest * (1.0 + 1e-12));
      EXPECT_GE(now.smallest, range.smallest * (1.0 - 1e-12));
    }
    farthest = std::max(farthest, here);
    range.smallest = std::min(range.smallest, now.smallest);
    range.largest = std::max(range.largest, now.largest);
  }
  EXPECT_GT(left_out, 500);
}

}  // namespace
}  // namespace tremolo
