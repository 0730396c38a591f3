// Harmonic balance as the equations of a curve (curve.h): of a forced response and of a backbone.
// The unknowns are the coefficients of the motion, possibly one more number (the artificial damping
// xi, or the load's factor), and omega.
#pragma once

#include <memory>

#include "runtime/response/equations/curve.h"
#include "runtime/response/equations/harmonic_balance.h"

namespace tremolo {

// The norm of a motion without its static state (r): the size of the vibration. At least 1e-6 of
// the static state, below which rounding is all.
double vibration_size(const FourierSeries& motion, const Eigen::VectorXd& rest);

class MotionEquations : public CurveEquations {
 public:
  // with_extra: there is one more unknown than the motion and omega. least_size: the size of a
  // vibration below which lengths are not relative to it.
  MotionEquations(const VibratingSystem& system, Eigen::Index harmonics, bool with_extra,
                  double least_size, double omega_scale);

  Eigen::Index unknowns() const override { return balance_->unknowns() + (with_extra_ ? 2 : 1); }
  Eigen::VectorXd weights(const Eigen::VectorXd& y) const override;

  // The whole motion relative to the vibration: rounding is that of the whole.
  double coarseness(const Eigen::VectorXd& y) const override;

  // The static state about which the body vibrates, r: lengths are relative to the motion's
  // distance from it. Without it, zero.
  void set_rest(const Eigen::VectorXd& rest);

  Eigen::Index harmonics() const { return balance_->harmonics(); }
  virtual void set_harmonics(Eigen::Index harmonics);

  FourierSeries motion(const Eigen::VectorXd& y) const;
  // HarmonicBalance::missing_share.
  double missing_share(const Eigen::VectorXd& y) {
    return balance_->missing_share(motion(y), omega(y));
  }
  double omega(const Eigen::VectorXd& y) const { return y[y.size() - 1]; }
  // HarmonicBalance::strain_share of the two highest harmonics.
  double last_strain_share(const Eigen::VectorXd& y) const {
    return balance_->strain_share(motion(y), harmonics() - 1);
  }
  double extra(const Eigen::VectorXd& y) const { return with_extra_ ? y[y.size() - 2] : 0.0; }
  // The factor of the load at y.
  virtual double load_factor(const Eigen::VectorXd& y) const;
  // The phase of a motion is only that of the reference: shifted in time it is a solution too.
  virtual bool has_free_phase() const { return false; }
  // The sign of the determinant of the residual's derivatives by the motion alone. It is negative
  // where an odd number of real multipliers is above 1, and changes at folds and branch points. 0
  // for equations that are not those of a motion under a given force.
  virtual int motion_sign(const CurveState& state) const { return (void)state, 0; }
  // Unknowns of a motion with the present number of harmonics.
  Eigen::VectorXd unknowns_of(const FourierSeries& motion, double omega, double extra = 0.0) const;

 protected:
  HarmonicBalance& balance() { return *balance_; }
  const VibratingSystem& system() const { return system_; }

 private:
  double size_of(const Eigen::VectorXd& y) const;

  const VibratingSystem& system_;
  std::unique_ptr<HarmonicBalance> balance_;
  bool with_extra_;
  double least_size_, omega_scale_;
  Eigen::VectorXd rest_;
};

// g = the residual under a periodic force.
class ForcedEquations : public MotionEquations {
 public:
  // force: r x (2K + 1), kept by reference.
  ForcedEquations(const VibratingSystem& system, const FourierSeries& force, Eigen::Index harmonics,
                  double least_size, double omega_scale);

  void set_harmonics(Eigen::Index harmonics) override;
  // By Cramer's rule the tangent's last entry is this determinant over that of the state's matrix.
  int motion_sign(const CurveState& state) const override {
    return state.omega_slope() > 0.0 ? state.sign : -state.sign;
  }
  void residual(const Eigen::VectorXd& y, Eigen::VectorXd& out) override;
  void jacobian(const Eigen::VectorXd& y, Eigen::MatrixXd& out) override;

