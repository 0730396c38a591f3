#include "runtime/response/equations/motion_equations.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "runtime/math/dense/dense_lu.h"

namespace tremolo {

double vibration_size(const FourierSeries& motion, const Eigen::VectorXd& rest) {
  constexpr double kSeen = 1e-6;
  FourierSeries vibration = motion;
  vibration.col(0) -= rest;
  return std::max(vibration.norm(), kSeen * rest.norm());
}

MotionEquations::MotionEquations(const VibratingSystem& system, Eigen::Index harmonics,
                                 bool with_extra, double least_size, double omega_scale)
    : system_(system),
      balance_(std::make_unique<HarmonicBalance>(system, harmonics)),
      with_extra_(with_extra),
      least_size_(least_size),
      omega_scale_(omega_scale),
      rest_(Eigen::VectorXd::Zero(system.size())) {}

void MotionEquations::set_rest(const Eigen::VectorXd& rest) {
  rest_ = rest;
}

Eigen::VectorXd MotionEquations::weights(const Eigen::VectorXd& y) const {
  Eigen::VectorXd result = Eigen::VectorXd::Constant(y.size(), 1.0 / size_of(y));
  result.tail(with_extra_ ? 2 : 1).setConstant(1.0 / omega_scale_);
  return result;
}

double MotionEquations::size_of(const Eigen::VectorXd& y) const {
  return std::max(least_size_, vibration_size(motion(y), rest_));
}

double MotionEquations::coarseness(const Eigen::VectorXd& y) const {
  if (rest_.isZero(0.0)) return 1.0;
  return std::max(1.0, y.head(balance_->unknowns()).norm() / size_of(y));
}

void MotionEquations::set_harmonics(Eigen::Index harmonics) {
  balance_ = std::make_unique<HarmonicBalance>(system_, harmonics);
}

FourierSeries MotionEquations::motion(const Eigen::VectorXd& y) const {
  return y.head(balance_->unknowns()).reshaped(system_.size(), 2 * harmonics() + 1);
}

double MotionEquations::load_factor(const Eigen::VectorXd&) const {
  return 1.0;
}

Eigen::VectorXd MotionEquations::unknowns_of(const FourierSeries& motion, double omega,
                                             double extra) const {
  Eigen::VectorXd y = Eigen::VectorXd::Zero(unknowns());
  if (with_extra_) y[y.size() - 2] = extra;
  y.head(balance_->unknowns()) = with_harmonics(motion, harmonics()).reshaped();
  y[y.size() - 1] = omega;
  return y;
}

ForcedEquations::ForcedEquations(const VibratingSystem& system, const FourierSeries& force,
                                 Eigen::Index harmonics, double least_size, double omega_scale)
    : MotionEquations(system, harmonics, false, least_size, omega_scale),
      force_(force),
      resized_force_(with_harmonics(force, harmonics)) {}

void ForcedEquations::set_harmonics(Eigen::Index harmonics) {
  MotionEquations::set_harmonics(harmonics);
  resized_force_ = with_harmonics(force_, harmonics);
}

void ForcedEquations::residual(const Eigen::VectorXd& y, Eigen::VectorXd& out) {
  FourierSeries residual;
  balance().residual(motion(y), omega(y), 0.0, resized_force_, residual);
  out = residual.reshaped();
}

void ForcedEquations::jacobian(const Eigen::VectorXd& y, Eigen::MatrixXd& out) {
  balance().jacobian(motion(y), omega(y), 0.0, out, out.col(out.cols() - 1), nullptr);
}

LoadEquations::LoadEquations(const VibratingSystem& system, const FourierSeries& force,
                             Eigen::Index harmonics, double omega, double least_size,
                             double omega_scale)
    : MotionEquations(system, harmonics, true, least_size, omega_scale),
      force_(force),
      omega_(omega),
      omega_scale_(omega_scale) {
  LoadEquations::set_harmonics(harmonics);
}

void LoadEquations::set_harmonics(Eigen::Index harmonics) {
  MotionEquations::set_harmonics(harmonics);
  constant_ = with_harmonics(force_.col(0), harmonics);
  varying_ = with_harmonics(force_, harmonics);
  varying_.col(0).setZero();
}

Eigen::VectorXd LoadEquations::weights(const Eigen::VectorXd& y) const {
  Eigen::VectorXd result = MotionEquations::weights(y);
  result[y.size() - 2] = 1.0;
  return result;
}

void LoadEquations::residual(const Eigen::VectorXd& y, Eigen::VectorXd& out) {
  const Eigen::Index n = balance().unknowns();
  FourierSeries residual;
  balance().residual(motion(y), omega(y), 0.0, constant_ + extra(y) * varying_, residual);
  out.resize(n + 1);
  out.head(n) = residual.reshaped();
  out[n] = (omega(y) - omega_) / omega_scale_;
}

void LoadEquations::jacobian(const Eigen::VectorXd& y, Eigen::MatrixXd& out) {
  const Eigen::Index n = balance().unknowns();
  balance().jacobian(motion(y), omega(y), 0.0, out, out.col(n + 1), nullptr);
  out.col(n).head(n) = -varying_.reshaped();
  out.row(n).setZero();
  out(n, n + 1) = 1.0 / omega_scale_;
}

FreeEquations::FreeEquations(const VibratingSystem& system, Eigen::VectorXd constant,
                             Eigen::Index harmonics, double least_size, double omega_scale)
    : MotionEquations(system, harmonics, true, least_size, omega_scale),
      constant_(std::move(constant)) {
  FreeEquations::set_harmonics(harmonics);
}

void FreeEquations::set_harmonics(Eigen::Index harmonics) {
  MotionEquations::set_harmonics(harmonics);
  force_ = with_harmonics(constant_, harmonics);
  phase_row_ = Eigen::VectorXd::Zero(balance().unknowns());
}

void FreeEquations::refer_to(const Eigen::VectorXd& y) {
  const FourierSeries reference = motion(y);
  FourierSeries row = FourierSeries::Zero(reference.rows(), reference.cols());
  for (Eigen::Index k = 1; k <= harmonics(); ++k) {
    row.col(sine_column(k)) = static_cast<double>(k) * reference.col(cosine_column(k));
    row.col(cosine_column(k)) = -static_cast<double>(k) * reference.col(sine_column(k));
  }
  phase_row_ = row.reshaped();
}

void FreeEquations::residual(const Eigen::VectorXd& y, Eigen::VectorXd& out) {
  const Eigen::Index n = balance().unknowns();
  FourierSeries residual;
  balance().residual(motion(y), omega(y), y[n], force_, residual);
  out.resize(n + 1);
  out.head(n) = residual.reshaped();
  out[n] = phase_row_.dot(y.head(n));
}

void FreeEquations::jacobian(const Eigen::VectorXd& y, Eigen::MatrixXd& out) {
  const Eigen::Index n = balance().unknowns();
  Eigen::VectorXd by_xi;
  balance().jacobian(motion(y), omega(y), y[n], out, out.col(n + 1), &by_xi);
  out.col(n).head(n) = by_xi;
  out.row(n).setZero();
  out.row(n).head(n) = phase_row_.transpose();
}

QuadratureEquations::QuadratureEquations(const VibratingSystem& system, Eigen::VectorXd constant,
                                         Eigen::VectorXd shape, Eigen::Index harmonics,
                                         double least_size, double omega_scale)
    : MotionEquations(system, harmonics, true, least_size, omega_scale),
      constant_(std::move(constant)),
      shape_(std::move(shape)) {}

// The factor follows from the motion: it adds little to the length.
constexpr double kFactorWeight = 0.1;

Eigen::VectorXd QuadratureEquations::weights(const Eigen::VectorXd& y) const {
  Eigen::VectorXd result = MotionEquations::weights(y);
  result[y.size() - 2] = kFactorWeight / std::max(std::abs(extra(y)), 1e-300);
  return result;
}

void QuadratureEquations::residual(const Eigen::VectorXd& y, Eigen::VectorXd& out) {
  const Eigen::Index n = balance().unknowns(), r = shape_.size();
  FourierSeries force = with_harmonics(constant_, harmonics()), residual;
  force.col(cosine_column(1)) = extra(y) * shape_;
  balance().residual(motion(y), omega(y), 0.0, force, residual);
  out.resize(n + 1);
  out.head(n) = residual.reshaped();
  out[n] = shape_.dot(y.segment(r * cosine_column(1), r));
}

void QuadratureEquations::jacobian(const Eigen::VectorXd& y, Eigen::MatrixXd& out) {
  const Eigen::Index n = balance().unknowns(), r = shape_.size();
  balance().jacobian(motion(y), omega(y), 0.0, out, out.col(n + 1), nullptr);
  out.col(n).setZero();
  out.col(n).segment(r * cosine_column(1), r) = -shape_;
  out.row(n).setZero();
  out.row(n).segment(r * cosine_column(1), r) = shape_.transpose();
}

FoldEquations::FoldEquations(const VibratingSystem& system, const FourierSeries& force,
                             Eigen::Index harmonics, double least_size, double omega_scale)
    : MotionEquations(system, harmonics, true, least_size, omega_scale), force_(force) {
  FoldEquations::set_harmonics(harmonics);
}

void FoldEquations::set_harmonics(Eigen::Index harmonics) {
  MotionEquations::set_harmonics(harmonics);
  constant_ = with_harmonics(force_.col(0), harmonics);
  varying_ = with_harmonics(force_, harmonics);
  varying_.col(0).setZero();
  const Eigen::Index n = balance().unknowns();
  b_ = c_ = Eigen::VectorXd::Ones(n).normalized();
}

Eigen::VectorXd FoldEquations::weights(const Eigen::VectorXd& y) const {
  Eigen::VectorXd result = MotionEquations::weights(y);
  result[y.size() - 2] = kFactorWeight / std::max(std::abs(extra(y)), 1e-300);
  return result;
}

Eigen::MatrixXd FoldEquations::by_motion(const FourierSeries& motion, double omega,
                                         Eigen::VectorXd& by_omega) {
  const Eigen::Index n = balance().unknowns();
  Eigen::MatrixXd J(n, n);
  by_omega.resize(n);
  balance().jacobian(motion, omega, 0.0, J, by_omega, nullptr);
  return J;
}

FoldEquations::NullVectors FoldEquations::null_vectors(const Eigen::MatrixXd& J) const {
  const Eigen::Index n = J.rows();
  Eigen::MatrixXd matrix(n + 1, n + 1);
  matrix << J, b_, c_.transpose(), 0.0;
  const DenseLu factor(matrix);
  const Eigen::VectorXd unit = Eigen::VectorXd::Unit(n + 1, n);
  const Eigen::VectorXd right = factor.solve(unit), left = factor.solve_transposed(unit);
  return {right.head(n), left.head(n), right[n]};
}

void FoldEquations::refer_to(const Eigen::VectorXd& y) {
  Eigen::VectorXd by_omega;
  const Eigen::MatrixXd J = by_motion(motion(y), omega(y), by_omega);
  // Two passes: the first borders may be far from the null vectors.
  for (int i = 0; i < 2; ++i) {
    const NullVectors null = null_vectors(J);
    c_ = null.v.normalized();
    b_ = null.w.normalized();
  }
}

void FoldEquations::residual(const Eigen::VectorXd& y, Eigen::VectorXd& out) {
  const Eigen::Index n = balance().unknowns();
  FourierSeries residual;
  balance().residual(motion(y), omega(y), 0.0, constant_ + extra(y) * varying_, residual);
  Eigen::VectorXd by_omega;
  const NullVectors null = null_vectors(by_motion(motion(y), omega(y), by_omega));
  out.resize(n + 1);
  out.head(n) = residual.reshaped();
  out[n] = null.h;
}

void FoldEquations::jacobian(const Eigen::VectorXd& y, Eigen::MatrixXd& out) {
  const Eigen::Index n = balance().unknowns();
  const FourierSeries at = motion(y);
  const double speed = omega(y);
  Eigen::VectorXd by_omega, unused;
  const Eigen::MatrixXd J = by_motion(at, speed, by_omega);
  const NullVectors null = null_vectors(J);
  out.topLeftCorner(n, n) = J;
  out.col(n).head(n) = -varying_.reshaped();
  out.col(n + 1).head(n) = by_omega;
  // Steps as large as the unknowns: the differences are exact, and rounding is least.
  const double e = at.norm() / null.v.norm(), d = 0.1 * speed;
  const FourierSeries along = e * null.v.reshaped(at.rows(), at.cols());
  const Eigen::MatrixXd by_v =
      by_motion(at + along, speed, unused) - by_motion(at - along, speed, unused);
  const Eigen::MatrixXd by_speed =
      by_motion(at, speed + d, unused) - by_motion(at, speed - d, unused);
  out.row(n).head(n) = -(by_v.transpose() * null.w).transpose() / (2.0 * e);
  out(n, n) = 0.0;
  out(n, n + 1) = -null.w.dot(by_speed * null.v) / (2.0 * d);
}

}  // namespace tremolo
