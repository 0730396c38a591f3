// The inertia N of the energy-preserving steps
// (runtime/bodies/reduced/integrators/energy_preserving.cpp) and its form with damping. There are
// three kinds: a fixed diagonal matrix, a function N(Z) of Z = (h^2/4) K, and that function with
// damping.
//
// Each kind defines the basis W in which it is simplest, x_hat = W^T x:
//
//     compute(Z)           makes N and a factor of the frozen Jacobian J, about N^2 + Z, which for
//                          Jacobians with damping is N S N/2 + Z + h D/2; Z may be changed. False
//                          where J is not positive definite. With StrainDamping J has its part of
//                          beta (K - Lambda) h/2, that of the tangent
//     to_basis(x)          x <- W^T x
//     from_basis(x)        x <- W x
//     apply(x), solve(x)   in the basis: x <- N x and x <- J^-1 x
//     carry(stream)        saves or restores the results of compute()
//
// Nothing is allocated after construction.
#pragma once

#include <Eigen/Core>

#include "runtime/bodies/reduced/integrators/solve/damping.h"
#include "runtime/integrator.h"
#include "runtime/math/dense/small_matrices.h"
#include "runtime/math/dense/tridiagonal.h"

namespace tremolo {

// The matrix N of the fourth-order energy-preserving step
// (runtime/bodies/reduced/integrators/energy_preserving.cpp), a rational function of a symmetric
// matrix Z, in Z's tridiagonal basis Z = W T W^T.
//
//     N(z) = (1 + a1 z + a2 z^2) / (1 + b1 z + b2 z^2),
//     b1 = a1 + 1/3,  b2 = a2 + b1/3 + 1/45:   N(z) = sqrt(z) cot(sqrt(z)) + O(z^3)
//
// Both N and 1/(N^2 + z), which the step's Newton matrix is, are sums of simple fractions n + sum_k
// c_k/(z - z_k). A vector costs one tridiagonal solve for each pole, in complex numbers where the
// pole is complex (one of a conjugate pair, its real part twice).

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

FilterFractions filter_fractions(const FilterShape& shape);

class RationalFilter {
 public:
  RationalFilter(Eigen::Index size, const FilterShape& shape);

  // z: r x r, symmetric; its lower triangle is read. Poles among the eigenvalues: see
  // PartialFractions. This and the following functions allocate nothing.
  void compute(const Eigen::MatrixXd& z);

  void to_basis(Eigen::VectorXd& x) const { tridiagonal_.to_basis(x); }      // x <- W^T x
  void from_basis(Eigen::VectorXd& x) const { tridiagonal_.from_basis(x); }  // x <- W x

  // In the basis: x <- N x and x <- (N^2 + T)^-1 x.
  void apply(Eigen::VectorXd& x);
  void solve(Eigen::VectorXd& x);

  // Saves or restores the results of compute().
  void carry(StateStream& stream) { stream(tridiagonal_, resolvents_); }

 private:
  RationalFilter(Eigen::Index size, const FilterFractions& fractions);

