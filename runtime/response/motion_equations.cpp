#include "runtime/response/motion_equations.h"

#include <algorithm>
#include <utility>

namespace tremolo {

MotionEquations::MotionEquations(const VibratingSystem& system, Eigen::Index harmonics,
                                 bool with_xi, double least_size, double omega_scale)
    : system_(system),
      balance_(std::make_unique<HarmonicBalance>(system, harmonics)),
      with_xi_(with_xi),
      least_size_(least_size),
      omega_scale_(omega_scale) {}

Eigen::VectorXd MotionEquations::weights(const Eigen::VectorXd& y) const {
  const double size = std::max(least_size_, y.head(balance_->unknowns()).norm());
  Eigen::VectorXd result = Eigen::VectorXd::Constant(y.size(), 1.0 / size);
  result.tail(with_xi_ ? 2 : 1).setConstant(1.0 / omega_scale_);
  return result;
}

void MotionEquations::set_harmonics(Eigen::Index harmonics) {
  balance_ = std::make_unique<HarmonicBalance>(system_, harmonics);
}

FourierSeries MotionEquations::motion(const Eigen::VectorXd& y) const {
  return y.head(balance_->unknowns()).reshaped(system_.size(), 2 * harmonics() + 1);
}

Eigen::VectorXd MotionEquations::unknowns_of(const FourierSeries& motion, double omega) const {
  Eigen::VectorXd y = Eigen::VectorXd::Zero(unknowns());
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

}  // namespace tremolo
