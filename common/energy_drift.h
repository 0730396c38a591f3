// The largest deviation of an orbit from its energy balance.
#pragma once

namespace tremolo {

// Measures the error of H over a run (docs/reference.md, `energy_drift_max`). Call observe() before
// the first step and after each, with H, the work of the loads and the dissipated energy, both
// since the start, and whether a load can still act in a later step.
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
