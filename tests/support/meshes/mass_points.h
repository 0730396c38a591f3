// The mass of a tetrahedral mesh as many points, for tests of closed-form integrals: Gauss points
// of a cube that is mapped onto each tetrahedron, exact for polynomials of degree six and more, and
// the fields at them by the nodal shape functions, l (2l - 1) and 4 l l' for order 2, instead of
// the project's Bernstein polynomials.
#pragma once

#include <array>
#include <cmath>

#include "common/mesh/edge_points.h"

namespace tremolo::testing {

// mass: kg. place: of the rest shape, m. shape: one value a node of the element; a field's value
// here is their sum with its displacements at the nodes.
struct MassPoint {
  std::size_t element = 0;
  double mass = 0;
  Eigen::Vector3d place;
  ElementNodes nodes;
  std::array<double, kMostNodes> shape{};
};

// Nodes and weights of five Gauss-Legendre points on [0, 1].
inline std::array<std::array<double, 2>, 5> gauss_points() {
  const double a = std::sqrt(5.0 - 2.0 * std::sqrt(10.0 / 7.0)) / 3.0;
  const double b = std::sqrt(5.0 + 2.0 * std::sqrt(10.0 / 7.0)) / 3.0;
  const double wa = (322.0 + 13.0 * std::sqrt(70.0)) / 900.0;
  const double wb = (322.0 - 13.0 * std::sqrt(70.0)) / 900.0;
  return {{{0.5 - 0.5 * b, 0.5 * wb},
           {0.5 - 0.5 * a, 0.5 * wa},
           {0.5, 64.0 / 225.0},
           {0.5 + 0.5 * a, 0.5 * wa},
           {0.5 + 0.5 * b, 0.5 * wb}}};
}

inline std::array<double, kMostNodes> nodal_shapes(const std::array<double, 4>& l, bool quadratic) {
  if (!quadratic) return {l[0], l[1], l[2], l[3]};
  std::array<double, kMostNodes> shape{};
  for (std::size_t a = 0; a < 4; ++a) shape[a] = l[a] * (2.0 * l[a] - 1.0);
  for (std::size_t e = 0; e < 6; ++e) shape[4 + e] = 4.0 * l[kTetEdges[e][0]] * l[kTetEdges[e][1]];
  return shape;
}

// Calls visit(MassPoint) for each. density_of(element): kg/m^3.
template <class DensityOf, class Visit>
void for_each_mass_point(const TetMesh& mesh, const DensityOf& density_of, const Visit& visit) {
  const auto points = gauss_points();
  for (std::size_t e = 0; e < mesh.tetrahedra.size(); ++e) {
    const ElementNodes nodes = element_nodes(mesh, e);
    std::array<Eigen::Vector3d, 4> x;
    for (std::size_t a = 0; a < 4; ++a) x[a] = mesh.vertices[nodes[a]];
    const double six = std::abs((x[1] - x[0]).cross(x[2] - x[0]).dot(x[3] - x[0]));
    for (const auto& [u, wu] : points)
      for (const auto& [v, wv] : points)
        for (const auto& [w, ww] : points) {
          // The cube's corner fans out into the tetrahedron: dV = six (1-u)^2 (1-v) du dv dw.
          const std::array<double, 4> l = {u, (1 - u) * v, (1 - u) * (1 - v) * w,
                                           (1 - u) * (1 - v) * (1 - w)};
          const double volume = six * wu * wv * ww * (1 - u) * (1 - u) * (1 - v);
          visit(MassPoint{e, density_of(e) * volume,
                          l[0] * x[0] + l[1] * x[1] + l[2] * x[2] + l[3] * x[3], nodes,
                          nodal_shapes(l, !mesh.edge_points.empty())});
        }
  }
}

}  // namespace tremolo::testing
