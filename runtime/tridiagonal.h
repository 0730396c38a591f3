// Symmetric matrix -> tridiagonal by Householder reflections: A = W T W^T, W orthogonal. Functions
// of A then cost O(r) a vector: f(A) x = W f(T) W^T x.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

namespace tremolo {

// diagonal: r. off: r - 1 entries, T_{i,i+1}. reflections: r x r, column k holds the vector u_k of
// the reflection I - u_k u_k^T below its row k (so |u_k|^2 = 2, or 0 where there is nothing to
// reflect). All are sized by the constructor; nothing is allocated later.
class Tridiagonal {
 public:
  explicit Tridiagonal(Eigen::Index size);

  // a: r x r, symmetric, both triangles filled; destroyed. Columns whose entries beyond the first
  // subdiagonal are all below 1e-140 count as tridiagonal already.
  void compute(Eigen::MatrixXd& a);

  void to_basis(Eigen::VectorXd& x) const;    // x <- W^T x
  void from_basis(Eigen::VectorXd& x) const;  // x <- W x

  const Eigen::VectorXd& diagonal() const { return diagonal_; }
  const Eigen::VectorXd& off() const { return off_; }

 private:
  Eigen::VectorXd diagonal_;
  Eigen::VectorXd off_;
  Eigen::MatrixXd reflections_;
  Eigen::VectorXd image_;
};

// std::complex spends most of its time on not-a-number; this one does not look for it.
struct Complex {
  double re = 0.0;
  double im = 0.0;
};
inline Complex operator+(Complex a, Complex b) {
  return {a.re + b.re, a.im + b.im};
}
inline Complex operator-(Complex a, Complex b) {
  return {a.re - b.re, a.im - b.im};
}
inline Complex operator*(Complex a, Complex b) {
  return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
}
inline Complex operator*(double a, Complex b) {
  return {a * b.re, a * b.im};
}
inline Complex operator-(double a, Complex b) {
  return {a - b.re, -b.im};
}
inline Complex inverse(Complex a) {
  const double square = a.re * a.re + a.im * a.im;
  return {a.re / square, -a.im / square};
}

// LDL^T of T - pole, without pivoting: the pole should have an imaginary part or lie below T's
// spectrum. A real pole among T's eigenvalues may cost accuracy; on one, the result is not finite.
class ShiftedFactor {
 public:
  explicit ShiftedFactor(Eigen::Index size)
      : inverse_(static_cast<std::size_t>(size)), ratio_(static_cast<std::size_t>(size)) {}

  void compute(const Tridiagonal& t, Complex pole);

  // x <- (T - pole)^-1 x, r long.
  void solve(std::vector<Complex>& x) const;

 private:
  std::vector<Complex> inverse_;  // of the pivots
  std::vector<Complex> ratio_;    // off-diagonal of L
};

}  // namespace tremolo
