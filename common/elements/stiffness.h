// The stiffness of one element at rest (docs/theory.md, section "Elements"):
//   K = sum_s share_s V B_s^T C B_s,
// where B_s maps the control values of the nodes to the strain at sample point s, and the four
// points of order 2 make the sum exact. The precompute assembles these blocks, the engine turns
// them with each element: there is one source for both.
#pragma once

#include <array>

#include <Eigen/Core>

#include "common/elements/elasticity.h"
#include "common/elements/element.h"

namespace tremolo {

// The geometry of the tetrahedron with these corners, m. Its volume is positive where det[x1-x0,
// x2-x0, x3-x0] is; a flat one has no gradients (infinite), which check_mesh has refused.
ElementGeometry element_geometry(const std::array<Eigen::Vector3d, 4>& corners);

// Rows and columns 3*node + axis, N/m.
using ElementStiffness = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor,
                                       3 * kMostNodes, 3 * kMostNodes>;
ElementStiffness rest_stiffness(const ElementGeometry& geometry, const Elasticity& elasticity,
                                int order);

}  // namespace tremolo
