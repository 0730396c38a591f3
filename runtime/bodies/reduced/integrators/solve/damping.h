// The damping D: Rayleigh's alpha M + beta K(0), and a ratio zeta_i of each coordinate, 2 zeta_i
// omega_i. In the model's coordinates M is the identity and K(0) is diagonal, so D and its discrete
// forms are diagonal too.
//
// Two conditions must hold at any D h. A coordinate that moves freely must decay as s^2 + D s +
// omega^2 = 0. A stiff coordinate that follows others, or a strongly damped one that follows the
// load, moves with the velocity at which D v balances the other forces. Its damping force must be
// correct, while Dp and the free motion hardly matter.
//
// Implicit rows. The energy-preserving step of one coordinate
// (runtime/bodies/reduced/integrators/energy_preserving.cpp, where sigma = 1/2 + theta h D is S^-1)
//
//     sigma Dp = n d/h - p0,      n Dp/h + omega^2 (q0 + d/2) + D d/h = f
//
// has the damping force D d/h, and two free numbers: theta >= 0, which takes theta h D Dp^2 of the
// energy, and the weight n of the inertia. With c = h D, w = h omega and N the weight without
// damping, the step's two roots z have
//
//     1 - z1 z2        = c (1 + theta w^2) / S,      S = n^2 + sigma (w^2/2 + c),
//     (1 - z1)(1 - z2) = w^2 / S,
//
// so that both follow from the requested roots: z1 z2 = e^{-c}, and
//
//     theta = (1 - e^{-c})/(c m) - 1/w^2,       n^2 = w^2/m - sigma (w^2/2 + c),
//     m = (1 - z1)(1 - z2).
//
// The requested roots are the exact ones where the oscillator is overdamped, else e^{-c/2 +- i psi}
// with the phase that N gives an undamped oscillator of the damped frequency: psi = 2 atan(x/N(x)),
// x = (w^2 - c^2/4)^{1/2}/2. theta is positive everywhere: 1/12 for small c and w where N = x cot
// x, 1/4 where N = 1, 1/(2c) for large c. n differs from N by O(c^2), O(c w). For w = 0 both n = 1
// and a sigma = 1/(1 - e^{-c}) - 1/c are exact.
#pragma once

#include <array>

#include <Eigen/Core>

#include "runtime/integrator.h"

namespace tremolo {

// The diagonal of D: alpha + beta lambda_i, 1/s. alpha: 1/s, beta: s, lambda: (rad/s)^2.
inline Eigen::VectorXd damping_rates(const Eigen::VectorXd& lambda, double alpha, double beta) {
  return (alpha + beta * lambda.array()).matrix();
}

// The rates 2 zeta_i omega_i of ratios of each coordinate, r, 1/s; zeros for none. lambda: of all
// coordinates, so that the first has the first ratio.
Eigen::VectorXd modal_rates(const DampingRatios& ratios, const Eigen::VectorXd& lambda);

// The diagonal of D of the options, r, 1/s. lambda: of all coordinates, (rad/s)^2.
Eigen::VectorXd damping_rates(const Eigen::VectorXd& lambda, const IntegratorOptions& options);

// theta and n of the header for one coordinate.
struct DampedWeights {
  double theta = 0.0;
  double n = 1.0;
};

// N(x) of an undamped oscillator, x = h omega/2 >= 0. Dimensionless, positive.
using InertiaWeight = double (*)(double x);

// c = h D >= 0, w = h omega >= 0. Where n^2 would not be positive (overdamped and stiff, w > 4), n
// is kLeastInertia: the logarithm of the slow root is then off by at most a tenth, by less for c >
// w^2/2.
DampedWeights damped_weights(double c, double w, InertiaWeight undamped);

// Weight of the midpoint rule, N = 1.
inline double unit_weight(double) {
  return 1.0;
}

// 1 + 2 theta h D for rows of the midpoint rule with theta and n = 1, r; 1 without damping. rates:
// D, lambda: omega^2, both r.
Eigen::VectorXd midpoint_damping(const Eigen::VectorXd& rates, const Eigen::VectorXd& lambda,
                                 double step);

inline constexpr double kLeastInertia = 0.2;

// Rows of the midpoint rule with damping: for d = q1 - q0 they solve
//
//     (d - h p0)/g + (h^2/2) [force at the midpoint + D d/h] = 0,       g = 1 + 2 theta h D,
//
// and then p1 = p0 + dp, dp = (2/g) (d/h - p0).
struct DampedMidpoint {
  template <class Momentum>
  void set_change(const Eigen::VectorXd& d, const Momentum& p0, Eigen::VectorXd& dp) const {
    dp.array() = (2.0 / g.array()) * (d.array() / h - p0.array());
  }
  // Energy that damping takes in the step, J.
  double dissipated(const Eigen::VectorXd& d, const Eigen::VectorXd& dp) const {
    return (d.array().square() * D.array()).sum() / h +
           0.5 * ((g.array() - 1.0) * dp.array().square()).sum();
  }

