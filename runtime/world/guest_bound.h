// Checks that the energy of a body of another kind in a SceneWorld is compatible with what was put
// into it (runtime/energy_bound.h).
#pragma once

#include "runtime/energy_bound.h"

namespace tremolo {

class GuestBound {
 public:
  // Takes the start, then every step. All in J: own: kinetic and elastic energy; gravity: its
  // energy of gravity; work: of contact since the start. False: the energy is above kEnergyBound
  // times all that was put in, or not a number.
  bool look(double own, double gravity, double work) {
    if (!started_)
      bound_.start(own);
    else
      bound_.put_in(work - work_ + gravity_ - gravity, 0.0);
    started_ = true;
    work_ = work;
    gravity_ = gravity;
    return bound_.look(own, 0.0) == EnergyFound::kSound;
  }

 private:
  EnergyBound bound_;
  bool started_ = false;
  double work_ = 0.0, gravity_ = 0.0;
};

}  // namespace tremolo
