#include "runtime/integrators/rational_filter.h"

#include <complex>
#include <vector>

#include <Eigen/Eigenvalues>

#include "runtime/clones.h"
#include "runtime/lanes.h"

namespace tremolo {
namespace {

using Number = std::complex<double>;

// Coefficients from the constant up.
using Polynomial = std::vector<double>;

Polynomial product(const Polynomial& a, const Polynomial& b) {
  Polynomial result(a.size() + b.size() - 1, 0.0);
  for (std::size_t i = 0; i < a.size(); ++i)
    for (std::size_t j = 0; j < b.size(); ++j) result[i + j] += a[i] * b[j];
  return result;
}

Number value(const Polynomial& p, Number z) {
  Number sum = 0.0;
  for (std::size_t i = p.size(); i-- > 0;) sum = sum * z + p[i];
  return sum;
}

Polynomial derivative(const Polynomial& p) {
  Polynomial result;
  for (std::size_t i = 1; i < p.size(); ++i) result.push_back(static_cast<double>(i) * p[i]);
  return result;
}

// The roots with imaginary part >= 0, by the companion matrix and two corrections by Newton.
std::vector<Number> upper_roots(const Polynomial& p) {
  const auto degree = static_cast<Eigen::Index>(p.size()) - 1;
  Eigen::MatrixXd companion = Eigen::MatrixXd::Zero(degree, degree);
  for (Eigen::Index i = 0; i < degree; ++i) {
    if (i + 1 < degree) companion(i + 1, i) = 1.0;
    companion(i, degree - 1) = -p[static_cast<std::size_t>(i)] / p.back();
  }
  const Polynomial slope = derivative(p);
  std::vector<Number> roots;
  for (Number root : companion.eigenvalues()) {
    if (root.imag() < 0.0) continue;
    for (int k = 0; k < 2; ++k) root -= value(p, root) / value(slope, root);
    roots.push_back(root);
  }
  return roots;
}

// b1 and b2 as the header has them.
Polynomial numerator(const FilterShape& shape) {
  return {1.0, shape.a1, shape.a2};
}
Polynomial denominator(const FilterShape& shape) {
  const double b1 = shape.a1 + 1.0 / 3.0;
  return {1.0, b1, shape.a2 + b1 / 3.0 + 1.0 / 45.0};
}

using lanes::all;
using lanes::kLanes;
using lanes::load;
using lanes::store;
using lanes::Vector;

// LDL^T of T - pole for the pole of every lane.
TREMOLO_CLONES void factor_poles(const double* diagonal, const double* off, std::size_t r,
                                 const double* poles, double* inverse_re, double* inverse_im,
                                 double* ratio_re, double* ratio_im) {
  const Vector pole_re = load(poles), pole_im = load(poles + kLanes);
  Vector re = all(diagonal[0]) - pole_re, im = -pole_im;
  for (std::size_t i = 0;; ++i) {
    const Vector scale = all(1.0) / (re * re + im * im);
    const Vector inv_re = re * scale, inv_im = -im * scale;
    store(inverse_re + i * kLanes, inv_re);
    store(inverse_im + i * kLanes, inv_im);
    if (i + 1 == r) return;
    const Vector step = all(off[i]);
    const Vector l_re = inv_re * step, l_im = inv_im * step;
    store(ratio_re + i * kLanes, l_re);
    store(ratio_im + i * kLanes, l_im);
    re = (all(diagonal[i + 1]) - pole_re) - step * l_re;
    im = -pole_im - step * l_im;
  }
}

// x <- limit x + sum over lanes of Re[weight (T - pole)^-1 x].
TREMOLO_CLONES void sum_fractions(std::size_t r, const double* weights, double limit,
                                  const double* inverse_re, const double* inverse_im,
                                  const double* ratio_re, const double* ratio_im,
                                  double* scratch_re, double* scratch_im, double* x) {
  Vector re = all(x[0]), im{};
  store(scratch_re, re);
  store(scratch_im, im);
  for (std::size_t i = 1; i < r; ++i) {
    const Vector l_re = load(ratio_re + (i - 1) * kLanes), l_im = load(ratio_im + (i - 1) * kLanes);
    const Vector next = (all(x[i]) - l_re * re) + l_im * im;
    im = -(l_re * im) - l_im * re;
    re = next;
    store(scratch_re + i * kLanes, re);
    store(scratch_im + i * kLanes, im);
  }
  const Vector w_re = load(weights), w_im = load(weights + kLanes);
  re = im = Vector{};
  for (std::size_t i = r; i-- > 0;) {
    const Vector d_re = load(inverse_re + i * kLanes), d_im = load(inverse_im + i * kLanes);
    const Vector y_re = load(scratch_re + i * kLanes), y_im = load(scratch_im + i * kLanes);
    const Vector z_re = d_re * y_re - d_im * y_im, z_im = d_re * y_im + d_im * y_re;
    if (i + 1 < r) {
      const Vector l_re = load(ratio_re + i * kLanes), l_im = load(ratio_im + i * kLanes);
      const Vector next = (z_re - l_re * re) + l_im * im;
      im = (z_im - l_re * im) - l_im * re;
      re = next;
    } else {
      re = z_re;
      im = z_im;
    }
    x[i] = limit * x[i] + lanes::sum(w_re * re - w_im * im);
  }
}

}  // namespace

double filter_value(const FilterShape& shape, double z) {
  return (value(numerator(shape), z) / value(denominator(shape), z)).real();
}

RationalFilter::RationalFilter(Eigen::Index size, const FilterShape& shape)
    : tridiagonal_(size), poles_(2 * kLanes, 0.0) {
  const Polynomial above = numerator(shape);
  const Polynomial below = denominator(shape);
  limit_ = above[2] / below[2];
  apply_weights_.assign(2 * kLanes, 0.0);
  solve_weights_.assign(2 * kLanes, 0.0);
  for (AlignedDoubles* array :
       {&inverse_re_, &inverse_im_, &ratio_re_, &ratio_im_, &scratch_re_, &scratch_im_})
    array->assign(static_cast<std::size_t>(size) * kLanes, 0.0);
  // At most two poles and five: eight lanes suffice. A lane that is left over has its pole far
  // away.
  std::fill_n(poles_.begin(), kLanes, -1.0);
  std::fill_n(poles_.begin() + kLanes, kLanes, 1.0);
  std::size_t lane = 0;
  const auto add = [&](Number root, Number residue, AlignedDoubles& weights) {
    if (root.imag() > 0.0) residue *= 2.0;
    poles_[lane] = root.real();
    poles_[kLanes + lane] = root.imag();
    weights[lane] = residue.real();
    weights[kLanes + lane] = residue.imag();
    ++lane;
  };
  for (const Number root : upper_roots(below))
    add(root, value(above, root) / value(derivative(below), root), apply_weights_);
  // 1/(N^2 + z) = below^2 / (above^2 + z below^2)
  Polynomial whole = product({0.0, 1.0}, product(below, below));
  const Polynomial square = product(above, above);
  for (std::size_t i = 0; i < square.size(); ++i) whole[i] += square[i];
  for (const Number root : upper_roots(whole))
    add(root, value(below, root) * value(below, root) / value(derivative(whole), root),
        solve_weights_);
}

void RationalFilter::compute(const Eigen::MatrixXd& z) {
  tridiagonal_.compute(z);
  if (z.rows() > 0)
    factor_poles(tridiagonal_.diagonal().data(), tridiagonal_.off().data(),
                 static_cast<std::size_t>(z.rows()), poles_.data(), inverse_re_.data(),
                 inverse_im_.data(), ratio_re_.data(), ratio_im_.data());
}

void RationalFilter::apply(Eigen::VectorXd& x) {
  sum_fractions(static_cast<std::size_t>(x.size()), apply_weights_.data(), limit_,
                inverse_re_.data(), inverse_im_.data(), ratio_re_.data(), ratio_im_.data(),
                scratch_re_.data(), scratch_im_.data(), x.data());
}

void RationalFilter::solve(Eigen::VectorXd& x) {
  sum_fractions(static_cast<std::size_t>(x.size()), solve_weights_.data(), 0.0, inverse_re_.data(),
                inverse_im_.data(), ratio_re_.data(), ratio_im_.data(), scratch_re_.data(),
                scratch_im_.data(), x.data());
}

void RationalFilter::multiply(Eigen::VectorXd& x) const {
  double before = 0.0;  // the entry above, as it was
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    double sum = tridiagonal_.diagonal()[i] * x[i];
    if (i > 0) sum += tridiagonal_.off()[i - 1] * before;
    if (i + 1 < x.size()) sum += tridiagonal_.off()[i] * x[i + 1];
    before = x[i];
    x[i] = sum;
  }
}

}  // namespace tremolo