  Tridiagonal tridiagonal_;
  FilterFractions fractions_;
  PartialFractions resolvents_;
};

// N at rest for one coordinate, x = h omega/2: for ep2, and for ep4. avf has unit_weight.
double cotangent_weight(double x);
double rational_weight(double x);

// Fraction of theta and of the damped n (damping.h) for a coordinate of the frequency omega (1/s)
// under the stiffness damping beta (s), steps of h: all of it where beta omega, twice the damping
// ratio, is below 1/4, none from 1/2 on; beyond h omega = 1 these are limits of h beta omega^2.
//
// theta takes h theta D Dp^2 also of a coordinate that follows others. There the strains, and with
// them the true damping, may not change at all, and n changes its inertia. A free mode with so much
// damping decays in a few steps or within a period with any roots.
double stiff_share(double beta, double h, double omega);

// Coefficients of the damped step, for each coordinate; r each.
struct InertiaDamping {
  Eigen::VectorXd D;      // 1/s
  Eigen::VectorXd theta;  // of runtime/bodies/reduced/integrators/solve/damping.h
  Eigen::VectorXd n;      // N at rest, damped
  Eigen::VectorXd shift;  // n less N at rest
  Eigen::VectorXd g;      // 1 + 2 theta h D = 2/S
  Eigen::VectorXd slope;  // n^2/g + h D/2: J at rest, without Z
  Eigen::VectorXd z;      // Z at rest, its diagonal
  // Added to J for each unit of Z less its value at rest: StrainDamping's 2 beta/h; 0 where the
  // model is linear.
  double strain = 0.0;
  bool present = false;  // some D is not zero
};

// stiff: n where stiff_share() is 0. A coordinate follows others there, with its whole inertia:
// that is 1 for a diagonal N, and N itself (at_rest) where N is a function of Z at the midpoint,
// which leaves the inertia of slow motion whole.
InertiaDamping make_inertia_damping(const Model& model, const IntegratorOptions& options,
                                    InertiaWeight at_rest, InertiaWeight stiff);

// J of ep4 with damping, to first order in Z less its value at rest, diag(z): factors times Z,
// entry by entry, plus the diagonal `slope`. The factors are derivatives of N S N/2 (filter_slope).
struct DampedJacobian {
  bool strong = false;  // damping changes J by more than a correction can leave to the next
  Eigen::VectorXd slope;
  Eigen::MatrixXd factors;  // r x r, symmetric
};

DampedJacobian make_damped_jacobian(const InertiaDamping& damping);

// N diagonal and fixed; J, damping included, by Cholesky. W is the identity.
class DiagonalFilter {
 public:
  static constexpr bool kFollowsTheState = false;

  explicit DiagonalFilter(const InertiaDamping& damping)
      : n_(damping.n),
        slope_(damping.slope - damping.strain * damping.z),
        strain_(damping.strain),
        factor_(n_.size()) {}

  bool compute(Eigen::MatrixXd& Z) {
    if (strain_ > 0.0) Z *= 1.0 + strain_;
    Z.diagonal() += slope_;
    return factor_.compute(Z);
  }
  void to_basis(Eigen::VectorXd&) const {}
  void from_basis(Eigen::VectorXd&) const {}
  void apply(Eigen::VectorXd& x) const { x = n_.cwiseProduct(x); }
  void solve(Eigen::VectorXd& x) const { factor_.solve(x); }
  void carry(StateStream& stream) { stream(factor_); }

 private:
  Eigen::VectorXd n_;
  Eigen::VectorXd slope_;
  double strain_;
  SmallCholesky factor_;
};

// N = N(Z) without damping. W is the basis in which Z is tridiagonal.
class MatrixFilter : public RationalFilter {
 public:
  static constexpr bool kFollowsTheState = true;

  explicit MatrixFilter(Eigen::Index size) : RationalFilter(size, kRobustShape) {}
  bool compute(Eigen::MatrixXd& Z) {
    RationalFilter::compute(Z);
    return true;
  }
};

// N = N(Z) plus the shift of each damped coordinate. W is the identity. Where damping changes J
// little, J is that without damping; else it is a DampedJacobian.
class DampedMatrixFilter {
 public:
  static constexpr bool kFollowsTheState = true;

  explicit DampedMatrixFilter(const InertiaDamping& damping);

  bool compute(Eigen::MatrixXd& Z) {
    filter_.compute(Z);
    if (!jacobian_.strong) return true;
    Z.array() *= jacobian_.factors.array();
    Z.diagonal() += jacobian_.slope;
    return factor_.compute(Z);
  }
  void to_basis(Eigen::VectorXd&) const {}
  void from_basis(Eigen::VectorXd&) const {}
  void apply(Eigen::VectorXd& x) {
    shifted_ = shift_.cwiseProduct(x);
    filter_.to_basis(x);
    filter_.apply(x);
    filter_.from_basis(x);
    x += shifted_;
  }
  void solve(Eigen::VectorXd& x) {
    if (jacobian_.strong) return factor_.solve(x);
    filter_.to_basis(x);
    filter_.solve(x);
    filter_.from_basis(x);
  }
  void carry(StateStream& stream) { stream(filter_, factor_); }

 private:
  Eigen::VectorXd shift_;
  Eigen::VectorXd shifted_;
  DampedJacobian jacobian_;
  RationalFilter filter_;
  SmallCholesky factor_;
};

}  // namespace tremolo
