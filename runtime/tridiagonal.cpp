#include "runtime/tridiagonal.h"

#include <algorithm>
#include <cmath>

#include "runtime/clones.h"

namespace tremolo {
namespace {

// Of a column below the diagonal: what is smaller is left out. Its squares would underflow, and
// reflections that are made of them would not be orthogonal.
constexpr double kNothing = 1e-140;

// A -= v w^T + w v^T on the trailing block.
TREMOLO_CLONES
void subtract_pair(double* __restrict a, std::size_t r, std::size_t first,
                   const double* __restrict v, const double* __restrict w) {
  for (std::size_t j = first; j < r; ++j) {
    double* c = a + j * r;
    const double vj = v[j], wj = w[j];
#pragma omp simd
    for (std::size_t i = first; i < r; ++i) c[i] -= v[i] * wj + w[i] * vj;
  }
}

// image = A u on the trailing block: the rows of the symmetric block are its columns.
TREMOLO_CLONES
void multiply_block(const double* __restrict a, std::size_t r, std::size_t first,
                    const double* __restrict u, double* __restrict image) {
  for (std::size_t i = first; i < r; ++i) image[i] = 0.0;
  std::size_t j = first;
  for (; j + 4 <= r; j += 4) {
    const double* c0 = a + j * r;
    const double* c1 = c0 + r;
    const double* c2 = c1 + r;
    const double* c3 = c2 + r;
    const double u0 = u[j], u1 = u[j + 1], u2 = u[j + 2], u3 = u[j + 3];
#pragma omp simd
    for (std::size_t i = first; i < r; ++i)
      image[i] += (c0[i] * u0 + c1[i] * u1) + (c2[i] * u2 + c3[i] * u3);
  }
  for (; j < r; ++j) {
    const double* c = a + j * r;
    const double uj = u[j];
#pragma omp simd
    for (std::size_t i = first; i < r; ++i) image[i] += c[i] * uj;
  }
}

}  // namespace

Tridiagonal::Tridiagonal(Eigen::Index size)
    : diagonal_(Eigen::VectorXd::Zero(size)),
      off_(Eigen::VectorXd::Zero(std::max<Eigen::Index>(size - 1, 0))),
      reflections_(Eigen::MatrixXd::Zero(size, size)),
      image_(Eigen::VectorXd::Zero(size)) {}

void Tridiagonal::compute(Eigen::MatrixXd& a) {
  const Eigen::Index r = diagonal_.size();
  for (Eigen::Index k = 0; k + 1 < r; ++k) {
    diagonal_[k] = a(k, k);
    const Eigen::Index first = k + 1;
    const Eigen::Index count = r - first;
    auto u = reflections_.col(k);
    const double head = a(first, k);
    const double length = a.col(k).tail(count).norm();
    const double rest = count > 1 ? a.col(k).tail(count - 1).cwiseAbs().maxCoeff() : 0.0;
    const double scale = std::sqrt(length * (length + std::abs(head)));
    if (rest < kNothing) {
      u.tail(count).setZero();
      off_[k] = head;
      continue;
    }
    // Away from head, so that nothing cancels; |u|^2 = 2.
    const double target = head > 0.0 ? -length : length;
    u.tail(count) = a.col(k).tail(count) / scale;
    u[first] = (head - target) / scale;
    off_[k] = target;
    multiply_block(a.data(), static_cast<std::size_t>(r), static_cast<std::size_t>(first), u.data(),
                   image_.data());
    const double half = 0.5 * image_.tail(count).dot(u.tail(count));
    image_.tail(count) -= half * u.tail(count);
    subtract_pair(a.data(), static_cast<std::size_t>(r), static_cast<std::size_t>(first), u.data(),
                  image_.data());
  }
  if (r > 0) diagonal_[r - 1] = a(r - 1, r - 1);
}

void Tridiagonal::to_basis(Eigen::VectorXd& x) const {
  const Eigen::Index r = diagonal_.size();
  for (Eigen::Index k = 0; k + 2 < r; ++k) {
    const auto u = reflections_.col(k).tail(r - k - 1);
    x.tail(r - k - 1) -= u.dot(x.tail(r - k - 1)) * u;
  }
}

void Tridiagonal::from_basis(Eigen::VectorXd& x) const {
  const Eigen::Index r = diagonal_.size();
  for (Eigen::Index k = r - 3; k >= 0; --k) {
    const auto u = reflections_.col(k).tail(r - k - 1);
    x.tail(r - k - 1) -= u.dot(x.tail(r - k - 1)) * u;
  }
}

void ShiftedFactor::compute(const Tridiagonal& t, Complex pole) {
  const std::size_t r = inverse_.size();
  if (r == 0) return;
  inverse_[0] = inverse(t.diagonal()[0] - pole);
  for (std::size_t i = 1; i < r; ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    const double off = t.off()[at - 1];
    ratio_[i - 1] = off * inverse_[i - 1];
    inverse_[i] = inverse((t.diagonal()[at] - pole) - off * ratio_[i - 1]);
  }
}

void ShiftedFactor::solve(std::vector<Complex>& x) const {
  const std::size_t r = x.size();
  if (r == 0) return;
  for (std::size_t i = 1; i < r; ++i) x[i] = x[i] - ratio_[i - 1] * x[i - 1];
  x[r - 1] = x[r - 1] * inverse_[r - 1];
  for (std::size_t i = r - 1; i-- > 0;) x[i] = x[i] * inverse_[i] - ratio_[i] * x[i + 1];
}

}  // namespace tremolo