 private:
  const FourierSeries& force_;
  FourierSeries resized_force_;
};

// g = the residual under factor . force, and the condition that omega is the given one. The factor
// is an unknown, that of the force's constant part is 1.
class LoadEquations : public MotionEquations {
 public:
  // force: r x (2K + 1), kept by reference. omega: rad/s.
  LoadEquations(const VibratingSystem& system, const FourierSeries& force, Eigen::Index harmonics,
                double omega, double least_size, double omega_scale);

  void set_harmonics(Eigen::Index harmonics) override;
  // The factor itself is its length.
  Eigen::VectorXd weights(const Eigen::VectorXd& y) const override;
  double load_factor(const Eigen::VectorXd& y) const override { return extra(y); }
  void residual(const Eigen::VectorXd& y, Eigen::VectorXd& out) override;
  void jacobian(const Eigen::VectorXd& y, Eigen::MatrixXd& out) override;

 private:
  const FourierSeries& force_;
  double omega_, omega_scale_;
  FourierSeries constant_, varying_;  // the force's parts with the present number of harmonics
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
  bool has_free_phase() const override { return true; }
  void residual(const Eigen::VectorXd& y, Eigen::VectorXd& out) override;
  void jacobian(const Eigen::VectorXd& y, Eigen::MatrixXd& out) override;

 private:
  Eigen::VectorXd constant_;
  FourierSeries force_;
  Eigen::VectorXd phase_row_;  // of the coefficients
};

// g = the residual under factor . cos(omega t) shape, and the condition that the displacement along
// the shape is in quadrature: shape . a_1 = 0. Such a force balances the damping at each time as
// far as one harmonic can (phase resonance). The factor is an unknown.
class QuadratureEquations : public MotionEquations {
 public:
  // constant, shape: r.
  QuadratureEquations(const VibratingSystem& system, Eigen::VectorXd constant,
                      Eigen::VectorXd shape, Eigen::Index harmonics, double least_size,
                      double omega_scale);

  Eigen::VectorXd weights(const Eigen::VectorXd& y) const override;
  double load_factor(const Eigen::VectorXd& y) const override { return extra(y); }
  void residual(const Eigen::VectorXd& y, Eigen::VectorXd& out) override;
  void jacobian(const Eigen::VectorXd& y, Eigen::MatrixXd& out) override;

 private:
  Eigen::VectorXd constant_, shape_;
};

// The folds of response curves over the load's factor: g = the residual under factor . force, and
// h = 0, where h and the vectors v, w of a fold solve
//
//     [J  b] [v]   [0]        [J^T  c] [w]   [0]
//     [c' 0] [h] = [1],       [b'   0] [h] = [1]
//
// with the Jacobian J of g by the motion and fixed b, c. Then dh = -w . dJ v. J is quadratic in
// the motion and in omega, so that central differences of it are exact.
class FoldEquations : public MotionEquations {
 public:
  // force: r x (2K + 1), kept by reference; its constant part has no factor.
  FoldEquations(const VibratingSystem& system, const FourierSeries& force, Eigen::Index harmonics,
                double least_size, double omega_scale);

  void set_harmonics(Eigen::Index harmonics) override;
  // Sets b and c to the present null vectors.
  void refer_to(const Eigen::VectorXd& y) override;
  Eigen::VectorXd weights(const Eigen::VectorXd& y) const override;
  double load_factor(const Eigen::VectorXd& y) const override { return extra(y); }
  void residual(const Eigen::VectorXd& y, Eigen::VectorXd& out) override;
  void jacobian(const Eigen::VectorXd& y, Eigen::MatrixXd& out) override;

 private:
  struct NullVectors {
    Eigen::VectorXd v, w;
    double h = 0.0;
  };
  NullVectors null_vectors(const Eigen::MatrixXd& J) const;
  Eigen::MatrixXd by_motion(const FourierSeries& motion, double omega, Eigen::VectorXd& by_omega);

  const FourierSeries& force_;
  FourierSeries constant_, varying_;  // the force's parts with the present number of harmonics
  Eigen::VectorXd b_, c_;
};

}  // namespace tremolo
