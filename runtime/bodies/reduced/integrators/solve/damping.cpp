#include "runtime/bodies/reduced/integrators/solve/damping.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tremolo {
namespace {

// ((c/2) coth(c/2) - 1)/c^2: theta where omega = 0.
double theta_at_rest(double c) {
  if (c < 0.1) return 1.0 / 12.0 - c * c / 720.0;
  return (0.5 * c / std::tanh(0.5 * c) - 1.0) / (c * c);
}

// m of the header, without cancellation.
double wanted_product(double c, double w, InertiaWeight undamped) {
  const double square = (w - 0.5 * c) * (w + 0.5 * c);  // of the damped frequency
  if (square > 0.0) {
    const double x = 0.5 * std::sqrt(square);
    const double sine = x / std::hypot(x, undamped(x));  // of psi/2
    const double gap = std::expm1(-0.5 * c);
    return gap * gap + 4.0 * std::exp(-0.5 * c) * sine * sine;
  }
  const double fast = 0.5 * c + std::sqrt(-square);
  return std::expm1(-w * (w / fast)) * std::expm1(-fast);
}

// The theta at which the roots meet, where n does not match theta: the roots would be real and the
// larger one negative.
double damp_most(double theta, double c, double w, double n) {
  const bool negative = w * w > 2.0 * c + 2.0 * w * n;
  return negative ? std::min(theta, 1.0 / (w * w) + 2.0 * n / (c * w)) : theta;
}

}  // namespace

Eigen::VectorXd modal_rates(const DampingRatios& ratios, const Eigen::VectorXd& lambda) {
  Eigen::VectorXd rates(lambda.size());
  for (Eigen::Index i = 0; i < lambda.size(); ++i) {
    const double omega = std::sqrt(lambda[i]), frequency = 0.5 * omega / std::numbers::pi;
    rates[i] = 2.0 * omega * ratio_of(ratios, static_cast<std::size_t>(i), frequency);
  }
  return rates;
}

Eigen::VectorXd damping_rates(const Eigen::VectorXd& lambda, const IntegratorOptions& options) {
  Eigen::VectorXd rates = damping_rates(lambda, options.alpha, options.beta);
  if (options.ratios.of_each_mode()) rates += modal_rates(options.ratios, lambda);
  return rates;
}

DampedWeights damped_weights(double c, double w, InertiaWeight undamped) {
  constexpr double kSmall = 1e-2;  // of w: below, theta and n differ from their limits by w^2
  const double rest = undamped(0.5 * w);
  if (!(c > 0.0)) return {0.0, rest};
  const DampedWeights limit{theta_at_rest(c), rest};
  if (w < kSmall) return limit;
  const double product = wanted_product(c, w, undamped);
  const double theta = -std::expm1(-c) / (c * product) - 1.0 / (w * w);
  const double square = w * (w / product) - (0.5 + theta * c) * (0.5 * w * w + c);
  if (!std::isfinite(theta) || !std::isfinite(square)) return limit;  // c or w beyond 1e150
  const double most = std::max(rest * rest, 1.0 - w * w / 12.0);
  const double n = std::sqrt(std::clamp(square, kLeastInertia * kLeastInertia, most));
  return {std::max(damp_most(theta, c, w, n), 0.0), n};
}

Eigen::VectorXd midpoint_damping(const Eigen::VectorXd& rates, const Eigen::VectorXd& lambda,
                                 double step) {
  Eigen::VectorXd result(rates.size());
  for (Eigen::Index i = 0; i < rates.size(); ++i) {
    const double c = step * rates[i], w = step * std::sqrt(lambda[i]);
    const double theta = damped_weights(c, w, unit_weight).theta;
    result[i] = 1.0 + 2.0 * c * (c > 0.0 && w > 0.0 ? damp_most(theta, c, w, 1.0) : theta);
  }
  return result;
}

DampedKick::DampedKick(const Eigen::VectorXd& rates, double step)
    : damped_(rates.size() > 0 && rates.maxCoeff() > 0.0),
      half_step_(0.5 * step),
      decay_(rates.size()),
      reach_(rates.size()),
      path_(rates.size()) {
  const double s = half_step_;
  for (Eigen::Index i = 0; i < rates.size(); ++i) {
    const double y = rates[i] * s;
    const double phi1 = y > 0.0 ? -std::expm1(-y) / y : 1.0;
    const double phi2 =
        y > 1e-2 ? (1.0 - phi1) / y : 0.5 - y * (1.0 / 6.0 - y * (1.0 / 24.0 - y / 120.0));
    decay_[i] = std::exp(-y);
    reach_[i] = s * phi1;
    path_[i] = s * s * phi2;
  }
}

