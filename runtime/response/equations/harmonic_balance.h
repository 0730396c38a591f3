// Harmonic balance with alternation between time and frequency.
//
// For q(t) = c_0 + sum a_k cos k theta + b_k sin k theta, theta = omega t, the residual in the
// harmonics 0..H is
//
//     c_0:  F_0 - f_0
//     a_k:  F_ak - k^2 omega^2 a_k + k omega (D + xi) b_k - f_ak
//     b_k:  F_bk - k^2 omega^2 b_k - k omega (D + xi) a_k - f_bk,
//
// F the Fourier coefficients of grad V(q) + beta M(q) q'. These forces are cubic in the motion, so
// that they have 3H harmonics, of which N samples fold harmonic 3H onto N - 3H. With N >= 4H + 2
// none is folded onto the first H, and the projection is exact. With Gamma (N x (2H + 1)) from
// coefficients to samples and P = N Gamma^T / 2 (row 0: /N) back, the Jacobian of F is
// P blockdiag(K(q_n)) Gamma. xi is an artificial damping, zero except on the way to a backbone.
#pragma once

#include <Eigen/Core>

#include "runtime/math/dense/dense_lu.h"
#include "runtime/response/equations/fourier_series.h"
#include "runtime/response/equations/vibrating_system.h"

namespace tremolo {

class HarmonicBalance {
 public:
  // The system must outlive the object. harmonics: H >= 1.
  HarmonicBalance(const VibratingSystem& system, Eigen::Index harmonics);

  const VibratingSystem& system() const { return system_; }
  Eigen::Index harmonics() const { return harmonics_; }
  Eigen::Index unknowns() const { return size_ * columns_; }  // r (2H + 1)

  // out: r x (2H + 1). force: the same shape.
  void residual(const FourierSeries& motion, double omega, double xi, const FourierSeries& force,
                FourierSeries& out);

  // An estimate of the harmonics H + 1 to 2H that the motion leaves out: the linear response to
  // their forces, as the root of its strain energy relative to that of the motion. Energy, since
  // small displacements of stiff coordinates decide on the frequency.
  double missing_share(const FourierSeries& motion, double omega);
  // The same measure of the motion's own harmonics from `first` to H.
  double strain_share(const FourierSeries& motion, Eigen::Index first) const;

  // Sets the leading block of `out`: unknowns() x unknowns(), unknowns in the storage order of a
  // FourierSeries. by_omega, by_xi: derivatives of the residual, unknowns(); by_xi may be null.
  void jacobian(const FourierSeries& motion, double omega, double xi,
                Eigen::Ref<Eigen::MatrixXd> out, Eigen::Ref<Eigen::VectorXd> by_omega,
                Eigen::VectorXd* by_xi);

 private:
  void sample(const FourierSeries& motion, double omega);
  void sample_forces();
  void sample_tangents();
  // out += factor P blockdiag(samples) Gamma, with `slope` Gamma's derivative by theta.
  void add_blocks(const PaddedMatrix& samples, bool slope, double factor,
                  Eigen::Ref<Eigen::MatrixXd> out);

  const VibratingSystem& system_;
  Eigen::Index size_;                 // r
  Eigen::Index harmonics_;            // H
  Eigen::Index columns_;              // 2H + 1
  Eigen::Index samples_;              // N
  Eigen::MatrixXd to_samples_;        // Gamma^T, (2H + 1) x N
  Eigen::MatrixXd slope_to_samples_;  // of the derivative by theta
  Eigen::MatrixXd to_coefficients_;   // P^T, N x (2H + 1)
  PaddedMatrix spectrum_weights_;     // N x (4H + 1), with a minus sign for subtract_product()
  Eigen::MatrixXd q_, v_;             // samples of the motion and its derivative, r x N
  Eigen::MatrixXd forces_;            // of grad V, r x N
  Eigen::MatrixXd damping_forces_;    // of beta M(q) q', r x N
  PaddedMatrix tangents_, by_rate_;   // r^2 x N
  PaddedMatrix spectrum_;             // r^2 x (4H + 1)
  PotentialWorkspace workspace_;
  Evaluation evaluation_;
  StrainRateForce strain_rates_;
};

}  // namespace tremolo
