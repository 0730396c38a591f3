// Rayleigh damping D = alpha M + beta K(0). In the model's coordinates M is the identity and K(0)
// is diagonal, so D is diagonal too.
#pragma once

#include <Eigen/Core>

#include "runtime/split.h"

namespace tremolo {

// The diagonal of D: alpha + beta lambda_i, 1/s. alpha: 1/s, beta: s, lambda: (rad/s)^2.
inline Eigen::VectorXd damping_rates(const Eigen::VectorXd& lambda, double alpha, double beta) {
  return (alpha + beta * lambda.array()).matrix();
}

// What the splitting methods take by exponentials over `time`, s: e^{-(alpha + beta lambda_i) time}
// on low rows, e^{-alpha time} on high rows; r.
inline Eigen::VectorXd split_decay(const Eigen::VectorXd& lambda, Split split, double alpha,
                                   double beta, double time) {
  Eigen::VectorXd rates = damping_rates(lambda, alpha, beta);
  rates.tail(split.high).setConstant(alpha);
  return (-time * rates.array()).exp().matrix();
}

// p_i <- decay_i p_i, in place. Returns the kinetic energy that this took away, J.
inline double decay_momentum(const Eigen::VectorXd& decay, Eigen::VectorXd& p) {
  const double before = p.squaredNorm();
  p.array() *= decay.array();
  return 0.5 * (before - p.squaredNorm());
}

}  // namespace tremolo
