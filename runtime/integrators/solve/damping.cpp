#include "runtime/integrators/solve/damping.h"

#include <algorithm>
#include <cmath>

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

}  // namespace tremolo
