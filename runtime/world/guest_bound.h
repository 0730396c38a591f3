// Checks that the energy of a body of another kind in a SceneWorld is compatible with what was put
// into it (runtime/energy_bound.h).
#pragma once

#include <algorithm>

#include "runtime/energy_bound.h"

namespace tremolo {

class GuestBound {
 public:
  // Takes the start, then every step. All in J: own: kinetic and elastic energy and that of
  // contact; gravity: its energy of gravity; work: of contact, hands and joints since the start,
  // and that energy of contact. False: the energy is above kEnergyBound times all that was put in,
  // or not a number.
  bool look(double own, double gravity, double work) {
    if (!started_)
      bound_.start(own);
    else
      bound_.put_in(work - work_ + gravity_ - gravity, 0.0);
    started_ = true;
    work_ = work;
    gravity_ = gravity;
    largest_ = std::max(largest_, own);
    return own <= kRest * largest_ || own <= kNothing ||
           bound_.look(own, 0.0) == EnergyFound::kSound;
  }

 private:
  // Below this share of the largest energy the body is at rest, and its energy is rounding.
  static constexpr double kRest = 1e-6;
  static constexpr double kNothing = 1e-20;  // J: that of a body that never moved

  EnergyBound bound_;
  bool started_ = false;
  double work_ = 0.0, gravity_ = 0.0, largest_ = 0.0;
};

}  // namespace tremolo
