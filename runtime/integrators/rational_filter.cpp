#include "runtime/integrators/rational_filter.h"

#include <complex>

#include <Eigen/Eigenvalues>

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

}  // namespace

double filter_value(const FilterShape& shape, double z) {
  return (value(numerator(shape), z) / value(denominator(shape), z)).real();
}

RationalFilter::RationalFilter(Eigen::Index size, const FilterShape& shape)
    : tridiagonal_(size),
      scratch_(static_cast<std::size_t>(size)),
      sum_(Eigen::VectorXd::Zero(size)) {
  const Polynomial above = numerator(shape);
  const Polynomial below = denominator(shape);
  limit_ = above[2] / below[2];
  const auto pole_at = [size](Number root, Number residue) {
    if (root.imag() > 0.0) residue *= 2.0;
    return Pole{{root.real(), root.imag()}, {residue.real(), residue.imag()}, ShiftedFactor(size)};
  };
  for (const Number root : upper_roots(below))
    apply_poles_.push_back(pole_at(root, value(above, root) / value(derivative(below), root)));
  // 1/(N^2 + z) = below^2 / (above^2 + z below^2)
  Polynomial whole = product({0.0, 1.0}, product(below, below));
  const Polynomial square = product(above, above);
  for (std::size_t i = 0; i < square.size(); ++i) whole[i] += square[i];
  for (const Number root : upper_roots(whole))
    solve_poles_.push_back(
        pole_at(root, value(below, root) * value(below, root) / value(derivative(whole), root)));
}

void RationalFilter::compute(Eigen::MatrixXd& z) {
  tridiagonal_.compute(z);
  for (Pole& pole : apply_poles_) pole.factor.compute(tridiagonal_, pole.place);
  for (Pole& pole : solve_poles_) pole.factor.compute(tridiagonal_, pole.place);
}

void RationalFilter::add_fraction(const Pole& pole, const Eigen::VectorXd& x) {
  for (std::size_t i = 0; i < scratch_.size(); ++i)
    scratch_[i] = {x[static_cast<Eigen::Index>(i)], 0.0};
  pole.factor.solve(scratch_);
  for (std::size_t i = 0; i < scratch_.size(); ++i)
    sum_[static_cast<Eigen::Index>(i)] += (pole.residue * scratch_[i]).re;
}

void RationalFilter::apply(Eigen::VectorXd& x) {
  sum_ = limit_ * x;
  for (const Pole& pole : apply_poles_) add_fraction(pole, x);
  x = sum_;
}

void RationalFilter::solve(Eigen::VectorXd& x) {
  sum_.setZero();
  for (const Pole& pole : solve_poles_) add_fraction(pole, x);
  x = sum_;
}

}  // namespace tremolo
