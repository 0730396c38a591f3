// Certificate that no mode was missed, by Sylvester's law of inertia.
#pragma once

#include <string>

#include "precompute/modes/modes.h"

namespace tremolo {

// Number of modes that compute_modes found below a bound, against a count by inertia. The bound
// lies in the last gap, usually halfway to the first mode left out.
struct InertiaCertificate {
  double bound = 0;  // (rad/s)^2
  int expected = 0;  // modes found below the bound, rigid ones included
  int counted = 0;   // by inertia
  std::string solver;
  bool complete() const { return expected == counted; }
};

// Releases the solver's factor. rigid_count: rigid modes of a free body, with eigenvalue 0. Throws
// Failure.
InertiaCertificate certify(ShiftedSolver& solver, const Modes& modes, int rigid_count);

}  // namespace tremolo
