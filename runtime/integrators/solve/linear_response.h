// The response of one damped oscillator  q'' + D q' + lambda q = f  within a step, in closed form.
//
// Let u be its response to a unit impulse: u(0) = 0, u'(0) = 1, f = 0. With x1, x2 the roots of x^2
// + a x + b, a = D h, b = lambda h^2, and phi_k(x) = sum_n x^n/(n + k)!, the k-fold integral of u
// from 0 to h is h^(k+1) times the divided difference phi_k[x1, x2]. That is real, and smooth in a
// and b: below, at and above critical damping, with lambda = 0 and with D = 0.
#pragma once

#include <array>

namespace tremolo {

// The values of one step, dimensionless.
struct LinearResponse {
  double velocity = 1.0;  // u'(h)
  double place = 1.0;     // u'(h) + D u(h): q(h) of the oscillator that starts at rest from q = 1
  // integral[k]: J_k = phi_k[x1, x2], that is u(h)/h for k = 0 and the k-fold integral of u over
  // h^(k+1) above.
  std::array<double, 6> integral{};
};

// a = D h >= 0, b = lambda h^2 >= 0, finite. Errors are a few rounding errors: relative to each of
// the integrals (to 1e-14 for J_4, 2e-14 for J_5), relative to the oscillation's size near zeros;
// the phase h omega is rounded like any number.
LinearResponse linear_response(double a, double b);

}  // namespace tremolo