  double h;           // the step, s
  Eigen::VectorXd D;  // 1/s, one per row
  Eigen::VectorXd g;  // one per row
};

inline DampedMidpoint make_damped_midpoint(const Eigen::VectorXd& D, const Eigen::VectorXd& lambda,
                                           double h) {
  return {h, D, midpoint_damping(D, lambda, h)};
}

// p_i <- decay_i p_i, in place. Returns the kinetic energy that this removed, J.
inline double decay_momentum(const Eigen::VectorXd& decay, Eigen::VectorXd& p) {
  const double before = p.squaredNorm();
  p.array() *= decay.array();
  return 0.5 * (before - p.squaredNorm());
}

// Explicit rows: kick and damping in one, the exact flow of p' = -D p + f for constant f over half
// a step,
//
//     p <- e^{-y} p + s phi1(y) f,      s = h/2, y = D s, phi1(y) = (1 - e^{-y})/y.
//
// With the drift q <- q + h p between two of these, a free coordinate has z1 z2 = e^{-c} and is
// stable for w^2 < 2 c coth(c/2). A coordinate that follows f moves with v = f/D exactly.
class DampedKick {
 public:
  DampedKick() = default;
  DampedKick(const Eigen::VectorXd& rates, double step);

  // Kicks the first force.size() rows. Returns the energy that damping took, J: the work of f less
  // the growth of p^2/2.
  template <class Force>
  double operator()(const Force& force, Eigen::VectorXd& p) const {
    const Eigen::Index rows = force.size();
    if (!damped_) {
      p.head(rows) += half_step_ * force;
      return 0.0;
    }
    double taken = 0.0;
    for (Eigen::Index i = 0; i < rows; ++i) {
      const double before = p[i], f = force[i];
      const double after = decay_[i] * before + reach_[i] * f;
      const double path = reach_[i] * before + path_[i] * f;
      taken += f * path - 0.5 * (after - before) * (after + before);
      p[i] = after;
    }
    return taken;
  }

  bool damped() const { return damped_; }
  const Eigen::VectorXd& decay() const { return decay_; }  // e^{-y}
  const Eigen::VectorXd& reach() const { return reach_; }  // s phi1(y), s
  // s^2 (1 - phi1(y))/y, s^2: the displacement per f in the half step.
  const Eigen::VectorXd& path() const { return path_; }

 private:
  bool damped_ = false;
  double half_step_ = 0.0;
  Eigen::VectorXd decay_;
  Eigen::VectorXd reach_;
  Eigen::VectorXd path_;
};

// The response of one damped oscillator  q'' + D q' + lambda q = f  within a step, in closed form.
//
// Let u be its response to a unit impulse: u(0) = 0, u'(0) = 1, f = 0. With x1, x2 the roots of x^2
// + a x + b, a = D h, b = lambda h^2, and phi_k(x) = sum_n x^n/(n + k)!, the k-fold integral of u
// from 0 to h is h^(k+1) times the divided difference phi_k[x1, x2]. That is real, and smooth in a
// and b: below, at and above critical damping, with lambda = 0 and with D = 0.

// The values of one step, dimensionless.
struct LinearResponse {
  double velocity = 1.0;  // u'(h)
  double place = 1.0;     // u'(h) + D u(h): q(h) of the oscillator that starts at rest from q = 1
  // integral[k]: J_k = phi_k[x1, x2], that is u(h)/h for k = 0 and the k-fold integral of u over
  // h^(k+1) above.
  std::array<double, 6> integral{};
};

// a = D h >= 0, b = lambda h^2 >= 0, finite. Errors are a few rounding errors: relative to each of
// the integrals (to 1e-14 for J_4, 2e-14 for J_5), relative to the oscillation's size near zeros;
// the phase h omega is rounded like any number.
LinearResponse linear_response(double a, double b);

}  // namespace tremolo
