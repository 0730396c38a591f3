#include "common/energy_drift.h"

#include <algorithm>
#include <cmath>

namespace tremolo {
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
