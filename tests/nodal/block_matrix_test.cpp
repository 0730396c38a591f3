// Sparse matrices of 3 x 3 blocks against dense ones of Eigen.
#include <algorithm>
#include <numeric>
#include <random>
#include <vector>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include "runtime/math/sparse/block_cholesky.h"
#include "runtime/math/sparse/conjugate_gradients.h"
#include "runtime/math/sparse/quick_factor.h"

namespace tremolo {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Case {
  BlockMatrix sparse;
  MatrixXd dense;
};

// A grid of springs with chance in them; positive definite.
Case random_grid(std::size_t rows, std::size_t columns, unsigned seed) {
  std::mt19937 engine(seed);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  std::vector<NodePair> pairs;
  const auto node = [columns](std::size_t i, std::size_t j) {
    return static_cast<std::uint32_t>(i * columns + j);
  };
  for (std::size_t i = 0; i < rows; ++i)
    for (std::size_t j = 0; j < columns; ++j) {
      if (i + 1 < rows) pairs.emplace_back(node(i, j), node(i + 1, j));
      if (j + 1 < columns) pairs.emplace_back(node(i, j + 1), node(i, j));
      if (i + 2 < rows && j + 2 < columns) pairs.emplace_back(node(i, j), node(i + 2, j + 2));
      if (i + 1 < rows) pairs.emplace_back(node(i, j), node(i + 1, j));  // twice
    }
  Case made{BlockMatrix(*BlockPattern::create(rows * columns, pairs)), {}};
  const Eigen::Index n = rows * columns;
  made.dense = 0.3 * MatrixXd::Identity(3 * n, 3 * n);
  for (const auto& [a, b] : pairs) {
    Eigen::Matrix3d root;
    for (double& entry : root.reshaped()) entry = any(engine);
    const Eigen::Matrix3d k = root * root.transpose();
    const Eigen::Index i = 3 * Eigen::Index{a}, j = 3 * Eigen::Index{b};
    made.dense.block<3, 3>(i, i) += k;
    made.dense.block<3, 3>(j, j) += k;
    made.dense.block<3, 3>(i, j) -= k;
    made.dense.block<3, 3>(j, i) -= k;
  }
  for (std::size_t a = 0; a < rows * columns; ++a)
    for (std::size_t b = 0; b <= a; ++b)
      if (const std::size_t place = made.sparse.pattern().find(a, b); place != BlockPattern::kNone)
        made.sparse.block(place) = made.dense.block<3, 3>(3 * static_cast<Eigen::Index>(a),
                                                          3 * static_cast<Eigen::Index>(b));
  return made;
}

VectorXd right_side(Eigen::Index size) {
  return VectorXd::LinSpaced(size, -1.0, 2.0).array().sin();
}

TEST(SparseBlocks, MultiplyAsTheDenseMatrixDoes) {
  const Case made = random_grid(5, 7, 1);
  const VectorXd x = right_side(made.dense.rows());
  VectorXd y(x.size());
  made.sparse.multiply(x, y);
  EXPECT_LE((y - made.dense * x).norm(), 1e-13 * y.norm());
}

TEST(SparseBlocks, TheFactorSolvesAsTheDenseOneForEverySizeAndAgain) {
  for (std::size_t columns = 1; columns < 24; ++columns) {
    Case made = random_grid(columns % 7 + 1, columns, static_cast<unsigned>(columns));
    auto factor = BlockCholesky::create(made.sparse.shared_pattern());
    ASSERT_TRUE(factor);
    for (int again = 0; again < 2; ++again) {
      ASSERT_TRUE(factor->factor(made.sparse)) << columns;
      VectorXd x = right_side(made.dense.rows());
      const VectorXd exact = made.dense.llt().solve(x);
      factor->solve(x);
      EXPECT_LE((x - exact).norm(), 1e-11 * exact.norm()) << columns;
    }
  }
}

// How far a quick factor's solution is off, relative.
double error_of(QuickFactor& factor, const Case& made) {
  VectorXd x = right_side(made.dense.rows());
  const VectorXd exact = made.dense.llt().solve(x);
  factor.solve(x);
  return (x - exact).norm() / exact.norm();
}

TEST(SparseBlocks, AQuickFactorHasFloatsWhereTheirDigitsAreEnough) {
  for (std::size_t columns = 1; columns < 24; ++columns) {
    Case made = random_grid(columns % 7 + 1, columns, static_cast<unsigned>(columns));
    auto factor = QuickFactor::create(made.sparse.shared_pattern(), 1 << 20);
    ASSERT_TRUE(factor);
    ASSERT_TRUE(factor->factor(made.sparse)) << columns;
    EXPECT_TRUE(factor->in_floats()) << columns;
    EXPECT_LE(error_of(*factor, made), 1e-4) << columns;
    // Nothing but the springs' own stiffness and a hundred-millionth of it: what a float leaves of
    // the last pivots is rounding.
    const double less = 0.3 - 1e-8;
    for (std::size_t i = 0; i < made.sparse.pattern().size(); ++i)
      made.sparse.diagonal(i) -= less * Eigen::Matrix3d::Identity();
    made.dense.diagonal().array() -= less;
    ASSERT_TRUE(factor->factor(made.sparse)) << columns;
    EXPECT_EQ(factor->in_floats(), made.sparse.pattern().size() == 1) << columns;
    EXPECT_LE(error_of(*factor, made), 1e-5) << columns;
    // What came before leaves nothing behind: a restored run does not know it.
    made = random_grid(columns % 7 + 1, columns, static_cast<unsigned>(columns));
    ASSERT_TRUE(factor->factor(made.sparse)) << columns;
    EXPECT_TRUE(factor->in_floats()) << columns;
  }
}

TEST(SparseBlocks, AQuickFactorRefusesWhatIsFarFromPositiveWithoutDoubles) {
  Case made = random_grid(4, 4, 5);
  made.sparse.diagonal(7) -= 50.0 * Eigen::Matrix3d::Identity();
  auto factor = QuickFactor::create(made.sparse.shared_pattern(), 1 << 20);
  EXPECT_FALSE(factor->factor(made.sparse));
  EXPECT_TRUE(factor->in_floats());
}

// Conjugate gradients from nothing until |b - A x| is at most `wanted`. left: its value then.
struct Solved {
  CgReport report;
  double left = 0.0;
};
Solved by_gradients(const Case& made, double wanted, int most) {
  ConjugateGradients solver(made.sparse.pattern());
  const VectorXd b = right_side(made.dense.rows());
  VectorXd x = VectorXd::Zero(b.size());
  const CgReport report = solver.solve(made.sparse, b, x, wanted, most);
  return {report, (b - made.dense * x).norm()};
}

TEST(SparseBlocks, ConjugateGradientsReachWhatIsAsked) {
  const auto [report, left] = by_gradients(random_grid(9, 8, 3), 1e-10, 2000);
  EXPECT_TRUE(report.converged && report.positive);
  EXPECT_LE(left, 2e-10);
}

// The iterations are in floats, of 7 digits; a refinement in doubles finds the others.
TEST(SparseBlocks, ConjugateGradientsFindTheDigitsThatFloatsDoNotHave) {
  const Case made = random_grid(8, 8, 4);
  ConjugateGradients solver(made.sparse.pattern());
  const VectorXd b = right_side(made.dense.rows());
  for (const double size : {1e-12, 1.0, 1e12}) {
    VectorXd x = VectorXd::Zero(b.size());
    const CgReport report = solver.solve(made.sparse, size * b, x, 1e-12 * size * b.norm(), 5000);
    EXPECT_TRUE(report.converged && report.positive) << size;
    const VectorXd truth = size * made.dense.llt().solve(b);
    // 1e-12 of the right side times a condition of some hundreds.
    EXPECT_LE((x - truth).norm(), 1e-9 * truth.norm()) << size;
  }
}

// The same matrix with its nodes in another order, which has no runs of blocks.
Case shuffled(const Case& made, std::vector<std::size_t> order) {
  const std::size_t n = order.size();
  std::vector<NodePair> pairs;
  for (std::size_t a = 0; a < n; ++a)
    for (std::size_t b = 0; b < a; ++b)
      if (made.sparse.pattern().find(order[a], order[b]) != BlockPattern::kNone)
        pairs.emplace_back(static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b));
  Case other{BlockMatrix(*BlockPattern::create(n, pairs)), made.dense};
  for (std::size_t a = 0; a < n; ++a)
    for (std::size_t b = 0; b < n; ++b) {
      const auto at = [&](std::size_t i, std::size_t j) -> Eigen::Matrix3d {
        return made.dense.block<3, 3>(3 * static_cast<Eigen::Index>(i),
                                      3 * static_cast<Eigen::Index>(j));
      };
      other.dense.block<3, 3>(3 * static_cast<Eigen::Index>(a), 3 * static_cast<Eigen::Index>(b)) =
          at(order[a], order[b]);
      const std::size_t place = other.sparse.pattern().find(a, b);
      if (b <= a && place != BlockPattern::kNone)
        other.sparse.block(place) = at(order[a], order[b]);
    }
  return other;
}

