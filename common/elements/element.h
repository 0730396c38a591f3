// Linear and quadratic tetrahedra with straight edges in Bernstein-Bezier form (docs/theory.md,
// section "Elements"; the polynomials after Farin 1986).
//
// With barycentric coordinates l_0 .. l_3 the polynomials are l_a for order 1; l_a^2 at the corners
// and 2 l_a l_b at the edges for order 2. The displacement gradient of a field with control values
// c is of one degree less,
//   G(l) = sum_a G_a l_a,   G_a = 2 sum_b c_ab (grad l_b)^T        (order 2; order 1: one
//   constant).
// A product of k such gradients has degree k(order - 1), and a sum over sample points integrates it
// exactly:
//   1/V integral p dV = sum_s share_s p(l_s).
// So an element is a set of strain samples, for both orders the same; that of order 1 has one.
#pragma once

#include <array>
#include <span>

#include <Eigen/Core>

#include "common/elements/elasticity.h"
#include "common/mesh/edge_points.h"

namespace tremolo {

// volume: m^3. gradients: column a is grad l_a, 1/m.
struct ElementGeometry {
  double volume = 0;
  Eigen::Matrix<double, 3, 4> gradients;
};

// share: fraction of the element's volume; may be negative. lambda: barycentric coordinates.
struct SamplePoint {
  double share = 1.0;
  std::array<double, 4> lambda = {0.25, 0.25, 0.25, 0.25};
};

// Points that integrate a product of `gradients` displacement gradients, 2 (stiffness), 3 (its
// first derivative) or 4 (energy), exactly. Order 2: 4, 5 and 11 points, the negative share last.
std::span<const SamplePoint> sample_points(int order, int gradients);

// Node of the polynomial whose exponents are e_a + e_b, in the order of ElementNodes.
inline constexpr int kNodeAt[4][4] = {{0, 4, 5, 6}, {4, 1, 7, 8}, {5, 7, 2, 9}, {6, 8, 9, 3}};

constexpr int nodes_of_order(int order) {
  return order == 1 ? 4 : kMostNodes;
}

// Gradients of the polynomials at a point, 1/m; one column a node.
using NodeGradients = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::ColMajor, 3, kMostNodes>;
NodeGradients node_gradients(const ElementGeometry& element, int order, const SamplePoint& point);

// Integral of the product of the polynomials of nodes i and j, or of one polynomial, as a fraction
// of the volume.
double mass_share(int order, int i, int j);
constexpr double weight_share(int order) {
  return order == 1 ? 0.25 : 0.1;
}

// Values of the polynomials at a point, one per node. Outside the element, where a coordinate is
// negative, those of order 2 continue linearly from the nearest point inside, so that a surface
// that is a little outside of the mesh does not swing.
std::array<double, kMostNodes> polynomials_at(int order, const std::array<double, 4>& lambda);

// The displacement gradient of one element and the conjugate stress: a field has one coefficient
// for order 1 and four for order 2, and a sample point combines them.

// The coefficients G_a of one element: 1 (order 1) or 4.
struct GradientField {
  int count = 1;
  std::array<Eigen::Matrix3d, 4> at;

  Eigen::Matrix3d operator()(const SamplePoint& point) const;
};

// Returns the gradient of a field with the control values control(0), control(1), .. of the
// element's nodes; of positions in space it is the deformation gradient F.
template <class Control>
GradientField gradient_field(const ElementGeometry& element, int order, const Control& control) {
  const Eigen::Matrix<double, 4, 3> gradients = element.gradients.transpose();
  GradientField field;
  field.count = order == 1 ? 1 : 4;
  Eigen::Matrix<double, 3, 4> around;
  for (int a = 0; a < field.count; ++a) {
    for (int b = 0; b < 4; ++b) around.col(b) = control(field.count == 1 ? b : kNodeAt[a][b]);
    field.at[a] = around * gradients;
    if (field.count > 1) field.at[a] *= 2.0;
  }
  return field;
}

// Forces on the nodes of an element, N, one column a node.
using NodeForces = NodeGradients;

// Sum over samples of weight times first Piola-Kirchhoff stress, J, which is conjugate to the
// coefficients G_a: add() one sample, forces() on the nodes at the end.
struct PiolaField {
  int count = 1;
  std::array<Eigen::Matrix3d, 4> at;

  explicit PiolaField(int order);
  void add(const SamplePoint& point, const Eigen::Matrix3d& weighted);
  NodeForces forces(const ElementGeometry& element) const;
};

// The stiffness of one element at rest (docs/theory.md, section "Elements"):
//   K = sum_s share_s V B_s^T C B_s,
// where B_s maps the control values of the nodes to the strain at sample point s, and the four
// points of order 2 make the sum exact. The precompute assembles these blocks, the engine turns
// them with each element: there is one source for both.

// The geometry of the tetrahedron with these corners, m. Its volume is positive where det[x1-x0,
// x2-x0, x3-x0] is; a flat one has no gradients (infinite), which check_mesh has refused.
ElementGeometry element_geometry(const std::array<Eigen::Vector3d, 4>& corners);

// Rows and columns 3*node + axis, N/m.
using ElementStiffness = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor,
                                       3 * kMostNodes, 3 * kMostNodes>;
ElementStiffness rest_stiffness(const ElementGeometry& geometry, const Elasticity& elasticity,
                                int order);

}  // namespace tremolo
