// Whether the energy of bodies of tetrahedra can still be what was put in (runtime/energy_bound.h).
//
// What deforms and moves all bodies together, and what is stored where they are pressed, is
// compared with what there was at the start and what gravity has given since. Bodies push each
// other, so that only the sum is bounded.
#pragma once

#include "runtime/energy_bound.h"
#include "runtime/tets/motion/tet_group.h"

namespace tremolo {

class TetBound {
 public:
  // Looks at the bodies as they are: at the start, then after every step. False: there is more than
  // kEnergyBound times what was put in, or it is not a number. No hand may pull.
  bool look(TetGroup& group);
  double energy() const { return energy_; }  // J, that was found last

 private:
  EnergyBound bound_;
  bool started_ = false;
  double energy_ = 0.0, gravity_ = 0.0;
};

}  // namespace tremolo
