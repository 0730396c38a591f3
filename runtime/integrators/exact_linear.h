// The step of a linear model, V = 1/2 q^T Lambda q: its coordinates do not couple, and each is a
// damped driven oscillator whose solution is known (runtime/integrators/solve/linear_response.h).
// With f inside the step the quadratic of runtime/load.h, f = g0 + g1 s + g2 s^2, s = (t - t0)/h,
// and J_k, u of that header, a = D h, b = lambda h^2,
//
//     q1 = (u' + D u) q0 + h J_0 p0 + h^2 (g0 J_1 + g1 J_2 + 2 g2 J_3)
//     p1 =  -(b/h) J_0 q0 +  u' p0  + h   (g0 J_0 + g1 J_1 + 2 g2 J_2)
//
// for any h: exact for free motion and for loads that are such quadratics, constant ones among
// them; of another smooth load the error is that of the quadratic, O(h^4).
//
// Without damping the free part is the rotation by h omega. It is made of three shears,
//
//     q += t p,  p -= s q,  q += t p,     t = tan(h omega/2)/omega,  s = omega sin(h omega),
//
// h omega taken modulo pi and the sign put right: their product keeps areas whatever the rounding
// of t and s, so that energy does not drift, as it would by 1e-16 a step with the rounded matrix.
//
// Work and dissipation are exact: `extra_work` is the integral of (f - average).p over the step,
// `dissipated` is work - (H1 - H0), rounding included, and zero without damping. A damped
// coordinate that has fallen below 1e-290 becomes zero, before it becomes a denormal number, with
// which processors are slow. O(r) a step, nothing is solved: `iterations` is 0.
#pragma once

#include "runtime/integrator.h"

namespace tremolo {

// name: what Integrator::name() says. model: linear.
std::unique_ptr<Integrator> make_exact_linear(std::string_view name, Model::Pointer model,
                                              const IntegratorOptions& options);

}  // namespace tremolo
