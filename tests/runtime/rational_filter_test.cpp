// The matrix functions that ep4 is made of, against their dense definitions.
#include <cmath>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "runtime/bodies/reduced/integrators/solve/inertia_filter.h"
#include "tests/support/sample_basis.h"

namespace tremolo {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Symmetric, eigenvalues spread geometrically over (lowest, highest].
MatrixXd random_matrix(Eigen::Index r, double lowest, double highest, unsigned seed) {
  const MatrixXd random = testing::random_vector(r * r, 1.0, seed).reshaped(r, r);
  const Eigen::HouseholderQR<MatrixXd> qr(random);
  const MatrixXd q = qr.householderQ();
  return q * testing::spread_omega(r, lowest, highest).asDiagonal() * q.transpose();
}

MatrixXd dense_filter(const MatrixXd& z) {
  const MatrixXd one = MatrixXd::Identity(z.rows(), z.cols());
  const double b1 = kRobustShape.a1 + 1.0 / 3.0;
  const double b2 = kRobustShape.a2 + b1 / 3.0 + 1.0 / 45.0;
  return (one + b1 * z + b2 * z * z).inverse() *
         (one + kRobustShape.a1 * z + kRobustShape.a2 * z * z);
}

TEST(Tridiagonal, ReflectionsTurnTheMatrixIntoTheTridiagonalOne) {
  for (const Eigen::Index r : {1, 2, 3, 5, 15, 30}) {
    const MatrixXd a = random_matrix(r, 1e-4, 10.0, 3);
    Tridiagonal tridiagonal(r);
    MatrixXd copy = a;
    tridiagonal.compute(copy);
    MatrixXd t = tridiagonal.diagonal().asDiagonal();
    for (Eigen::Index i = 0; i + 1 < r; ++i) t(i, i + 1) = t(i + 1, i) = tridiagonal.off()[i];
    for (Eigen::Index j = 0; j < r; ++j) {
      VectorXd x = VectorXd::Unit(r, j);
      tridiagonal.to_basis(x);
      VectorXd image = t * x;
      tridiagonal.from_basis(image);
      EXPECT_LE((image - a.col(j)).norm(), 1e-13 * a.norm()) << r << ", column " << j;  // rounding
      tridiagonal.from_basis(x);
      EXPECT_LE((x - VectorXd::Unit(r, j)).norm(), 1e-14 * static_cast<double>(r)) << r;
    }
  }
}

TEST(Tridiagonal, MatrixThatOverflowsLeavesNoTraceInTheNext) {
  for (const Eigen::Index r : {3, 9, 24}) {
    Eigen::MatrixXd a = testing::random_vector(r * r, 1.0, 8).reshaped(r, r);
    a = (a + a.transpose()).eval();
    Tridiagonal fresh(r), used(r);
    used.compute(Eigen::MatrixXd::Constant(r, r, 1e300));
    used.compute(Eigen::MatrixXd::Constant(r, r, std::nan("")));
    fresh.compute(a);
    used.compute(a);
    EXPECT_EQ(fresh.diagonal(), used.diagonal()) << r;
    EXPECT_EQ(fresh.off(), used.off()) << r;
    Eigen::VectorXd x = testing::random_vector(r, 1.0, 9), y = x;
    fresh.to_basis(x);
    used.to_basis(y);
    EXPECT_EQ(x, y) << r;
  }
}

TEST(Tridiagonal, DiagonalMatrixIsLeftAlone) {
  const VectorXd values = testing::random_vector(6, 1.0, 2);
  Tridiagonal tridiagonal(6);
  MatrixXd a = values.asDiagonal();
  tridiagonal.compute(a);
  EXPECT_EQ(tridiagonal.diagonal(), values);
  EXPECT_TRUE(tridiagonal.off().isZero(0.0));
}

TEST(Tridiagonal, BasisStaysOrthogonalWhereSquaresUnderflow) {
  for (int exponent = 100; exponent < 325; ++exponent) {
    MatrixXd a = std::pow(10.0, -exponent) * random_matrix(6, 0.1, 10.0, 3);
    a.diagonal() = testing::random_vector(6, 1.0, 2);
    Tridiagonal tridiagonal(6);
    tridiagonal.compute(a);
    VectorXd x = testing::random_vector(6, 1.0, 4);
    tridiagonal.to_basis(x);
    tridiagonal.from_basis(x);
    EXPECT_LE((x - testing::random_vector(6, 1.0, 4)).norm(), 1e-14) << "1e-" << exponent;
  }
}

TEST(RationalFilter, AppliesAndSolvesLikeTheDenseMatrices) {
  for (const Eigen::Index r : {1, 2, 15, 30})
    // h omega/2 up to 0.3, 4 and 300.
    for (const double highest : {0.1, 16.0, 1e5}) {
      const MatrixXd z = random_matrix(r, 1e-3, highest, 9);
      RationalFilter filter(r, kRobustShape);
      MatrixXd copy = z;
      filter.compute(copy);
      const MatrixXd n = dense_filter(z);
      const VectorXd x = testing::random_vector(r, 1.0, 4);
      VectorXd image = x;
      filter.to_basis(image);
      filter.apply(image);
      filter.from_basis(image);
      // The dense form squares Z: its own rounding grows like its condition number.
      const double rounding = 1e-14 * (1.0 + highest * highest);
      EXPECT_LE((image - n * x).norm(), rounding * x.norm()) << r << ", " << highest;
      VectorXd solved = x;
      filter.to_basis(solved);
      filter.solve(solved);
      filter.from_basis(solved);
      EXPECT_LE(((n * n + z) * solved - x).norm(), rounding * (1.0 + highest) * x.norm())
          << r << ", " << highest;
    }
}

TEST(RationalFilter, AgreesWithTheCotangentThroughSecondOrder) {
  // x cot x = 1 - z/3 - z^2/45 - 2 z^3/945 ..., z = x^2: the difference falls eightfold.
  const auto difference = [](double z) {
    return filter_value(kRobustShape, z) - std::sqrt(z) / std::tan(std::sqrt(z));
  };
  EXPECT_NEAR(difference(0.02) / difference(0.01), 8.0, 0.1);
}

TEST(RationalFilter, NeverComesNearZero) {
  double lowest = 1.0;
  for (double z = 0.0; z < 1e4; z += 0.01) lowest = std::min(lowest, filter_value(kRobustShape, z));
  EXPECT_NEAR(lowest, 0.5082, 1e-4);
  EXPECT_NEAR(filter_value(kRobustShape, 1e12), 0.5581, 1e-4);
  // Nor where the tangent is indefinite.
  double least = 1.0, most = 1.0;
  for (double z = 0.0; z > -1e4; z -= 0.01) {
    least = std::min(least, filter_value(kRobustShape, z));
    most = std::max(most, filter_value(kRobustShape, z));
  }
  EXPECT_GE(least, 0.5581);
  EXPECT_NEAR(most, 1.2078, 1e-4);
}

}  // namespace
}  // namespace tremolo
