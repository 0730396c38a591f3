// Harmonic balance as the equations of a curve (curve.h): of a forced response and of a backbone.
// The unknowns are the coefficients of the motion, possibly the artificial damping xi, and omega.
#pragma once

#include <memory>

#include "runtime/response/curve.h"
#include "runtime/response/harmonic_balance.h"

namespace tremolo {

class MotionEquations : public CurveEquations {
 public:
  // with_xi: xi is an unknown. least_size: the size of a motion below which lengths are not
  // relative to it.
  MotionEquations(const VibratingSystem& system, Eigen::Index harmonics, bool with_xi,
                  double least_size, double omega_scale);

  Eigen::Index unknowns() const override { return balance_->unknowns() + (with_xi_ ? 2 : 1); }
  Eigen::VectorXd weights(const Eigen::VectorXd& y) const override;

  Eigen::Index harmonics() const { return balance_->harmonics(); }
  virtual void set_harmonics(Eigen::Index harmonics);

  FourierSeries motion(const Eigen::VectorXd& y) const;
  double omega(const Eigen::VectorXd& y) const { return y[y.size() - 1]; }
  // Unknowns of a motion with the present number of harmonics; xi is zero.
  Eigen::VectorXd unknowns_of(const FourierSeries& motion, double omega) const;

 protected:
  HarmonicBalance& balance() { return *balance_; }
  bool with_xi() const { return with_xi_; }

 private:
  const VibratingSystem& system_;
  std::unique_ptr<HarmonicBalance> balance_;
  bool with_xi_;
  double least_size_, omega_scale_;
};

// g = the residual under a periodic force.
class ForcedEquations : public MotionEquations {
 public:
  // force: r x (2K + 1), kept by reference.
  ForcedEquations(const VibratingSystem& system, const FourierSeries& force, Eigen::Index harmonics,
                  double least_size, double omega_scale);

  void set_harmonics(Eigen::Index harmonics) override;
  void residual(const Eigen::VectorXd& y, Eigen::VectorXd& out) override;
  void jacobian(const Eigen::VectorXd& y, Eigen::MatrixXd& out) override;

 private:
  const FourierSeries& force_;
  FourierSeries resized_force_;
};

// g = the residual without damping and force but a constant one, and the condition that the phase
// is that of the reference: sum_k k (a_k' . b_k - b_k' . a_k) = 0 for the reference's a', b'. xi
// makes the equations as many as the unknowns; it is zero at a solution, since nothing else takes
// energy.
class FreeEquations : public MotionEquations {
 public:
  // The system must have no damping. constant: r.
  FreeEquations(const VibratingSystem& system, Eigen::VectorXd constant, Eigen::Index harmonics,
                double least_size, double omega_scale);

  void set_harmonics(Eigen::Index harmonics) override;
  void refer_to(const Eigen::VectorXd& y) override;
  void residual(const Eigen::VectorXd& y, Eigen::VectorXd& out) override;
  void jacobian(const Eigen::VectorXd& y, Eigen::MatrixXd& out) override;

 private:
  Eigen::VectorXd constant_;
  FourierSeries force_;
  Eigen::VectorXd phase_row_;  // of the coefficients
};

}  // namespace tremolo
