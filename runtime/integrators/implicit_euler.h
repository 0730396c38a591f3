// Implicit Euler: every rate is taken at the end of the step.
//
//     q1 = q0 + h p1
//     p1 = p0 + h (fm - R(q1) - D p1)          fm: average of f over the step
//
// Without p1, for d = q1 - q0 and times h:
//
//     d - h p0 + h^2 [R(q0 + d) + D d/h - fm] = 0,       p1 = d/h
//     Jacobian I + h^2 K(q0 + d) + h D                   symmetric
//
// First order. Neither symplectic nor reversible: on q'' + omega^2 q = 0 a step multiplies the
// amplitude by 1/sqrt(1 + (h omega)^2), so it is stable for every h and damps what it does not
// resolve. (The eigenvalues of its matrix are 1/(1 -+ i h omega).) It is here as a contrast. The
// average hands on the exact impulse of any load. `dissipated` is the work of the damping force,
// d.D d/h: first order. What the method itself takes away is not in it.
#pragma once

#include "runtime/integrator.h"

namespace tremolo {

std::unique_ptr<Integrator> make_implicit_euler(Model::Pointer model,
                                                const IntegratorOptions& options);

}  // namespace tremolo
