// Checks that a body's energy is compatible with the work of its loads. Conditionally stable
// methods can explode: T + V then grows without any work, beyond every number within some tens of
// steps.
//
// The energy put in is T + V at the start (of the body, or when a state was set) plus the net work
// of the loads since, at its highest. The work is a sum over steps, of second order for most
// methods. It is still zero after the first kick of a method that kicks before it moves. Therefore
// it counts as at least 1/2 (h |f|)^2, the energy that the largest f of a step gives a body at
// rest.
//
// If a check finds less than a tenth of all this, damping has taken the rest, and the energy put in
// counts as ten times the energy found: a body that has been pushed for hours is not allowed the
// sum of all pushes.
//
// Stable methods stay well inside. T + V of an undamped mode oscillates in the explicit ones; the
// ratio of its largest to its smallest value is 1 / (1 - (h omega)^2/4): 5.3 at the default split
// of h omega < 1.8, 10 at 1.9, 100 at 1.99.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/state_stream.h"

namespace tremolo {

// A state with at most this many times the energy put in is valid: one to return to. The programs
// end an orbit above it (exit code 5).
inline constexpr double kEnergyBound = 10.0;

// Above this many times the energy put in, the library treats a step as failed.
inline constexpr double kEnergyLimit = 100.0;

// Fraction of the harmonic energy 1/2 p.p + 1/2 q.Lambda q that may be rounding in T + V: the terms
// of V cancel, and lanes compute them in float.
inline constexpr double kEnergyRounding = 1e-5;

// Fraction of a body's size: a body whose points move less than this in a step is at rest.
inline constexpr double kRoundedMove = 1e-11;

// Largest energy of a body at rest, J. Contact that only just begins leaves such energies, which
// are rounding. mass: kg; size: m; step: s.
inline double energy_at_rest(double mass, double size, double step) {
  const double speed = kRoundedMove * size / step;
  return 0.5 * mass * speed * speed;
}

// Result of an energy check: a state to return to; one above that but within the limit; a failed
// step.
enum class EnergyFound { kSound, kWithinLimit, kExploded };

// Energies and work are in J. It starts with the values of a body at rest in the rest shape.
class EnergyBound {
 public:
  // False after restart(), until start().
  bool started() const { return !std::isnan(balance_); }
  void restart() { balance_ = most_ = std::numeric_limits<double>::quiet_NaN(); }
  void start(double energy) {
    balance_ = most_ = std::isnan(energy) ? std::numeric_limits<double>::infinity() : energy;
  }

  // J, 0 by default. No smaller energy is an explosion, whatever was put in: energy_at_rest().
  void set_rest(double energy) { rest_ = energy; }

  // Adds a step that succeeded. work: of the loads in it. kick: 1/2 (h |f|)^2, zero without a load.
  void put_in(double work, double kick) {       // otherwise the energy is not finite either
    if (std::isfinite(work)) balance_ += work;  // else the energy is no number either
    most_ = std::max({most_, balance_, kick});
  }

  // energy: T + V. harmonic: as for kEnergyRounding, 0 where the energy is known to rounding. A
  // value that is not a number is neither sound nor within the limit.
  bool sound(double energy, double harmonic = 0.0) const {
    return is_within(kEnergyBound, energy, harmonic);
  }
  bool holds(double energy, double harmonic = 0.0) const {
    return is_within(kEnergyLimit, energy, harmonic);
  }

  // True if a part of T + V, of which none is negative, exceeds the limit alone.
  bool exceeded_by(double part) const { return most_ > 0.0 && part > kEnergyLimit * most_; }

  // Checks the energy; where it is valid, subtracts the energy that was lost.
  EnergyFound look(double energy, double harmonic) {
    if (!holds(energy, harmonic)) return EnergyFound::kExploded;
    if (!sound(energy, harmonic)) return EnergyFound::kWithinLimit;
    take_off_what_is_lost(energy, harmonic);
    return EnergyFound::kSound;
  }

  // Limits the energy put in to ten times the energy that was found.
  void take_off_what_is_lost(double energy, double harmonic) {
    const double enough = kEnergyBound * (std::max(energy, 0.0) + kEnergyRounding * harmonic);
    if (enough < most_) balance_ = most_ = enough;
  }

  void carry(StateStream& stream) { stream(balance_, most_); }

 private:
  bool is_within(double factor, double energy, double harmonic) const {
    if (!std::isfinite(energy)) return false;
    return most_ <= 0.0 || energy <= rest_ || energy <= factor * most_ + kEnergyRounding * harmonic;
  }

  double balance_ = 0.0;  // energy at the start plus the work since
  double most_ = 0.0;     // highest value of balance_
  double rest_ = 0.0;     // set_rest()
};

}  // namespace tremolo
