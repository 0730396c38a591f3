// Distances on a grid and the spline between them.
#include "common/distance/distance_grid.h"

#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "tests/support/distance_fields.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

Vector3d point_in(const BoundingBox& box, std::mt19937& random) {
  std::uniform_real_distribution<double> share(0.0, 1.0);
  const double x = share(random), y = share(random), z = share(random);
  return box.low + (box.high - box.low).cwiseProduct(Vector3d(x, y, z));
}

// Largest errors of value and gradient at points whose distance is below `near`.
struct GridErrors {
  double value = 0;
  double gradient = 0;
};

GridErrors errors_of(const testing::DistanceFormula& formula, std::uint32_t cells, double near) {
  const DistanceGrid grid = testing::grid_of(testing::cube_of_nodes(1.5, cells), formula);
  std::mt19937 random(7);
  GridErrors errors;
  for (int trial = 0; trial < 100000; ++trial) {
    const Vector3d x = point_in(grid.box(), random);
    const double exact = formula(x);
    if (std::abs(exact) > near) continue;
    const DistanceGrid::Sample sample = grid.at(x);
    errors.value = std::max(errors.value, std::abs(sample.distance - exact));
    Vector3d gradient;
    constexpr double kStep = 1e-6;
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3d step = kStep * Vector3d::Unit(axis);
      gradient[axis] = (formula(x + step) - formula(x - step)) / (2.0 * kStep);
    }
    errors.gradient = std::max(errors.gradient, (sample.gradient - gradient).norm());
  }
  return errors;
}

TEST(DistanceGrid, TakesTheValuesAtItsNodes) {
  const GridNodes nodes = testing::cube_of_nodes(1.5, 12);
  const std::vector<float> values = testing::values_at_nodes(nodes, testing::sphere_formula(1.0));
  const DistanceGrid grid = testing::grid_of(nodes, testing::sphere_formula(1.0));
  std::size_t at = 0;
  for (std::size_t k = 0; k < nodes.counts[2]; ++k)
    for (std::size_t j = 0; j < nodes.counts[1]; ++j)
      for (std::size_t i = 0; i < nodes.counts[0]; ++i)
        // Three passes round to float.
        ASSERT_NEAR(grid.at(nodes.at(i, j, k)).distance, values[at++], 1e-6);
}

// Also in the outermost cells, where the spline continues its neighbour.
TEST(DistanceGrid, ReproducesQuadraticPolynomials) {
  const testing::DistanceFormula quadratic = [](const Vector3d& x) {
    return 2.0 + 0.1 * x.x() - 0.2 * x.y() + 0.05 * x.x() * x.x() - 0.04 * x.y() * x.z() +
           0.06 * x.z() * x.z() + 0.03 * x.x() * x.y() * x.z();
  };
  GridNodes nodes = testing::cube_of_nodes(1.5, 8);
  nodes.counts = {9, 4, 6};
  const DistanceGrid grid = testing::grid_of(nodes, quadratic);
  std::mt19937 random(8);
  for (int trial = 0; trial < 2000; ++trial) {
    const Vector3d x = point_in(grid.box(), random);
    EXPECT_NEAR(grid.at(x).distance, quadratic(x), 2e-6);
    EXPECT_NEAR(grid.at(x).gradient.y(), -0.2 - 0.04 * x.z() + 0.03 * x.x() * x.z(), 1e-5);
  }
}

// Below 1e-6 the values' rounding to float is seen.
TEST(DistanceGrid, ErrorFallsByThirdOrderWhereTheDistanceIsSmooth) {
  for (const testing::DistanceFormula& formula :
       {testing::sphere_formula(1.0), testing::torus_formula(0.9, 0.4)}) {
    const GridErrors coarse = errors_of(formula, 32, 0.15), fine = errors_of(formula, 64, 0.15);
    const double value_order = std::log2(coarse.value / fine.value);
    const double gradient_order = std::log2(coarse.gradient / fine.gradient);
    EXPECT_GT(value_order, 2.6);
    EXPECT_GT(gradient_order, 1.7);
    EXPECT_LT(fine.value, 1e-3);
    RecordProperty("value_order", std::to_string(value_order));
  }
}

// The kink at a box's edges counts: first order, and a quarter of a cell at most.
TEST(DistanceGrid, ErrorFallsByFirstOrderAtEdges) {
  const testing::DistanceFormula formula = testing::box_formula({0.8, 0.9, 0.7});
  const GridErrors coarse = errors_of(formula, 32, 0.2), fine = errors_of(formula, 64, 0.2);
  EXPECT_GT(std::log2(coarse.value / fine.value), 0.8);
  EXPECT_LT(fine.value, 0.25 * 3.0 / 64);
}

TEST(DistanceGrid, GradientIsThatOfTheInterpolant) {
  const DistanceGrid grid =
      testing::grid_of(testing::cube_of_nodes(1.5, 16), testing::box_formula({0.8, 0.9, 0.7}));
  std::mt19937 random(9);
  constexpr double kStep = 1e-5;
  const BoundingBox wider{2.0 * grid.box().low, 2.0 * grid.box().high};
  for (int trial = 0; trial < 5000; ++trial) {
    const Vector3d x = point_in(wider, random);
    const DistanceGrid::Sample here = grid.at(x);
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3d step = kStep * Vector3d::Unit(axis);
      const bool crosses_border = std::abs(x[axis] - grid.box().low[axis]) < 2.0 * kStep ||
                                  std::abs(x[axis] - grid.box().high[axis]) < 2.0 * kStep;
      if (crosses_border) continue;
      const double difference =
          (grid.at(x + step).distance - grid.at(x - step).distance) / (2.0 * kStep);
      // A border of cells in between adds half the step times the jump of the second derivative.
      EXPECT_NEAR(difference, here.gradient[axis], 5e-5);
    }
  }
}

