#include "runtime/bodies/reduced/integrators/solve/inertia_filter.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

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

// The roots with imaginary part >= 0, of real coefficients, by Weierstrass' iteration (Durand and
// Kerner): each root's estimate is corrected by p over the product of its distances to the others.
// It converges for the denominators of filters, whose roots lie apart.
std::vector<Number> upper_roots(const Polynomial& p) {
  constexpr int kIterations = 200;
  constexpr double kMoved = 1e-12;  // of the bound; its square, the remaining error, is rounding
  constexpr double kReal = 1e-12;   // an imaginary part of this share is rounding
  const std::size_t degree = p.size() - 1;
  double bound = 0.0;  // Cauchy's, of all roots
  for (std::size_t i = 0; i < degree; ++i) bound = std::max(bound, 1.0 + std::abs(p[i] / p.back()));
  std::vector<Number> all(degree);
  for (std::size_t i = 0; i < degree; ++i)
    all[i] = std::polar(0.5 * bound, 0.4 + 2.0 * std::numbers::pi * static_cast<double>(i) /
                                               static_cast<double>(degree));
  double moved = bound;
  for (int k = 0; k < kIterations && moved > kMoved * bound; ++k) {
    moved = 0.0;
    for (Number& root : all) {
      Number apart = p.back();
      for (const Number& other : all)
        if (&other != &root) apart *= root - other;
      const Number move = value(p, root) / apart;
      moved = std::max(moved, std::abs(move));
      root -= move;
    }
  }
  std::vector<Number> upper;
  for (Number root : all) {
    if (std::abs(root.imag()) <= kReal * std::abs(root)) root = root.real();
    if (root.imag() >= 0.0) upper.push_back(root);
  }
  std::sort(upper.begin(), upper.end(), [](Number a, Number b) { return a.imag() < b.imag(); });
  return upper;
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

FilterFractions filter_fractions(const FilterShape& shape) {
  const Polynomial above = numerator(shape), below = denominator(shape);
  FilterFractions fractions;
  fractions.limit = above[2] / below[2];
  // At most two poles and five: eight lanes suffice. An unused lane has its pole far away.
  std::fill_n(fractions.poles.re, 8, -1.0);
  std::fill_n(fractions.poles.im, 8, 1.0);
  std::size_t lane = 0;
  const auto add = [&](Number root, Number residue, ComplexLanes& residues) {
    if (root.imag() > 0.0) residue *= 2.0;
    fractions.poles.set(lane, root);
    residues.set(lane++, residue);
  };
  for (const Number root : upper_roots(below))
    add(root, value(above, root) / value(derivative(below), root), fractions.of_filter);
  // 1/(N^2 + z) = below^2 / (above^2 + z below^2)
  Polynomial whole = product({0.0, 1.0}, product(below, below));
  const Polynomial square = product(above, above);
  for (std::size_t i = 0; i < square.size(); ++i) whole[i] += square[i];
  for (const Number root : upper_roots(whole))
    add(root, value(below, root) * value(below, root) / value(derivative(whole), root),
        fractions.of_inverse);
  return fractions;
}

double filter_value(const FilterShape& shape, double z) {
  return (value(numerator(shape), z) / value(denominator(shape), z)).real();
}

double filter_slope(const FilterShape& shape, double z, double y) {
  const Polynomial a = numerator(shape), b = denominator(shape);
  const double above =
      (a[1] - b[1]) + (a[2] - b[2]) * (z + y) + (a[2] * b[1] - a[1] * b[2]) * z * y;
  return above / (value(b, z) * value(b, y)).real();
}

RationalFilter::RationalFilter(Eigen::Index size, const FilterShape& shape)
    : RationalFilter(size, filter_fractions(shape)) {}

RationalFilter::RationalFilter(Eigen::Index size, const FilterFractions& fractions)
    : tridiagonal_(size), fractions_(fractions), resolvents_(size, fractions.poles) {}

void RationalFilter::compute(const Eigen::MatrixXd& z) {
  tridiagonal_.compute(z);
  resolvents_.compute(tridiagonal_);
}

void RationalFilter::apply(Eigen::VectorXd& x) {
  resolvents_.apply(fractions_.of_filter, fractions_.limit, x);
}

void RationalFilter::solve(Eigen::VectorXd& x) {
  resolvents_.apply(fractions_.of_inverse, 0.0, x);
}

namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double kEp2Limit = 1.2;  // of h omega/2: x cot x stays above 0.46

// Damping is strong where it changes J's diagonal by more than this, relative.
constexpr double kStrongDamping = 0.02;

}  // namespace