namespace {

constexpr int kTerms = 40;  // of a power series: its roots are at most kFastRoot, 4^40/40! = 1e-24
constexpr double kSlowRoot = 2.0;  // below, the smaller root is too small to divide by
constexpr double kFastRoot = 4.0;  // above this the larger root is far from a slow one
constexpr double kClose = 1.0;     // roots with a smaller distance

constexpr auto kInverseFactorial = [] {
  std::array<double, kTerms + 6> values{1.0};
  double factorial = 1.0;
  for (std::size_t n = 1; n < values.size(); ++n)
    values[n] = 1.0 / (factorial *= static_cast<double>(n));
  return values;
}();

// The sizes of the two roots, small <= large; half: half their distance if they are real, else the
// imaginary part.
struct Roots {
  bool real = true;
  double half = 0.0;
  double small = 0.0;
  double large = 0.0;
};

Roots roots_of(double a, double b) {
  const double omega = std::sqrt(b);
  const double square = (0.5 * a - omega) * (0.5 * a + omega);
  if (square < 0.0) return {false, std::sqrt(-square), omega, omega};
  const double half = std::sqrt(square), large = 0.5 * a + half;
  return {true, half, large == 0.0 ? 0.0 : b / large, large};
}

// u(h)/h and u'(h).
void start_of(double a, const Roots& roots, LinearResponse& response) {
  double& u = response.integral[0];
  if (!roots.real) {
    const double decay = std::exp(-0.5 * a);
    u = decay * std::sin(roots.half) / roots.half;
    response.velocity = decay * std::cos(roots.half) - 0.5 * a * u;
    return;
  }
  const double distance = 2.0 * roots.half, slow = std::exp(-roots.small);
  u = distance == 0.0 ? slow : slow * -std::expm1(-distance) / distance;
  response.velocity = distance < kClose
                          ? slow - roots.large * u
                          : (roots.large * std::exp(-roots.large) - roots.small * slow) / distance;
}

// J_k = sum_n h_n(x1, x2)/(n + k + 1)!, h_n the sum of all products of n roots.
void series(double a, double b, std::array<double, 6>& integral) {
  std::fill(integral.begin() + 1, integral.end(), 0.0);
  double now = 1.0, before = 0.0;
  for (std::size_t n = 0; n < kTerms; ++n) {
    for (std::size_t k = 1; k < integral.size(); ++k)
      integral[k] += now * kInverseFactorial[n + k + 1];
    const double next = -a * now - b * before;
    before = now;
    now = next;
  }
}

// phi_0..phi_5 at -x, x >= 0.
std::array<double, 6> phi(double x) {
  std::array<double, 6> values{};
  if (x < kSlowRoot) {
    double power = 1.0;
    for (std::size_t n = 0; n < kTerms; ++n, power *= -x)
      values[5] += power * kInverseFactorial[n + 5];
    for (std::size_t k = 5; k-- > 0;) values[k] = kInverseFactorial[k] - x * values[k + 1];
    return values;
  }
  values[0] = std::exp(-x);
  for (std::size_t k = 0; k < 5; ++k) values[k + 1] = (kInverseFactorial[k] - values[k]) / x;
  return values;
}

}  // namespace

LinearResponse linear_response(double a, double b) {
  const Roots roots = roots_of(a, b);
  LinearResponse response;
  std::array<double, 6>& integral = response.integral;
  start_of(a, roots, response);
  if (roots.large <= kFastRoot && roots.small < kSlowRoot) {
    series(a, b, integral);
  } else if (roots.small < kSlowRoot) {
    const std::array<double, 6> slow = phi(roots.small), fast = phi(roots.large);
    for (std::size_t k = 1; k < integral.size(); ++k)
      integral[k] = (slow[k] - fast[k]) / (2.0 * roots.half);
  } else {
    // Integrals of the equation itself, from the shortest on.
    double before = response.velocity;
    for (std::size_t k = 0; k + 1 < integral.size(); ++k) {
      integral[k + 1] = (kInverseFactorial[k] - a * integral[k] - before) / b;
      before = integral[k];
    }
  }
  // Of two equal forms the one without cancellation is used.
  response.place =
      roots.small < kSlowRoot ? 1.0 - b * integral[1] : response.velocity + a * integral[0];
  return response;
}

}  // namespace tremolo