// Blocks off the diagonal that are not symmetric, in a matrix that is.
void skew(Case& made) {
  const std::size_t n = made.dense.rows() / 3;
  const Eigen::Matrix3d turn{{0.0, 0.3, -0.2}, {-0.3, 0.0, 0.1}, {0.2, -0.1, 0.0}};
  made.dense.diagonal().array() += 3.0;
  for (std::size_t a = 0; a < n; ++a) {
    made.sparse.diagonal(a).diagonal().array() += 3.0;
    for (std::size_t b = 0; b < a; ++b) {
      const std::size_t place = made.sparse.pattern().find(a, b);
      if (place == BlockPattern::kNone) continue;
      const auto i = 3 * static_cast<Eigen::Index>(a), j = 3 * static_cast<Eigen::Index>(b);
      made.sparse.block(place) += turn;
      made.dense.block<3, 3>(i, j) += turn;
      made.dense.block<3, 3>(j, i) += turn.transpose();
    }
  }
}

TEST(SparseBlocks, ConjugateGradientsTakeNodesInAnyOrderAndBlocksThatAreNotSymmetric) {
  Case plain = random_grid(9, 37, 6), skewed = plain;
  skew(skewed);
  const std::size_t n = plain.sparse.pattern().size();
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::shuffle(order.begin(), order.end(), std::mt19937(3));
  const VectorXd b = right_side(plain.dense.rows());
  for (const bool mixed : {false, true}) {
    const Case first = mixed ? shuffled(plain, order) : plain;
    const Case second = mixed ? shuffled(skewed, order) : skewed;
    ConjugateGradients solver(first.sparse.pattern());
    // One after the other, as a step's matrices come.
    for (const Case* made : {&first, &second, &first}) {
      VectorXd x = VectorXd::Zero(b.size());
      const CgReport report = solver.solve(made->sparse, b, x, 1e-11 * b.norm(), 5000);
      EXPECT_TRUE(report.converged && report.positive) << mixed;
      EXPECT_LE((made->dense * x - b).norm(), 2e-11 * b.norm()) << mixed;
    }
  }
}

