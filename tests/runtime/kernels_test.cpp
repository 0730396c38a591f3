// The fast kernels against each other and against plain linear algebra.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "common/packed_index.h"
#include "runtime/math/dense/dense_lu.h"
#include "runtime/math/dense/small_matrices.h"
#include "runtime/math/kernels/pair_kernel.h"
#include "runtime/math/kernels/symmetric_kernel.h"
#include "tests/support/sample_basis.h"

namespace tremolo {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using testing::random_vector;

struct Coefficients {
  explicit Coefficients(int r)
      : cubic(random_vector(static_cast<Eigen::Index>(triple_count(static_cast<std::size_t>(r))),
                            1.0, 1)),
        quartic(random_vector(static_cast<Eigen::Index>(quad_count(static_cast<std::size_t>(r))),
                              1.0, 2)) {}

  SymmetricKernel unique(std::size_t r) const {
    return SymmetricKernel(r, {cubic.data(), static_cast<std::size_t>(cubic.size())},
                           {quartic.data(), static_cast<std::size_t>(quartic.size())});
  }
  PairKernel pairs(std::size_t r) const {
    return PairKernel(r, {cubic.data(), static_cast<std::size_t>(cubic.size())},
                      {quartic.data(), static_cast<std::size_t>(quartic.size())});
  }

  VectorXd cubic;
  VectorXd quartic;
};

class KernelSize : public ::testing::TestWithParam<int> {};
// Every remainder modulo four and eight, and beyond what is kept in registers.
INSTANTIATE_TEST_SUITE_P(Sizes, KernelSize,
                         ::testing::Values(1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 15, 16, 17, 22, 23, 24,
                                           25, 30, 31, 32, 33, 41));

TEST_P(KernelSize, ValueGradientAndHessianOfTheUniqueKernelBelongTogether) {
  const int n = GetParam();
  const std::size_t r = n;
  const SymmetricKernel kernel = Coefficients(n).unique(r);
  SymmetricKernel::Workspace workspace = kernel.make_workspace();
  const VectorXd q = random_vector(n, 1.0, 3);
  VectorXd gradient(n), again(n), moved(n);
  MatrixXd hessian(n, n);
  const double value = kernel.gradient(q.data(), workspace, gradient.data());
  EXPECT_NEAR(kernel.hessian(q.data(), workspace, again.data(), hessian.data()), value,
              1e-12 * (1.0 + gradient.norm() * q.norm()));
  EXPECT_LE((gradient - again).norm(), 1e-13 * gradient.norm());
  // For a quartic polynomial the central difference is exact except for h^2/6 times its third
  // derivative along the direction; two of them together are exact.
  const VectorXd direction = random_vector(n, 1.0, 4);
  const auto along = [&](double s) {
    const VectorXd at = q + s * direction;
    return kernel.gradient(at.data(), workspace, moved.data());
  };
  const auto gradient_along = [&](double s) {
    along(s);
    return VectorXd(moved);
  };
  const double slope = (8.0 * (along(0.5) - along(-0.5)) - (along(1.0) - along(-1.0))) / 6.0;
  EXPECT_NEAR(slope, gradient.dot(direction), 1e-11 * (1.0 + gradient.norm() * direction.norm()));
  const VectorXd bend = (8.0 * (gradient_along(0.5) - gradient_along(-0.5)) -
                         (gradient_along(1.0) - gradient_along(-1.0))) /
                        6.0;
  EXPECT_LE((bend - hessian * direction).norm(), 1e-12 * (1.0 + hessian.norm() * direction.norm()));
  EXPECT_EQ(hessian, hessian.transpose());
}

TEST_P(KernelSize, TwoPointsAtOnceAreTwoPoints) {
  const int n = GetParam();
  const SymmetricKernel kernel = Coefficients(n).unique(static_cast<std::size_t>(n));
  SymmetricKernel::Workspace first = kernel.make_workspace(), second = kernel.make_workspace();
  const VectorXd q0 = random_vector(n, 1.0, 5), q1 = random_vector(n, 1.0, 6);
  VectorXd g0(n), g1(n), alone(n);
  kernel.gradient_pair(q0.data(), q1.data(), first, second, g0.data(), g1.data());
  kernel.gradient(q0.data(), first, alone.data());
  EXPECT_LE((g0 - alone).norm(), 1e-14 * alone.norm());
  kernel.gradient(q1.data(), first, alone.data());
  EXPECT_LE((g1 - alone).norm(), 1e-14 * alone.norm());
}

TEST_P(KernelSize, ANumberThatIsNotFiniteLeavesNoTrace) {
  const int n = GetParam();
  const SymmetricKernel kernel = Coefficients(n).unique(static_cast<std::size_t>(n));
  SymmetricKernel::Workspace used = kernel.make_workspace(), fresh = kernel.make_workspace();
  const VectorXd q = random_vector(n, 1.0, 7);
  VectorXd a(n), b(n);
  MatrixXd ka(n, n), kb(n, n);
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity(), 1e200}) {
    const VectorXd broken = VectorXd::Constant(n, bad);
    kernel.hessian(broken.data(), used, a.data(), ka.data());
    kernel.gradient(broken.data(), used, a.data());
    kernel.hessian(q.data(), used, a.data(), ka.data());
    kernel.hessian(q.data(), fresh, b.data(), kb.data());
    EXPECT_EQ(a, b) << bad;
    EXPECT_EQ(ka, kb) << bad;
  }
}

