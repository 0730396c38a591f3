// The largest deviation of an orbit from its energy balance.
#pragma once

namespace tremolo {

// Watches H over a run and says how far it left what it should be (docs/reference.md,
// `energy_drift_max`). observe() takes, once before the first step and once after each: H, the work
// of the loads and the dissipated energy, both since the start, and whether a load still acts on a
// coming step.
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
