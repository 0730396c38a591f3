// Energy, force and tangent of one element (precompute/fem/stvk.h); force and tangent as weighted
// sums over points of a segment (step_equation.h).
#pragma once

#include "precompute/fem/stvk.h"
#include "precompute/reference/step_equation.h"

namespace tremolo {

// Forces on the corners, N, one column a corner.
using ElementForce = Eigen::Matrix<double, 3, 4>;

// Blocks (a, b), a <= b, of the symmetric 12 x 12 tangent, N/m, in the order of element_block().
using ElementTangent = std::array<Eigen::Matrix3d, 10>;
constexpr int element_block(int a, int b) {  // a <= b
  return 4 * a - a * (a - 1) / 2 + b - a;
}

double element_energy(const Solid& solid, std::size_t element, const Field& u);  // J

// Returns sum_i w_i f(u + s_i d). u, d: 3n.
ElementForce element_force(const Solid& solid, std::size_t element,
                           const std::vector<SegmentPoint>& points, const Field& u, const Field& d);

// Returns sum_i w_i s_i K(u + s_i d), the derivative of element_force with respect to d.
ElementTangent element_tangent(const Solid& solid, std::size_t element,
                               const std::vector<SegmentPoint>& points, const Field& u,
                               const Field& d);

}  // namespace tremolo