double cotangent_weight(double x) {
  x = std::min(x, kEp2Limit);
  return x < 1e-4 ? 1.0 - x * x / 3.0 : x / std::tan(x);
}

double rational_weight(double x) {
  return filter_value(kRobustShape, x * x);
}

double stiff_share(double beta, double h, double omega) {
  const double w = h * omega;
  const double x = std::clamp(4.0 * beta * omega * std::max(w, 1.0) - 1.0, 0.0, 1.0);
  return 1.0 - x * x * (3.0 - 2.0 * x);
}

InertiaDamping make_inertia_damping(const Model& model, const IntegratorOptions& options,
                                    InertiaWeight at_rest, InertiaWeight stiff) {
  const double h = options.step;
  const Index r = model.modes();
  InertiaDamping damping;
  damping.D = damping_rates(model.lambda(), options);
  damping.present = r > 0 && damping.D.maxCoeff() > 0.0;
  damping.z = (0.25 * h * h) * model.lambda();
  if (!model.potential().linear()) damping.strain = 2.0 * options.beta / h;
  for (VectorXd* v : {&damping.theta, &damping.n, &damping.shift, &damping.g, &damping.slope})
    v->setZero(r);
  for (Index i = 0; i < r; ++i) {
    const double omega = std::sqrt(model.lambda()[i]);
    const double c = h * damping.D[i], w = h * omega;
    const DampedWeights whole = damped_weights(c, w, at_rest);
    const double rest = at_rest(0.5 * w);
    const double share = damping.strain > 0.0 ? stiff_share(options.beta, h, omega) : 1.0;
    const double theta = share * whole.theta, slaved = stiff(0.5 * w);
    const double n = share == 1.0 ? whole.n : slaved + share * (whole.n - slaved);
    damping.theta[i] = theta;
    damping.n[i] = n;
    damping.shift[i] = n - rest;
    damping.g[i] = 1.0 + 2.0 * theta * c;
    damping.slope[i] = n * n / damping.g[i] + 0.5 * c;
  }
  return damping;
}

DampedJacobian make_damped_jacobian(const InertiaDamping& damping) {
  const VectorXd& z = damping.z;
  const Index r = z.size();
  DampedJacobian jacobian{false, damping.slope, Eigen::MatrixXd(r, r)};
  const VectorXd weight = damping.n.cwiseProduct(damping.g.cwiseInverse());
  for (Index j = 0; j < r; ++j)
    for (Index i = 0; i < r; ++i)
      jacobian.factors(i, j) =
          1.0 + damping.strain + filter_slope(kRobustShape, z[i], z[j]) * (weight[i] + weight[j]);
  const Eigen::ArrayXd undamped = (damping.n - damping.shift).array().square();
  const Eigen::ArrayXd change = (jacobian.slope.array() - undamped).abs() / (undamped + z.array());
  jacobian.strong = change.maxCoeff() > kStrongDamping;
  jacobian.slope.array() += (1.0 - jacobian.factors.diagonal().array()) * z.array();
  return jacobian;
}

DampedMatrixFilter::DampedMatrixFilter(const InertiaDamping& damping)
    : shift_(damping.shift),
      shifted_(shift_),
      jacobian_(make_damped_jacobian(damping)),
      filter_(shift_.size(), kRobustShape),
      factor_(shift_.size()) {}

}  // namespace tremolo
