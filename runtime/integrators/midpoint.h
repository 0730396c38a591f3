// Implicit midpoint (thesis 3.4.9).
//
// The discrete Lagrangian that takes V at the midpoint qm = (q0 + q1)/2 gives, with the mean
// velocity (p0 + p1)/2 = (q1 - q0)/h,
//
//     (p1 - p0)/h = fm - R(qm) - D (q1 - q0)/h          fm: average of f over the step
//
// Without p1, for d = q1 - q0 and times h^2/2:
//
//     d - h p0 + (h^2/2) [R(qm) + D d/h - fm] = 0,       p1 = 2 d/h - p0
//     Jacobian I + (h^2/4) K(qm) + (h/2) D               symmetric
//
// Second order with load and damping; symplectic and time-reversible without them; linearly stable
// for every h. Balance: load and damping do exactly fm.d - d.D d/h, which is what `dissipated`
// reports; V is not kept exactly, it only oscillates.
#pragma once

#include "runtime/integrator.h"

namespace tremolo {

std::unique_ptr<Integrator> make_midpoint(Model::Pointer model, const IntegratorOptions& options);

}  // namespace tremolo
