// Newmark's method with the numbers beta and gamma (thesis 3.4.10-3.4.12), on
// a + D v + R(q) = f, with v = p since M = I:
//
//     q1 = q0 + h v0 + h^2 [(1/2 - beta) a0 + beta a1]
//     v1 = v0 + h [(1 - gamma) a0 + gamma a1]
//     a1 + D v1 + R(q1) = f((t+h)-)
//
// a0 is not carried over but recomputed from the left end's own load, a0 = f(t+) - D v0 - R(q0):
// where f jumps between two steps each step then sees the value on its side. The unknown is
// w = h^2 a1, which also serves beta = 0 (explicit in q, a diagonal solve):
//
//     w + h^2 [D v1 + R(q1) - f] = 0,   Jacobian I + gamma h D + beta h^2 K(q1)
//
// Second order for gamma = 1/2, first otherwise. beta = 1/4, gamma = 1/2, the default, is linearly
// stable for every h and time-reversible; beta = 0, gamma = 1/2 is Stoermer-Verlet without damping.
// `dissipated` is d.D d/h with d = q1 - q0: second order.
#pragma once

#include "runtime/integrator.h"

namespace tremolo {

std::unique_ptr<Integrator> make_newmark(Model::Pointer model, const IntegratorOptions& options);

}  // namespace tremolo