// The pieces of the spline meet halfway between the nodes.
TEST(DistanceGrid, ValueAndGradientAreContinuousAcrossCells) {
  const DistanceGrid grid =
      testing::grid_of(testing::cube_of_nodes(1.5, 16), testing::box_formula({0.8, 0.9, 0.7}));
  std::mt19937 random(10);
  std::uniform_int_distribution<int> cell(0, 30);
  for (int trial = 0; trial < 5000; ++trial) {
    Vector3d x = point_in(grid.box(), random);
    const int axis = trial % 3;
    x[axis] = grid.nodes().origin[axis] + 0.5 * (1 + cell(random)) * grid.nodes().spacing;
    const Vector3d step = 1e-12 * Vector3d::Unit(axis);
    const DistanceGrid::Sample below = grid.at(x - step), above = grid.at(x + step);
    EXPECT_NEAR(below.distance, above.distance, 1e-11);
    EXPECT_NEAR((below.gradient - above.gradient).norm(), 0.0, 1e-10);
  }
}

TEST(DistanceGrid, ValueIsContinuousAcrossTheBorderAndGrowsBeyond) {
  const testing::DistanceFormula formula = testing::sphere_formula(1.0);
  const DistanceGrid grid = testing::grid_of(testing::cube_of_nodes(1.5, 16), formula);
  std::mt19937 random(11);
  for (int trial = 0; trial < 5000; ++trial) {
    Vector3d x = point_in(grid.box(), random);
    const int axis = trial % 3;
    const bool high = trial % 2 == 0;
    x[axis] = high ? grid.box().high[axis] : grid.box().low[axis];
    const Vector3d out = (high ? 1.0 : -1.0) * Vector3d::Unit(axis);
    EXPECT_NEAR(grid.at(x - 1e-12 * out).distance, grid.at(x + 1e-12 * out).distance, 4e-12);
    const DistanceGrid::Sample far = grid.at(x + 2.0 * out);
    EXPECT_NEAR(far.distance, grid.at(x).distance + 2.0, 1e-14);
    EXPECT_GE(far.distance, formula(x + 2.0 * out) - 1e-3);
    EXPECT_EQ(far.gradient[axis], out[axis]);
  }
}

TEST(DistanceGrid, SolidBoxContainsTheSolidAndIsNotMuchWider) {
  for (const std::uint32_t cells : {10U, 33U}) {
    const GridNodes nodes = testing::cube_of_nodes(1.5, cells);
    const BoundingBox box =
        testing::grid_of(nodes, testing::box_formula({0.8, 0.9, 0.7})).solid_box();
    const Vector3d half(0.8, 0.9, 0.7);
    EXPECT_TRUE((box.high.array() >= half.array()).all());
    EXPECT_TRUE((box.low.array() <= -half.array()).all());
    EXPECT_LE((box.high - half).maxCoeff(), 2.0 * nodes.spacing);
    EXPECT_LE((-half - box.low).maxCoeff(), 2.0 * nodes.spacing);
  }
}

TEST(DistanceGrid, StaysInItsMemoryWhateverThePoint) {
  const DistanceGrid grid =
      testing::grid_of(testing::cube_of_nodes(1.5, 5), testing::sphere_formula(1.0));
  const double odd[] = {std::numeric_limits<double>::quiet_NaN(),
                        std::numeric_limits<double>::infinity(),
                        -std::numeric_limits<double>::infinity(),
                        1e300,
                        -1e300,
                        0.0};
  double sum = 0.0;
  for (const double x : odd)
    for (const double y : odd)
      for (const double z : odd) sum += grid.at({x, y, z}).distance;
  EXPECT_TRUE(std::isnan(sum));
  EXPECT_TRUE(std::isfinite(grid.at({1e300, -1e300, 0.0}).distance));
}

TEST(DistanceGrid, WhatIsNoGridOfDistancesIsRefused) {
  const GridNodes nodes = testing::cube_of_nodes(1.5, 8);
  const std::vector<float> values = testing::values_at_nodes(nodes, testing::sphere_formula(1.0));
  const auto refusal = [](const GridNodes& at, const std::vector<float>& of) {
    const Result<DistanceGrid> grid = DistanceGrid::create(at, of);
    EXPECT_FALSE(grid);
    return grid ? std::string() : grid.error().message;
  };
  std::vector<float> bad = values;
  bad[364] += 1.0F;
  EXPECT_NE(refusal(nodes, bad).find("by more than they are apart"), std::string::npos);
  bad[364] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_NE(refusal(nodes, bad).find("node (4, 4, 4) is not finite or larger"), std::string::npos);
  bad = values;
  bad.pop_back();
  EXPECT_NE(refusal(nodes, bad).find("728 distances for 729 nodes"), std::string::npos);
  EXPECT_NE(refusal(testing::cube_of_nodes(0.9, 8),
                    testing::values_at_nodes(testing::cube_of_nodes(0.9, 8),
                                             testing::sphere_formula(1.0)))
                .find("needs a margin"),
            std::string::npos);
  GridNodes odd = nodes;
  odd.counts = {3, 9, 27};
  EXPECT_NE(refusal(odd, values).find("3 nodes along an axis"), std::string::npos);
  odd.counts = {4096, 4096, 4096};
  EXPECT_NE(refusal(odd, values).find("at most"), std::string::npos);
  for (const double spacing : {0.0, -1.0, 1e-12, std::numeric_limits<double>::quiet_NaN(), 1e300}) {
    odd = nodes;
    odd.spacing = spacing;
    EXPECT_NE(refusal(odd, values).find("origin or spacing"), std::string::npos) << spacing;
  }
}

}  // namespace
}  // namespace tremolo
