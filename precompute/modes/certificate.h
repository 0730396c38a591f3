// The certificate that no mode was missed: Sylvester's law of inertia.
#pragma once

#include <string>

#include "precompute/modes/modes.h"

namespace tremolo {

// What compute_modes found against a count by inertia, with the bound in the last gap, usually
// halfway to the first mode left out.
struct InertiaCertificate {
  double bound = 0;  // (rad/s)^2
  int expected = 0;  // modes found below the bound, rigid ones included
  int counted = 0;   // by inertia
  std::string solver;
  bool complete() const { return expected == counted; }
};

// Takes the solver's memory. rigid_count: a free body's motions, eigenvalues 0. Throws Failure.
InertiaCertificate certify(ShiftedSolver& solver, const Modes& modes, int rigid_count);

}  // namespace tremolo
