// How far an orbit leaves its energy balance: `energy_drift_max` of docs/architecture.md.
#pragma once

#include "precompute/reference/time_integration.h"

namespace tremolo {

// observe() takes the motion once before the first step and once after each, and whether a load
// still acts on a coming step.
class EnergyDrift {
 public:
  void observe(const Motion& motion, bool load_to_come);
  double worst() const;
  double reference() const { return reference_energy_; }  // H when the loads had ended, else now, J

 private:
  bool started_ = false, free_ = false;
  double start_ = 0, highest_ = 0, loaded_error_ = 0;
  double reference_ = 0, reference_energy_ = 0, free_error_ = 0;
};

}  // namespace tremolo
