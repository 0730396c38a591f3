// When an orbit has left its energy bound (exit code 5).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace tremolo {

// An orbit whose energy exceeds this many times all that was ever put in has left its bound.
inline constexpr double kEnergyBound = 10.0;

class EnergyBound {
 public:
  // energy: H after `steps` steps; work: of the loads since the start. J. Once before the first
  // step and once after each. False: the orbit has left its bound, or is not finite.
  bool holds(std::int64_t steps, double energy, double work) {
    if (steps == 0) start_ = energy;
    most_input_ = std::max(most_input_, start_ + work);
    if (!std::isfinite(energy)) return false;
    // A method that kicks at the ends of a step has not moved by the end of the first one: its work
    // is still nothing, or a fraction, and says nothing about the energy of that kick.
    if (steps <= 1) return true;
    return most_input_ <= 0 || energy <= kEnergyBound * most_input_;
  }

 private:
  double start_ = 0.0;
  double most_input_ = 0.0;
};

}  // namespace tremolo
