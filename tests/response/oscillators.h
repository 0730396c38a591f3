// Systems with known answers, and a solver that shares nothing with the library's: shooting with
// Runge-Kutta steps.
#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include <Eigen/Dense>

#include "common/packed_index.h"
#include "runtime/response/response.h"

namespace tremolo {

// x'' + 2 zeta w0 x' + w0^2 x + gamma x^3 = f.
struct Duffing {
  double omega = 1.0;  // w0, rad/s
  double gamma = 1.0;
  double zeta = 0.0;
};

inline VibratingSystem system_of(const Duffing& duffing) {
  const std::vector<double> cubic{0.0}, quartic{0.25 * duffing.gamma};
  Potential potential = *Potential::create(
      Eigen::VectorXd::Constant(1, duffing.omega * duffing.omega), cubic, quartic);
  return {std::move(potential),
          Eigen::VectorXd::Constant(1, 2.0 * duffing.zeta * duffing.omega),
          0.0,
          {}};
}

// A force of harmonic 1: f cos(omega t).
inline FourierSeries cosine_force(const Eigen::VectorXd& f) {
  FourierSeries force = FourierSeries::Zero(f.size(), 3);
  force.col(1) = f;
  return force;
}

// Options whose amplitude is the largest |q|, without bound.
inline CurveOptions plain_options(Eigen::Index harmonics) {
  CurveOptions options;
  options.harmonics = options.most_harmonics = harmonics;
  options.amplitude = [](const FourierSeries& motion) {
    const Eigen::Index r = motion.rows();
    return largest_over_period(Eigen::MatrixXd::Identity(r, r), motion).value;
  };
  options.largest_amplitude = 1e300;
  return options;
}

// The state of the Duffing oscillator under f cos(omega t) after one period from t = 0, with its
// derivatives by the start: columns of (x, v) and of the 2 x 2 monodromy.
struct Shot {
  Eigen::Vector2d end;
  Eigen::Matrix2d monodromy;
};
inline Shot shoot(const Duffing& d, double f, double omega, const Eigen::Vector2d& start,
                  int steps = 4000) {
  using Rows = Eigen::Matrix<double, 2, 3>;
  const auto slope = [&](double t, const Rows& y) {
    const double k = d.omega * d.omega + 3.0 * d.gamma * y(0, 0) * y(0, 0);
    Rows out;
    out.row(0) = y.row(1);
    out.row(1) = -2.0 * d.zeta * d.omega * y.row(1) - k * y.row(0);
    out(1, 0) += 2.0 * d.gamma * std::pow(y(0, 0), 3) + f * std::cos(omega * t);
    return out;
  };
  Rows y;
  y.col(0) = start;
  y.rightCols<2>().setIdentity();
  const double h = 2.0 * std::numbers::pi / omega / steps;
  for (int n = 0; n < steps; ++n) {
    const double t = n * h;
    const Rows k1 = slope(t, y), k2 = slope(t + 0.5 * h, y + 0.5 * h * k1);
    const Rows k3 = slope(t + 0.5 * h, y + 0.5 * h * k2), k4 = slope(t + h, y + h * k3);
    y += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
  }
  return {y.col(0), y.rightCols<2>()};
}

}  // namespace tremolo
