// The high rows of imexv-linear (imexv_linear.cpp), one at a time: for one body, or for several
// bodies in the lanes of a vector (runtime/bodies/lanes/lane_group.h).
#pragma once

#include "runtime/bodies/reduced/integrators/solve/damping.h"

namespace tremolo {

// Coefficients of a row with V_fast = 1/2 lambda q^2; D and g are those of DampedMidpoint.
struct LinearRow {
  double stiffness;  // g (h^2/2) lambda
  double weight;     // 1 + g ((h^2/4) lambda + (h/2) D)
  double change;     // 2/g
};

inline LinearRow make_linear_row(double D, double g, double lambda, double h) {
  return {(0.5 * h * h) * g * lambda, 1.0 + g * ((0.25 * h * h) * lambda + (0.5 * h) * D), 2.0 / g};
}

// The midpoint rule:  d = (h p - stiffness q)/weight,  q <- q + d,  dp = change (d/h - p),
// p <- p + dp. Real: double or a vector of them.
template <class Real>
[[gnu::always_inline]] inline void advance_linear_row(const LinearRow& row, double h, Real& q,
                                                      Real& p, Real& d, Real& dp) {
  d = (h * p - row.stiffness * q) / row.weight;
  dp = row.change * (d / h - p);
  q += d;
  p += dp;
}

}  // namespace tremolo
