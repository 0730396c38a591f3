// The implicit-explicit method of a variational split whose implicit part is linear (Stern &
// Grinspun 2009, "Implicit-explicit variational integration of highly oscillatory problems").
//
// The potential is cut in two, V = V_slow + V_fast with V_fast = 1/2 q_h^T Lambda_h q_h on the high
// rows h of the split (runtime/split.h). The discrete Lagrangian takes V_slow by the trapezoid rule
// and V_fast at the midpoint; its step, with R_s = R - Lambda_h q_h the slow force and M = I, is
//
//     p   <- p + (h/2) (f(t+) - R_s(q0))          on all rows; low rows: DampedKick
//     q_l <- q_l + h p_l
//     d_h  = (h p_h - g (h^2/2) Lambda_h q_h) / (1 + g ((h^2/4) Lambda_h + (h/2) D_h))
//     q_h <- q_h + d_h,  p_h <- p_h + (2/g) (d_h/h - p_h)
//     p   <- p + (h/2) (f((t+h)-) - R_s(q1))      on all rows; low rows: DampedKick
//
// with g = 1 + 2 theta h D_h; DampedKick and theta: runtime/integrators/solve/damping.h.
//
// No equation is left to solve: one force a step. Second order, also with load and damping;
// symplectic and time-reversible without damping, for any coupling of low and high rows. All low:
// it is `verlet`.
//
// Conditionally stable: linearly iff h omega < 2 on the low rows. But what V has beyond its
// quadratic part on the high rows is kicked explicitly: where deformation stiffens the solid it is
// the first of the implicit-explicit methods to explode. Of the six sample models under their own
// loads beam, basket, horse and tower do so within 0.3 s at 3 ms, none in 10 s at 1 ms (`tremolo
// run build/models/NAME.tremolo --integrator imexv-linear --step H --duration 10`). To be chosen
// where the motion is known to be small for the step. `dissipated` is that of
// runtime/integrators/solve/damping.h.
#pragma once

#include "runtime/integrator.h"

namespace tremolo {

// Errors as choose_split.
Result<std::unique_ptr<Integrator>> make_imexv_linear(Model::Pointer model,
                                                      const IntegratorOptions& options);

}  // namespace tremolo
