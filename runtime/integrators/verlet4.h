// A fourth-order explicit splitting: seven kicks around six drifts (Blanes & Moan 2002, "Practical
// symplectic partitioned Runge-Kutta and Runge-Kutta-Nystroem methods", J. Comput. Appl. Math.
// 142, the method SRKN_6^b).
//
// The motion is cut into two that can be solved exactly, time going with the drift:
//
//     drift by s:  q <- q + (1 - e^{-D s})/D p,  p <- e^{-D s} p,  t <- t + s   (q' = p, p' = -D p)
//     kick by s:   p <- p + s (f(t) - R(q))                          D = alpha + beta lambda_i
//
// and a step is  kick b1 h, drift a1 h, kick b2 h, ..., kick b4 h, ..., drift a1 h, kick b1 h,
// the same forwards and backwards. A symmetric composition has no even powers of h in its error, so
// the order is four as soon as the two terms of third order vanish, whatever the two flows are;
// damping and load keep it. That seven kicks then have freedom left for a small fifth-order term is
// because, with g = f - R, the fields A = (p, -D p) of the drift and B = (0, g(q, t)) of the kick
// have
//     [B, A] = (g, -D g - g_q p - g_t),   [B, [B, A]] = (0, -2 g_q g),   [B, [B, [B, A]]] = 0:
// the second is a function of q and t alone, as without damping. The coefficients are the paper's;
// they meet the conditions of third order to 3e-16, and tests check the observed order and the
// angle by which a linear mode turns.
//
// f inside the step is the quadratic of runtime/load.h; the rule of nodes and weights b integrates
// it exactly, so that the impulse of any load is exact.
//
// The last force of a step is the first of the next: six forces a step. Symplectic and
// time-reversible without damping. Conditionally stable: linearly for h omega < 3.1634 (measured),
// that is 0.527 for each force (Verlet: 2). Of the drifts two go backwards, by 0.350 h: there
// damping puts energy in, and what it takes from a free momentum in the whole step is still exactly
// e^{-D h}.
//
// `dissipated` is the kinetic energy that the damped drifts take, exact for this composition and
// so fourth order. extra_work is what f does in the kicks less average.(q1 - q0): fourth order.
#pragma once

#include "runtime/integrator.h"

namespace tremolo {

std::unique_ptr<Integrator> make_verlet4(Model::Pointer model, const IntegratorOptions& options);

}  // namespace tremolo
