// The matrix N of the fourth-order energy-preserving step
// (runtime/integrators/energy_preserving.cpp), a rational function of a symmetric matrix Z, in Z's
// tridiagonal basis Z = W T W^T.
//
//     N(z) = (1 + a1 z + a2 z^2) / (1 + b1 z + b2 z^2),
//     b1 = a1 + 1/3,  b2 = a2 + b1/3 + 1/45:   N(z) = sqrt(z) cot(sqrt(z)) + O(z^3)
//
// Both N and 1/(N^2 + z), which the step's Newton matrix is, are sums of simple fractions n + sum_k
// c_k/(z - z_k). A vector costs one tridiagonal solve for each pole, in complex numbers where the
// pole is complex (one of a conjugate pair, its real part twice).
#pragma once

#include <Eigen/Core>

#include "runtime/kernels/tridiagonal.h"

namespace tremolo {

// The two free coefficients.
struct FilterShape {
  double a1 = 0.0;
  double a2 = 0.0;
};

// For z >= 0 N falls from 1 to 0.5581 at infinity, with the lowest value 0.5082. It is never small,
// so that the solve is well posed far beyond h omega = 2. For z < 0 it lies between 0.558 and
// 1.208. N^2 + z is positive above its one real zero, z = -1.403: below it solve() is that of an
// indefinite matrix.
inline constexpr FilterShape kRobustShape{-0.00368349, 0.166819};

double filter_value(const FilterShape& shape, double z);

// (N(z) - N(y))/(z - y), N'(z) for y = z. For Z near a diagonal matrix diag(z_i) it is the
// derivative of N(Z): N(Z)_ij = N(z_i) delta_ij + filter_slope(z_i, z_j) (Z - diag(z))_ij + ...
double filter_slope(const FilterShape& shape, double z, double y);

// Poles of N and of 1/(N^2 + z), with residues: twice them where the conjugate pole is left out,
// zero for the poles of the other function.
struct FilterFractions {
  double limit = 0.0;  // N at infinity
  ComplexLanes poles;
  ComplexLanes of_filter;
  ComplexLanes of_inverse;
};

class RationalFilter {
 public:
  RationalFilter(Eigen::Index size, const FilterShape& shape);

  // z: r x r, symmetric; its lower triangle is read. Poles among the eigenvalues: see
  // PartialFractions. This and the following functions allocate nothing.
  void compute(const Eigen::MatrixXd& z);

  void to_basis(Eigen::VectorXd& x) const { tridiagonal_.to_basis(x); }      // x <- W^T x
  void from_basis(Eigen::VectorXd& x) const { tridiagonal_.from_basis(x); }  // x <- W x

  // In the basis: x <- N x, x <- (N^2 + T)^-1 x and x <- T x.
  void apply(Eigen::VectorXd& x);
  void solve(Eigen::VectorXd& x);
  void multiply(Eigen::VectorXd& x) const;

  // Saves or restores the results of compute().
  void carry(StateStream& stream) { stream(tridiagonal_, resolvents_); }

 private:
  RationalFilter(Eigen::Index size, const FilterFractions& fractions);

  Tridiagonal tridiagonal_;
  FilterFractions fractions_;
  PartialFractions resolvents_;
};

}  // namespace tremolo
