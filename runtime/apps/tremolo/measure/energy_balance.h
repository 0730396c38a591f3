// The error of the energy balance of a body or a cloth over a run.
#pragma once

#include <algorithm>
#include <cmath>

#include "common/energy.h"

namespace tremolo {

struct EnergyBalance {
  double energy_max = 0.0;     // J, largest energy
  double remainder_max = 0.0;  // J, largest |change of the energy - all energy exchanged|
  double turnover_max = 0.0;   // J, largest sum of |energy exchanged| over all causes

  // After each step; J.
  void observe(double energy, double remainder, double turnover) {
    energy_max = larger(energy_max, energy);
    remainder_max = larger(remainder_max, std::abs(remainder));
    turnover_max = larger(turnover_max, turnover);
  }
  double most() const { return std::max(energy_max, turnover_max); }
  // Relative to most(); 0 if nothing ever moved.
  double error() const { return most() > 0.0 ? remainder_max / most() : 0.0; }
};

}  // namespace tremolo
