// Singular values and vectors by what defines them: A = U diag(values) V^T with orthonormal
// columns.
#include <algorithm>
#include <random>
#include <utility>

#include <gtest/gtest.h>

#include "precompute/dense/dense_decompositions.h"

namespace tremolo {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

// Its last column is the sum of the others: one singular value is zero.
MatrixXd deficient(Index rows, Index columns) {
  MatrixXd a(rows, columns);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> number(-1.0, 1.0);
  for (double& entry : a.reshaped()) entry = number(random);
  a.rightCols(1) = a.leftCols(columns - 1).rowwise().sum();
  return a;
}

class SingularPairsOf : public ::testing::TestWithParam<std::pair<Index, Index>> {};

INSTANTIATE_TEST_SUITE_P(Shapes, SingularPairsOf,
                         ::testing::Values(std::pair{9, 4}, std::pair{4, 9}, std::pair{6, 6},
                                           std::pair{650, 3}, std::pair{3, 650}));

TEST_P(SingularPairsOf, AMatrixMakeItDiagonal) {
  const MatrixXd a = deficient(GetParam().first, GetParam().second);
  const SingularPairs left = singular_pairs(a, SingularVectors::kLeft);
  const SingularPairs right = singular_pairs(a, SingularVectors::kRight);
  const SingularPairs bare = singular_pairs(a, SingularVectors::kNone);
  const Index n = std::min(a.rows(), a.cols());
  ASSERT_EQ(left.values.size(), n);
  ASSERT_EQ(left.vectors.rows(), a.rows());
  ASSERT_EQ(right.vectors.rows(), a.cols());
  ASSERT_EQ(left.vectors.cols(), n);
  ASSERT_EQ(right.vectors.cols(), n);
  EXPECT_EQ(bare.vectors.size(), 0);
  const double size = a.norm(), rounding = 1e-13 * size;
  for (Index i = 1; i < n; ++i) EXPECT_LE(left.values[i], left.values[i - 1]);
  EXPECT_LE((left.values - right.values).cwiseAbs().maxCoeff(), rounding);
  EXPECT_LE((left.values - bare.values).cwiseAbs().maxCoeff(), rounding);
  EXPECT_NEAR(left.values.norm(), size, rounding);
  const MatrixXd one = MatrixXd::Identity(n, n);
  EXPECT_LE((left.vectors.transpose() * left.vectors - one).norm(), 1e-13);
  EXPECT_LE((right.vectors.transpose() * right.vectors - one).norm(), 1e-13);
  MatrixXd rest = left.vectors.transpose() * a * right.vectors;
  // Signs of the two are their own.
  rest = rest.cwiseAbs();
  rest.diagonal() -= left.values;
  EXPECT_LE(rest.norm(), 10.0 * rounding);
}

TEST(SingularPairs, OfNothingAreNone) {
  for (const auto& [rows, columns] : {std::pair{3, 0}, std::pair{0, 3}, std::pair{0, 0}}) {
    const SingularPairs left = singular_pairs(MatrixXd(rows, columns), SingularVectors::kLeft);
    EXPECT_EQ(left.values.size(), 0);
    EXPECT_EQ(left.vectors.rows(), rows);
    EXPECT_EQ(left.vectors.cols(), 0);
    EXPECT_EQ(singular_pairs(MatrixXd(rows, columns), SingularVectors::kNone).values.size(), 0);
  }
}

}  // namespace
}  // namespace tremolo