TEST_P(KernelSize, PairKernelGivesTheGradientOfTheUniqueOne) {
  const int n = GetParam();
  const std::size_t r = n;
  const Coefficients coefficients(n);
  const SymmetricKernel unique = coefficients.unique(r);
  const PairKernel pairs = coefficients.pairs(r);
  SymmetricKernel::Workspace workspace = unique.make_workspace();
  const VectorXd q = random_vector(n, 1.0, 8);
  VectorXd gradient(n);
  unique.gradient(q.data(), workspace, gradient.data());
  AlignedDoubles x(pairs.padded_pairs()), a(x.size(), 0.0), b(x.size(), 0.0);
  pairs.fill_pairs(q.data(), x.data());
  pairs.multiply(x.data(), 0, a.data());
  pairs.contract_cubic(q.data(), 0, r, 0, b.data());
  VectorXd product = VectorXd::Zero(n);
  for (std::size_t j = 0; j < r; ++j)
    for (std::size_t i = 0; i < r; ++i)
      product[j] += (3.0 * b[pair_index_any(i, j)] + 4.0 * a[pair_index_any(i, j)]) * q[i];
  EXPECT_LE((product - gradient).norm(), 1e-13 * gradient.norm());
}

// The shortest of three, s.
double seconds_to_factor(SmallCholesky& cholesky, const MatrixXd& a) {
  double best = 1e9;
  for (int k = 0; k < 3; ++k) {
    const auto before = std::chrono::steady_clock::now();
    EXPECT_TRUE(cholesky.compute(a));
    const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - before;
    best = std::min(best, spent.count());
  }
  return best;
}

TEST(SmallCholesky, ADiagonalMatrixCostsNoProducts) {
  constexpr Eigen::Index kSize = 800;
  SmallCholesky cholesky(kSize);
  const VectorXd d = random_vector(kSize, 1.0, 3).cwiseAbs() + VectorXd::Constant(kSize, 0.1);
  MatrixXd a = d.asDiagonal();
  const double diagonal = seconds_to_factor(cholesky, a);
  const VectorXd b = random_vector(kSize, 1.0, 10);
  VectorXd x = b;
  cholesky.solve(x);
  EXPECT_LE((d.cwiseProduct(x) - b).cwiseAbs().maxCoeff(), 1e-15);  // two roundings
  // The last entry that can be set: it is seen, and makes the whole product necessary.
  a(kSize - 1, kSize - 2) = 0.01;
  EXPECT_LT(diagonal, 0.3 * seconds_to_factor(cholesky, a));  // a twentieth
  x = b;
  cholesky.solve(x);
  a(kSize - 2, kSize - 1) = 0.01;
  EXPECT_LE((a * x - b).norm(), 1e-13);
  a.setZero();
  a.diagonal() = d;
  for (const double bad : {0.0, -1.0, std::nan(""), HUGE_VAL}) {
    a(7, 7) = bad;
    EXPECT_FALSE(cholesky.compute(a)) << bad;
  }
}