TEST(SparseBlocks, ConjugateGradientsStopWhereAskedForMoreThanRoundingLeaves) {
  const CgReport report = by_gradients(random_grid(4, 4, 2), 1e-30, 1000000).report;
  EXPECT_FALSE(report.converged);
  EXPECT_LT(report.iterations, 10000);
  EXPECT_LE(report.residual, 1e-12);
}

TEST(SparseBlocks, WhatIsNotPositiveDefiniteIsFoundByBoth) {
  Case made = random_grid(4, 4, 5);
  made.sparse.diagonal(7) -= 50.0 * Eigen::Matrix3d::Identity();
  auto factor = BlockCholesky::create(made.sparse.shared_pattern());
  const Status done = factor->factor(made.sparse);
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().kind, ErrorKind::kSolver);
  ConjugateGradients solver(made.sparse.pattern());
  VectorXd x = VectorXd::Zero(48);
  EXPECT_FALSE(solver.solve(made.sparse, right_side(48), x, 1e-10, 2000).positive);
}

TEST(SparseBlocks, HeldNodesGetTheRowsOfTheIdentity) {
  Case made = random_grid(3, 3, 9);
  std::vector<std::uint8_t> held(9, 0);
  held[4] = 1;
  made.sparse.hold(held);
  auto factor = BlockCholesky::create(made.sparse.shared_pattern());
  ASSERT_TRUE(factor->factor(made.sparse));
  VectorXd x = right_side(27);
  const VectorXd b = x;
  factor->solve(x);
  EXPECT_EQ(x.segment<3>(12), b.segment<3>(12));
}

TEST(SparseBlocks, NodesLeftOutAreThoseOfTheIdentityInASmallerFactor) {
  Case made = random_grid(9, 11, 3);
  auto factor = BlockCholesky::create(made.sparse.shared_pattern());
  auto quick = QuickFactor::create(made.sparse.shared_pattern(), 1 << 20);
  const double all = factor->multiplications();
  const std::size_t all_bytes = factor->bytes();
  std::vector<std::uint8_t> out(99, 0);
  // A third of the nodes, others, none, nearly all.
  for (const std::size_t every : {3U, 2U, 1000U, 1U}) {
    for (std::size_t i = 0; i < 99; ++i) out[i] = (i + every) % every == 0 && i != 50 ? 1 : 0;
    if (every == 1000) out.assign(99, 0);
    Case held = random_grid(9, 11, 3);
    held.sparse.hold(out);
    VectorXd b = right_side(297), product(297), rest(297);
    held.sparse.multiply(b, product);
    held.sparse.multiply(out, b, rest);
    EXPECT_EQ(product, rest) << every;
    auto whole = BlockCholesky::create(made.sparse.shared_pattern());
    ASSERT_TRUE(whole->factor(held.sparse));
    VectorXd exact = b, x = b, near = b;
    whole->solve(exact);
    factor->leave_out(out);
    // The matrix without the rows of the identity will do: they are not read.
    ASSERT_TRUE(factor->factor(made.sparse)) << every;
    factor->solve(x);
    EXPECT_LE((x - exact).norm(), 1e-12 * exact.norm()) << every;
    EXPECT_EQ(factor->multiplications() < 0.7 * all, every != 1000) << every;
    EXPECT_LE(factor->bytes(), all_bytes) << every;
    quick->leave_out(out);
    ASSERT_TRUE(quick->factor(made.sparse)) << every;
    quick->solve(near);
    EXPECT_LE((near - exact).norm(), 1e-4 * exact.norm()) << every;
    for (std::size_t i = 0; i < 99; ++i)
      if (out[i] != 0) {
        EXPECT_EQ(x.segment<3>(3 * static_cast<Eigen::Index>(i)),
                  b.segment<3>(3 * static_cast<Eigen::Index>(i)));
      }
  }
}

TEST(SparseBlocks, PatternsThatNameNoNodeAreRefused) {
  EXPECT_FALSE(BlockPattern::create(0, {}));
  const NodePair beyond[] = {{0, 3}};
  EXPECT_FALSE(BlockPattern::create(3, beyond));
}

}  // namespace
}  // namespace tremolo
