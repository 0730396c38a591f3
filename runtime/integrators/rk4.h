// The classical Runge-Kutta method of four stages, on z = (q, p) with
// z' = F(t, z) = (p, f(t) - R(q) - D p):
//
//     k1 = F(t+, z0)
//     k2 = F(t + h/2, z0 + (h/2) k1)
//     k3 = F(t + h/2, z0 + (h/2) k2)
//     k4 = F((t + h)-, z0 + h k3)
//     z1 = z0 + (h/6) (k1 + 2 k2 + 2 k3 + k4)
//
// f inside the step is the quadratic of runtime/load.h. Its middle is off by O(h^4) of a smooth
// load's, and Simpson's rule is exact for it, so the step hands on the exact impulse of any load.
//
// Four forces a step. Fourth order, also with load and damping. Neither symplectic nor reversible:
// on q'' + omega^2 q = 0 a step multiplies the amplitude by |1 + z + z^2/2 + z^3/6 + z^4/24| at
// z = i y, y = h omega, the square of which is 1 - y^6/72 + y^8/576: it decays for
// y < sqrt 8 = 2.8284 and grows above: conditionally stable.
//
// `dissipated` is the same rule's integral of p.D p, extra_work that of f.p less average.(q1 - q0):
// both fourth order.
#pragma once

#include "runtime/integrator.h"

namespace tremolo {

std::unique_ptr<Integrator> make_rk4(Model::Pointer model, const IntegratorOptions& options);

}  // namespace tremolo
