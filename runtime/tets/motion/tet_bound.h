// Checks that the energy of bodies of tetrahedra is compatible with the energy put in
// (runtime/energy_bound.h).
//
// The energy of deformation and motion of all bodies together, plus that of contact, is compared
// with the energy at the start and the work of gravity since. Bodies do work on each other, so that
// only the sum is bounded.
#pragma once

#include "runtime/energy_bound.h"
#include "runtime/tets/motion/tet_group.h"

namespace tremolo {

class TetBound {
 public:
  // Checks the present energy: at the start, then after every step. False: it is above kEnergyBound
  // times the energy put in, or not a number. Not for bodies with a grab.
  bool look(TetGroup& group);
  double energy() const { return energy_; }  // J, at the last check

 private:
  EnergyBound bound_;
  bool started_ = false;
  double energy_ = 0.0, gravity_ = 0.0;
};

}  // namespace tremolo
