#include "precompute/reference/energy_drift.h"

#include <algorithm>
#include <cmath>

namespace tremolo {

void EnergyDrift::observe(const Motion& motion, bool load_to_come) {
  const double energy = motion.total();
  if (!started_) start_ = energy;
  started_ = true;
  highest_ = std::max(highest_, std::abs(energy));
  if (free_) {
    free_error_ = std::max(free_error_, std::abs(energy + motion.dissipated - reference_));
    return;
  }
  loaded_error_ =
      std::max(loaded_error_, std::abs(energy - start_ - motion.work + motion.dissipated));
  reference_energy_ = energy;
  reference_ = energy + motion.dissipated;
  free_ = !load_to_come;
}

double EnergyDrift::worst() const {
  const double error = free_ ? free_error_ : loaded_error_;
  return error == 0 ? 0.0 : error / (free_ ? reference_energy_ : highest_);
}

}  // namespace tremolo
