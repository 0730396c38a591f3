// Symmetric matrix -> tridiagonal by Householder reflections: A = W T W^T, W orthogonal. Functions
// of A then cost O(r) a vector: f(A) x = W f(T) W^T x. No member function allocates.
#pragma once

#include <complex>
#include <vector>

#include <Eigen/Core>

#include "common/state_stream.h"
#include "runtime/math/kernels/lanes.h"

namespace tremolo {

class Tridiagonal {
 public:
  explicit Tridiagonal(Eigen::Index size);  // r

  // a: r x r, symmetric; its lower triangle is read. Columns whose entries beyond the first
  // subdiagonal are all below some 1e-140 count as tridiagonal already.
  void compute(const Eigen::MatrixXd& a);

  void to_basis(Eigen::VectorXd& x) const;    // x <- W^T x
  void from_basis(Eigen::VectorXd& x) const;  // x <- W x

  const Eigen::VectorXd& diagonal() const { return diagonal_; }  // r
  const Eigen::VectorXd& off() const { return off_; }            // r - 1: T_{i,i+1}

  // Saves or restores the results of compute().
  void carry(StateStream& stream) { stream(diagonal_, off_, basis_); }

 private:
  std::size_t r_;
  std::size_t stride_;
  Eigen::VectorXd diagonal_;
  Eigen::VectorXd off_;
  AlignedDoubles a_;      // A, then its remaining part
  AlignedDoubles u_;      // column k: u_k of the reflection I - f_k u_k u_k^T, below row k
  AlignedDoubles f_;      // f_k = 2/|u_k|^2, or 0 without a reflection
  AlignedDoubles basis_;  // W^T, column by column
  AlignedDoubles image_;
  mutable AlignedDoubles vector_;
};

// Complex numbers side by side.
struct alignas(kCacheLine) ComplexLanes {
  static constexpr std::size_t kCount = 8;  // whole vectors
  double re[kCount] = {};
  double im[kCount] = {};
  void set(std::size_t lane, std::complex<double> value) {
    re[lane] = value.real();
    im[lane] = value.imag();
  }
};

inline void carry(StateStream& stream, ComplexLanes& lanes) {
  for (std::size_t lane = 0; lane < ComplexLanes::kCount; ++lane)
    stream(lanes.re[lane], lanes.im[lane]);
}

// sum_k c_k (T - z_k)^-1 x for eight poles z_k side by side in the lanes of one vector: a solve for
// all of them takes as long as one.
class PartialFractions {
 public:
  PartialFractions(Eigen::Index size, const ComplexLanes& poles);

  // Factorises T - z_k without pivoting. A pole should have an imaginary part or lie below the
  // spectrum; a real pole among the eigenvalues may cost accuracy, and at an eigenvalue the result
  // is not finite.
  void compute(const Tridiagonal& t);

  // x <- limit x + sum_k Re[c_k (T - z_k)^-1 x] with the residues c.
  void apply(const ComplexLanes& residues, double limit, Eigen::VectorXd& x);

  // Saves or restores the results of compute().
  void carry(StateStream& stream) { stream(inverse_, ratio_); }

 private:
  ComplexLanes poles_;
  // T - z_k = L D L^T: 1/D, the entries of L next to the diagonal, and scratch; r each.
  std::vector<ComplexLanes> inverse_, ratio_, scratch_;
};

}  // namespace tremolo
