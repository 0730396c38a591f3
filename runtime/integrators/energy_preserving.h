// The energy-preserving family: avf, ep2, ep4.
//
// V is quartic, so the mean of grad V on the segment from q0 to q1 is known exactly
// (Potential::averaged_gradient); call it G. With d = q1 - q0, v = d/h, Dp = p1 - p0, any symmetric
// positive N that is fixed within the step and any diagonal S > 0, the step
//
//     (a)  S^-1 Dp = N d/h - p0 [+ (h/12) Df]        S^-1 = I/2 + theta h D
//     (b)  N Dp/h + G + D v = f
//
// has, since in Dp . (a) + d . (b) the terms with N cancel and what is left on the left-hand side
// is Dp . (p0 + Dp/2) + d . G = T(p1) - T(p0) + V(q1) - V(q0),
//
//     H1 - H0 = f . d [+ (h/12) Df . Dp]  -  h v . D v - h Dp . theta D Dp
//
// for every h and every theta >= 0: without load and damping the energy stays, with damping it
// falls. f is the load's average over the step, Df its change from end to end; what stands in
// brackets is ep4's. theta is diagonal, 1/12 + O(h^2) where N = I - h^2 K/12. All that differs is
// N:
//
//     avf   N = I                                     (Quispel & McLaren 2008)
//     ep2   N = diag(x_i cot x_i),  x_i = min(h omega_i/2, 1.2): small vibrations have their exact
//           frequency up to h omega = 2.4
//     ep4   N = N(Z), Z = h^2 K/4 with K taken at the midpoint (runtime/integrators/
//           rational_filter.h): fourth order for the nonlinear problem, since N = I - h^2 K/12 +
//           O(h^4), also with a smooth load, by the brackets, and with damping
//
// All are time-reversible; avf and ep2 exactly. ep4 takes K not at the solution's midpoint but at
// that of an iterate near it: the first, and later ones until the difference is lost in the solve's
// tolerance. With K at the predicted
// midpoint q0 + (h/2) p0, which is of the same order but knows the direction of time, energy moves
// into the fast modes, as fast as e-fold in 70 s on the horse at h omega up to 9.7.
//
// Damping. D = alpha I + beta Lambda itself stands in (b), so that the damping force is right on
// coordinates that are slaved to others. theta and, for each coordinate, a change of N's value are
// chosen so that a free linear mode has its exact roots up to h omega = 2.4 at any D
// (runtime/integrators/solve/damping.h); both tend to what stands without damping fast enough that
// no order is lost. `dissipated` is exact: the negative terms of the balance above.
//
// Solving. Without Dp, times h^2/2, for d:
//
//     g(d) = (h/2) N Dp(d) + (h^2/2) (G - f) + (h/2) D d = 0,      Jacobian about N^2 + (h^2/4) K
//
// One contraction at the predicted step d = h p0 gives G there and K + O(h^2) for N and for the
// frozen Jacobian; each correction costs one contraction more and is sharpened by Broyden's
// updates. Where that stalls the exact Jacobian and a line search take over
// (runtime/integrators/solve/newton.h).
//
// What the solve leaves of g does work on d: H is off by exactly (2/h^2) g . d, which is known.
// p1 is scaled to take that back, so the balance holds to rounding whatever the tolerance; a
// step that ends with so little momentum that this would change the kinetic energy by a twentieth
// is solved to 1e-13.
#pragma once

#include "runtime/integrator.h"

namespace tremolo {

std::unique_ptr<Integrator> make_avf(Model::Pointer model, const IntegratorOptions& options);
std::unique_ptr<Integrator> make_ep2(Model::Pointer model, const IntegratorOptions& options);
std::unique_ptr<Integrator> make_ep4(Model::Pointer model, const IntegratorOptions& options);

}  // namespace tremolo
