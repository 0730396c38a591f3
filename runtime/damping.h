// Rayleigh damping D = alpha M + beta K(0). In the model's coordinates M is the identity and K(0)
// is diagonal, so D is diagonal too.
#pragma once

#include <Eigen/Core>

namespace tremolo {

// The diagonal of D: alpha + beta lambda_i, 1/s. alpha: 1/s, beta: s, lambda: (rad/s)^2.
inline Eigen::VectorXd damping_rates(const Eigen::VectorXd& lambda, double alpha, double beta) {
  return (alpha + beta * lambda.array()).matrix();
}

// p_i <- decay_i p_i, in place. Returns the kinetic energy that this took away, J.
inline double decay_momentum(const Eigen::VectorXd& decay, Eigen::VectorXd& p) {
  const double before = p.squaredNorm();
  p.array() *= decay.array();
  return 0.5 * (before - p.squaredNorm());
}

}  // namespace tremolo
