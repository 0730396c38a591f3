// St. Venant-Kirchhoff elasticity, element by element (docs/theory.md, section "Elements").
//
// With F = I + G and the displacement gradient G of element.h,
//   E = sym(G) + 1/2 G^T G           Green strain
//   S(E) = C E                      second Piola-Kirchhoff stress (elasticity.h)
//   energy = sum_s weight_s 1/2 S(E):E      force on node i = sum_s weight_s F S grad B_i
// over the element's strain samples, weight_s = share_s times the volume: exact for both orders.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "common/elements/elasticity.h"
#include "common/elements/element.h"
#include "common/mesh/tet_mesh.h"

namespace tremolo {

// Returns the elements in order. The mesh must have passed check_mesh.
std::vector<ElementGeometry> element_geometry(const TetMesh& mesh);

// A mesh with its materials, ready for element loops. It holds a reference to the mesh.
// elasticities, densities (kg/m^3): one a material. material_of: index into them for each element;
// empty: index 0 for all. point_mass: one a vertex, kg; empty: none.
struct Solid {
  const TetMesh& mesh;
  std::vector<ElementGeometry> elements;
  std::vector<Elasticity> elasticities;
  std::vector<double> densities;
  std::vector<std::int32_t> material_of;
  std::vector<double> point_mass = {};

  std::size_t material(std::size_t element) const {
    return material_of.empty() ? 0 : material_of[element];
  }
  const Elasticity& elasticity(std::size_t element) const {
    return elasticities[material(element)];
  }
  double density(std::size_t element) const { return densities[material(element)]; }
  int order() const { return mesh.edge_points.empty() ? 1 : 2; }
  // One isotropic material; element loops are faster for it.
  bool uniform() const { return elasticities.size() == 1 && elasticities.front().isotropic; }
};
Solid make_solid(const TetMesh& mesh, const Material& material);
Solid make_solid(const TetMesh& mesh, const MaterialTable& table);
// For a part of a mesh: element i of `part` is element tetrahedra[i] of the table's mesh.
Solid make_solid(const TetMesh& part, const std::vector<std::size_t>& tetrahedra,
                 const MaterialTable& table);

// Displacements and forces are vectors of length 3n: x, y, z of vertex 0, then of vertex 1 and so
// on. At an edge point of a quadratic mesh the displacement is the control value, not the motion of
// the place, and the force is what does work on it.
using Field = Eigen::VectorXd;
using FieldRef = Eigen::Ref<const Eigen::VectorXd>;

// u: 3n, m.
GradientField displacement_gradients(const Solid& solid, std::size_t element, const FieldRef& u);

// Returns E, dimensionless. g: displacement gradient G.
Eigen::Matrix3d green_strain(const Eigen::Matrix3d& g);

double strain_energy(const Solid& solid, const FieldRef& u);  // J
Field internal_force(const Solid& solid, const FieldRef& u);  // N, the gradient of the energy
// Returns the internal force of the first `count` elements only.
Field internal_force(const Solid& solid, const FieldRef& u, std::size_t count);

// Adds H[a, b], the second derivative of the internal force at rest (thesis section 4.1.3; Barbic &
// James 2005), over the tetrahedra in `elements`. The StVK force is cubic in the displacement; the
// part of F S that is bilinear in two displacement gradients A, B is
//   S(sym(A^T B)) + A S(sym B) + B S(sym A).
// The values go to rows row_of_vertex[v] .. +2 of `out`; vertices with a negative row are skipped.
void add_second_derivative(const Solid& solid, const std::vector<int>& elements, const FieldRef& a,
                           const FieldRef& b, const std::vector<int>& row_of_vertex, double* out);

// Adds C[a, b, c], the third derivative of the internal force, in the same form: the part of F S
// that is linear in each of three displacement gradients is the sum of A S(sym(B^T C)) over the
// three choices of A.
void add_third_derivative(const Solid& solid, const std::vector<int>& elements,
                          const std::array<Field, 3>& fields, const std::vector<int>& row_of_vertex,
                          double* out);

// Returns the stiffness of an element at rest (element.h).
ElementStiffness rest_stiffness(const Solid& solid, std::size_t element);

}  // namespace tremolo
