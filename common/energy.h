// The energy of a reduced body, the integrals of its mass, and the drift of an orbit from its
// balance.
#pragma once

#include <cmath>
#include <vector>

#include <Eigen/Core>

namespace tremolo {

// V(q) = 1/2 q^T diag(lambda) q + C[q,q,q] + Q[q,q,q,q] (docs/theory.md, "Reduced energy"), summed
// monomial by monomial from the unique entries. Slow, and independent of the runtime's kernels: a
// reference for tests.

struct EnergyAndForce {
  double energy = 0.0;    // V, J
  Eigen::VectorXd force;  // grad V, r
};

// lambda: r, (rad/s)^2. cubic, quartic: unique entries (common/packed_index.h) of r coordinates,
// both empty for a linear model. q: r.
EnergyAndForce reduced_energy(const Eigen::VectorXd& lambda, const std::vector<double>& cubic,
                              const std::vector<double>& quartic, const Eigen::VectorXd& q);

// Integrals of the mass over the rest shape X and the basis fields phi_i = U_i, by which a body in
// a moving frame is coupled to its frame (docs/theory.md, section "A body in a world").

// From the mass matrix with the rows of fixed vertices; X is measured from the mesh's origin.
// A "3 k + l" row holds the entry (k, l) of a 3 x 3 matrix.
struct InertiaIntegrals {
  double mass = 0;                // int rho, kg
  Eigen::Vector3d first_moment;   // int rho X, kg m
  Eigen::Matrix3d second_moment;  // int rho X X^T, kg m^2
  // 12 x r: rows 0 to 2 are s_i = int rho phi_i, kg^1/2; the next nine are
  // A_i = int rho X phi_i^T, kg^1/2 m.
  Eigen::MatrixXd linear;
  // 9 x pair_count(r), column pair_index(i, j) with i <= j: B_ij = int rho phi_i phi_j^T.
  // B_ji is its transpose, and tr B_ij is 1 for i = j, else 0.
  Eigen::MatrixXd B;
};

// The larger of two numbers; NaN if one of them is, which std::max() may hide.
inline double larger(double a, double b) {
  return std::isnan(a) || a >= b ? a : b;
}

// The largest deviation of an orbit from its energy balance. Measures the error of H over a run
// (docs/reference.md, `energy_drift_max`). Call observe() before the first step and after each,
// with H, the work of the loads and the dissipated energy, both since the start, and whether a load
// can still act in a later step.
class DriftMeter {
 public:
  void observe(double energy, double work, double dissipated, bool load_to_come);

  // After the loads have ended: max |H - H_ref + dissipated since| / H_ref, H_ref = H at that
  // time (without damping: |H - H_ref| / H_ref). While a load lasts:
  // max |H - H_start - work + dissipated| / max H. Zero while there is no energy at all.
  double worst() const;
  // H when the loads had ended; until then, H now. J.
  double reference() const { return reference_energy_; }

 private:
  bool started_ = false;
  bool free_ = false;
  double start_energy_ = 0.0;
  double highest_ = 0.0;
  double loaded_error_ = 0.0;
  double reference_ = 0.0;  // H + dissipated when the loads ended
  double reference_energy_ = 0.0;
  double free_error_ = 0.0;
};

}  // namespace tremolo
