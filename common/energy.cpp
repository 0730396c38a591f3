#include "common/energy.h"

#include <algorithm>
#include <cmath>

#include "common/packed_index.h"

namespace tremolo {

EnergyAndForce reduced_energy(const Eigen::VectorXd& lambda, const std::vector<double>& cubic,
                              const std::vector<double>& quartic, const Eigen::VectorXd& q) {
  EnergyAndForce sum{0.5 * q.dot(lambda.cwiseProduct(q)), lambda.cwiseProduct(q)};
  if (quartic.empty()) return sum;
  Eigen::VectorXd& force = sum.force;
  const std::size_t r = q.size();
  // d/dq of one monomial c q_i q_j q_k (q_l), one factor at a time; repeated indices add up.
  for (std::size_t k = 0; k < r; ++k)
    for (std::size_t j = 0; j <= k; ++j)
      for (std::size_t i = 0; i <= j; ++i) {
        const double c = cubic[triple_index(i, j, k)] * orderings(i, j, k);
        sum.energy += c * q[i] * q[j] * q[k];
        force[i] += c * q[j] * q[k];
        force[j] += c * q[i] * q[k];
        force[k] += c * q[i] * q[j];
        for (std::size_t l = k; l < r; ++l) {
          const double d = quartic[quad_index(i, j, k, l)] * orderings(i, j, k, l);
          sum.energy += d * q[i] * q[j] * q[k] * q[l];
          force[i] += d * q[j] * q[k] * q[l];
          force[j] += d * q[i] * q[k] * q[l];
          force[k] += d * q[i] * q[j] * q[l];
          force[l] += d * q[i] * q[j] * q[k];
        }
      }
  return sum;
}

namespace {

// The larger of the two; once one is not a number, so it stays.
void keep_worst(double& worst, double error) {
  if (!std::isnan(worst) && !(error <= worst)) worst = error;
}

}  // namespace

void DriftMeter::observe(double energy, double work, double dissipated, bool load_to_come) {
  if (!started_) {
    started_ = true;
    start_energy_ = energy;
  }
  highest_ = std::max(highest_, std::abs(energy));
  if (!free_) {
    keep_worst(loaded_error_, std::abs(energy - start_energy_ - work + dissipated));
    reference_energy_ = energy;
    if (load_to_come) return;
    free_ = true;
    reference_ = energy + dissipated;
    return;
  }
  keep_worst(free_error_, std::abs(energy + dissipated - reference_));
}

double DriftMeter::worst() const {
  const double error = free_ ? free_error_ : loaded_error_;
  const double scale = free_ ? reference_energy_ : highest_;
  if (error == 0.0) return 0.0;
  return error / scale;
}

}  // namespace tremolo
