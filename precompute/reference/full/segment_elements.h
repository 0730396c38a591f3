// Energy, force and tangent of one element (precompute/fem/stvk.h); force and tangent as weighted
// sums over points of a segment (step_equation.h).
#pragma once

#include <span>

#include "precompute/fem/stvk.h"
#include "precompute/reference/full/step_equation.h"

namespace tremolo {

// Index of block (a, b), a <= b, among the 3x3 blocks of an element's symmetric tangent.
constexpr int element_block(int a, int b) {
  return b * (b + 1) / 2 + a;
}
constexpr int element_blocks(int order) {
  return element_block(0, nodes_of_order(order));
}

double element_energy(const Solid& solid, std::size_t element, const Field& u);  // J

// The integral of dE : C : dE over the change of the strains from u to u + d, J. u, d: 3n.
double element_strain_change_work(const Solid& solid, std::size_t element, const Field& u,
                                  const Field& d);

// Returns sum_i w_i f(u + s_i d). u, d: 3n.
NodeForces element_force(const Solid& solid, std::size_t element,
                         const std::vector<SegmentPoint>& points, const Field& u, const Field& d);

// Computes sum_i w_i s_i K(u + s_i d), N/m, the derivative of element_force with respect to d.
// blocks: element_blocks().
void element_tangent(const Solid& solid, std::size_t element,
                     const std::vector<SegmentPoint>& points, const Field& u, const Field& d,
                     std::span<Eigen::Matrix3d> blocks);

}  // namespace tremolo
