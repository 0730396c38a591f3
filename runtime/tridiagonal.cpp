#include "runtime/tridiagonal.h"

#include <algorithm>
#include <cmath>

#include "runtime/clones.h"
#include "runtime/lanes.h"

namespace tremolo {
namespace {

using lanes::all;
using lanes::kLanes;
using lanes::load;
using lanes::store;
using lanes::Vector;
using std::size_t;

// Of the squares of a column below the first subdiagonal: less than that is left out. They would
// underflow, and reflections that are made of them would not be orthogonal.
constexpr double kNothing = 1e-280;

// sum = M x on the columns and rows from the vector at `from` on, columns [first, r).
TREMOLO_INLINE void multiply_block(const double* m, size_t stride, size_t first, size_t r,
                                   size_t from, const double* x, double* sum) {
  for (size_t t = from; t < r; t += 2 * kLanes) {
    const bool two = t + kLanes < r;
    Vector a{}, b{}, c{}, d{};
    size_t j = first;
    for (; j + 2 <= r; j += 2) {
      const Vector x0 = all(x[j]), x1 = all(x[j + 1]);
      const double* column = m + j * stride + t;
      a += load(column) * x0;
      b += load(column + stride) * x1;
      if (two) {
        c += load(column + kLanes) * x0;
        d += load(column + stride + kLanes) * x1;
      }
    }
    if (j < r) {
      const Vector x0 = all(x[j]);
      a += load(m + j * stride + t) * x0;
      if (two) c += load(m + j * stride + t + kLanes) * x0;
    }
    store(sum + t, a + b);
    if (two) store(sum + t + kLanes, c + d);
  }
}

// a: both triangles, padded with zeros, destroyed.
TREMOLO_CLONES void reduce(double* a, size_t r, size_t stride, double* diagonal, double* off,
                           double* reflections, double* image) {
  for (size_t k = 0; k + 1 < r; ++k) {
    const size_t first = k + 1;
    const size_t from = first / kLanes * kLanes;
    const double* column = a + k * stride;
    double* u = reflections + k * stride;
    diagonal[k] = column[k];
    const double head = column[first];
    for (size_t t = from; t < stride; t += kLanes) store(u + t, load(column + t));
    for (size_t i = from; i <= first; ++i) u[i] = 0.0;
    Vector squares{};
    for (size_t t = from; t < stride; t += kLanes) squares += load(u + t) * load(u + t);
    const double rest = lanes::sum(squares);
    if (rest < kNothing) {
      for (size_t t = from; t < stride; t += kLanes) store(u + t, Vector{});
      off[k] = head;
      continue;
    }
    // Away from head, so that nothing cancels.
    const double length = std::sqrt(rest + head * head);
    const double target = head > 0.0 ? -length : length;
    const double scale = 1.0 / std::sqrt(length * (length + std::abs(head)));
    u[first] = head - target;
    for (size_t t = from; t < stride; t += kLanes) store(u + t, load(u + t) * all(scale));
    off[k] = target;
    multiply_block(a, stride, first, r, from, u, image);
    for (size_t i = from; i < first; ++i) image[i] = 0.0;
    Vector parts{};
    for (size_t t = from; t < stride; t += kLanes) parts += load(image + t) * load(u + t);
    const Vector half = all(0.5 * lanes::sum(parts));
    for (size_t t = from; t < stride; t += kLanes)
      store(image + t, load(image + t) - half * load(u + t));
    for (size_t j = first; j < r; ++j) {
      const Vector uj = all(u[j]), wj = all(image[j]);
      double* c = a + j * stride;
      for (size_t t = from; t < stride; t += kLanes)
        store(c + t, (load(c + t) - load(u + t) * wj) - load(image + t) * uj);
    }
  }
  diagonal[r - 1] = a[(r - 1) * stride + r - 1];
}

// basis = W^T = ... H_1 H_0 from the reflections: V <- V H_k from the last to the first.
TREMOLO_CLONES void accumulate(const double* reflections, size_t r, size_t stride, double* basis,
                               double* image) {
  std::fill(basis, basis + r * stride, 0.0);
  for (size_t i = 0; i < r; ++i) basis[i * stride + i] = 1.0;
  for (size_t k = r < 2 ? 0 : r - 2; k-- > 0;) {
    const size_t first = k + 1;
    const size_t from = first / kLanes * kLanes;
    const double* u = reflections + k * stride;
    multiply_block(basis, stride, first, r, from, u, image);
    for (size_t j = first; j < r; ++j) {
      const Vector uj = all(u[j]);
      double* c = basis + j * stride;
      for (size_t t = from; t < stride; t += kLanes)
        store(c + t, load(c + t) - load(image + t) * uj);
    }
  }
}

TREMOLO_CLONES void multiply(const double* m, size_t r, size_t stride, const double* x,
                             double* sum) {
  multiply_block(m, stride, 0, r, 0, x, sum);
}

// sum = M^T x, M's columns padded up to a multiple of eight.
TREMOLO_CLONES void multiply_transposed(const double* m, size_t r, size_t stride, const double* x,
                                        double* sum) {
  for (size_t j = 0; j < r; j += kLanes) {
    Vector parts[kLanes] = {};
    for (size_t t = 0; t < stride; t += kLanes) {
      const Vector row = load(x + t);
#pragma GCC unroll 8
      for (size_t b = 0; b < kLanes; ++b) parts[b] += load(m + (j + b) * stride + t) * row;
    }
    store(sum + j, lanes::sums(parts));
  }
}

}  // namespace

Tridiagonal::Tridiagonal(Eigen::Index size)
    : r_(static_cast<size_t>(size)),
      stride_(lanes::padded(r_)),
      diagonal_(Eigen::VectorXd::Zero(size)),
      off_(Eigen::VectorXd::Zero(std::max<Eigen::Index>(size - 1, 0))),
      work_(stride_ * stride_, 0.0),
      reflections_(stride_ * stride_, 0.0),
      basis_(stride_ * stride_, 0.0),
      image_(stride_ + kLanes, 0.0),
      vector_(2 * stride_ + kLanes, 0.0) {}

void Tridiagonal::compute(const Eigen::MatrixXd& a) {
  if (r_ == 0) return;
  for (size_t j = 0; j < r_; ++j)
    for (size_t i = j; i < r_; ++i)
      work_[i * stride_ + j] = work_[j * stride_ + i] = a.data()[j * r_ + i];
  reduce(work_.data(), r_, stride_, diagonal_.data(), off_.data(), reflections_.data(),
         image_.data());
  accumulate(reflections_.data(), r_, stride_, basis_.data(), image_.data());
}

void Tridiagonal::to_basis(Eigen::VectorXd& x) const {
  std::copy(x.data(), x.data() + r_, vector_.begin());
  multiply(basis_.data(), r_, stride_, vector_.data(), vector_.data() + stride_);
  std::copy_n(vector_.data() + stride_, r_, x.data());
}

void Tridiagonal::from_basis(Eigen::VectorXd& x) const {
  std::copy(x.data(), x.data() + r_, vector_.begin());
  multiply_transposed(basis_.data(), r_, stride_, vector_.data(), vector_.data() + stride_);
  std::copy_n(vector_.data() + stride_, r_, x.data());
}

}  // namespace tremolo
