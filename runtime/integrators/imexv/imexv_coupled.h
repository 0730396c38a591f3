// The implicit-explicit method of a variational split whose implicit part holds every coupling.
//
// The potential is cut in two, V = V_slow + V_fast, with V_slow(q) = V(q_l, 0) the part that the
// low rows l of the split (runtime/split.h) have alone, and V_fast = V - V_slow all that the high
// rows h take part in. The discrete Lagrangian takes V_slow by the trapezoid rule and V_fast at the
// midpoint; its step, with S = grad V_slow on the low rows and 0 on the high ones, d = q1 - q0,
// qm = (q0 + q1)/2 and M = I, is
//
//     p_l <- p_l + (h/2) (f_l(t+) - S_l(q0))
//     solve for d:  (d - h p)/g + (h^2/2) [R(qm) - S(qm) + D d/h - f] = 0        on all rows
//                   Jacobian  1/g + (h^2/4) (K(qm) - dS/dq(qm)) + (h/2) D        symmetric
//     q   <- q + d,  p <- p + (2/g) (d/h - p)
//     p_l <- p_l + (h/2) (f_l((t+h)-) - S_l(q1))
//
// On the high rows f is the load's average over the step, on the low rows zero. g = 1 + 2 theta h
// D, theta of runtime/integrators/solve/damping.h, on the low rows that of omega = 0: there the
// drift between the kicks is the exact flow of q' = p, p' = -D p.
//
// Second order, also with load and damping; symplectic and time-reversible without damping, for any
// coupling of low and high rows, at the price of as many unknowns as the midpoint rule. Undamped
// and all low it is `verlet`, all high `midpoint`. Conditionally stable: linearly iff h omega < 2
// on the low rows, as `imexv`. `dissipated` is that of runtime/integrators/solve/damping.h.
#pragma once

#include "runtime/integrator.h"

namespace tremolo {

// Errors as choose_split.
Result<std::unique_ptr<Integrator>> make_imexv_coupled(Model::Pointer model,
                                                       const IntegratorOptions& options);

}  // namespace tremolo