TEST(SmallCholesky, SolvesAndRefuses) {
  for (const Eigen::Index n : {1, 2, 7, 8, 9, 15, 16, 17, 30, 33, 70}) {
    const MatrixXd random = random_vector(n * n, 1.0, 9).reshaped(n, n);
    MatrixXd a = random * random.transpose() + 0.1 * MatrixXd::Identity(n, n);
    const VectorXd b = random_vector(n, 1.0, 10);
    SmallCholesky cholesky(n);
    ASSERT_TRUE(cholesky.compute(a)) << n;
    VectorXd x = b;
    cholesky.solve(x);
    // Backward stable: a residual of rounding, whatever the condition.
    EXPECT_LE((a * x - b).norm(), 1e-14 * static_cast<double>(n) * (a.norm() * x.norm() + b.norm()))
        << n;
    a(n - 1, n - 1) -= 2.0 * a.norm();
    EXPECT_FALSE(cholesky.compute(a)) << n;
    a(n / 2, n / 2) = std::nan("");
    EXPECT_FALSE(cholesky.compute(a)) << n;
    // And takes the next matrix as if nothing had been.
    ASSERT_TRUE(cholesky.compute(MatrixXd::Identity(n, n))) << n;
    x = b;
    cholesky.solve(x);
    EXPECT_EQ(x, b) << n;
  }
}

class DenseSize : public ::testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Sizes, DenseSize,
                         ::testing::Values(1, 2, 5, 7, 8, 9, 15, 16, 17, 23, 36, 64, 65, 96, 129));

// Rows of very different sizes and a zero diagonal, so that most columns need another pivot.
MatrixXd uneven_matrix(int n) {
  MatrixXd a(n, n);
  for (int j = 0; j < n; ++j) a.col(j) = random_vector(n, 1.0, 100 + j);
  for (int i = 0; i < n; ++i) a.row(i) *= std::pow(10.0, i % 7 - 3);
  if (n > 1) a.diagonal().setZero();
  return a;
}

// The error of x as a solution of a x = b, relative to what rounding leaves of it.
double backward_error(const MatrixXd& a, const VectorXd& x, const VectorXd& b) {
  const VectorXd scale = a.cwiseAbs() * x.cwiseAbs() + b.cwiseAbs();
  return (a * x - b).cwiseAbs().cwiseQuotient(scale).maxCoeff();
}

TEST_P(DenseSize, FactorSolvesWithEveryPivotAndHasTheSignOfTheDeterminant) {
  const int n = GetParam();
  const MatrixXd a = uneven_matrix(n);
  const DenseLu factor(a);
  const Eigen::PartialPivLU<MatrixXd> known(a);
  const VectorXd b = random_vector(n, 1.0, 5);
  EXPECT_LE(backward_error(a, factor.solve(b), b), 1e-14 * n);
  EXPECT_LE(backward_error(a.transpose(), factor.solve_transposed(b), b), 1e-13 * n);
  MatrixXd many(n, 5);
  for (int j = 0; j < 5; ++j) many.col(j) = random_vector(n, 1.0, 10 + j);
  MatrixXd solved = many;
  factor.solve_in_place(solved);
  for (int j = 0; j < 5; ++j) EXPECT_LE(backward_error(a, solved.col(j), many.col(j)), 1e-14 * n);
  const VectorXd diagonal = known.matrixLU().diagonal();
  const auto negative = (diagonal.array() < 0.0).count();
  const int sign = static_cast<int>(known.permutationP().determinant()) * (negative % 2 ? -1 : 1);
  EXPECT_EQ(factor.sign(), sign);
}

TEST_P(DenseSize, ProductsOfPaddedMatricesAreThoseOfEigen) {
  const int n = GetParam(), columns = 2 * n + 1, depth = n / 2 + 1;
  const auto filled = [](int rows, int count, unsigned seed) {
    PaddedMatrix result(rows, count);
    for (int j = 0; j < count; ++j) result.matrix().col(j) = random_vector(rows, 1.0, seed + j);
    return result;
  };
  const PaddedMatrix a = filled(n, depth, 1), b = filled(depth, columns, 500);
  PaddedMatrix c = filled(n, columns, 900);
  const MatrixXd expected = MatrixXd(c.matrix()) - a.matrix() * b.matrix();
  c.subtract_product(a, b);
  EXPECT_LE((c.matrix() - expected).cwiseAbs().maxCoeff(), 1e-15 * (depth + 4));
}

TEST(DenseLu, TakesMatricesOfSeveralSizesInTurn) {
  DenseLu factor;
  for (const int n : {20, 3, 33, 8}) {
    const MatrixXd a = uneven_matrix(n);
    const VectorXd b = random_vector(n, 1.0, 7);
    factor.compute(a);
    EXPECT_LE(backward_error(a, factor.solve(b), b), 1e-14 * n) << n;
  }
}

}  // namespace
}  // namespace tremolo
