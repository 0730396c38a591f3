// St. Venant-Kirchhoff elasticity, element by element (docs/theory.md, section "Elements").
//
// An element is a set of strain samples; a linear tetrahedron needs one, because the displacement
// gradient G = sum_a u_a (grad N_a)^T is constant in it. With F = I + G,
//   E = sym(G) + 1/2 G^T G           Green strain
//   S(E) = C E                      second Piola-Kirchhoff stress (elasticity.h)
//   energy = volume * 1/2 S(E):E     force on vertex a = volume * F S grad N_a
#pragma once

#include <vector>

#include <Eigen/Core>

#include "common/mesh/tet_mesh.h"
#include "precompute/fem/elasticity.h"

namespace tremolo {

// weight: m^3 (the volume of a linear tetrahedron). gradients: column a is grad N_a, 1/m.
struct StrainSample {
  double weight = 0;
  Eigen::Matrix<double, 3, 4> gradients;
};

// Returns one sample a tetrahedron, in order. The mesh must have passed check_mesh.
std::vector<StrainSample> strain_samples(const TetMesh& mesh);

// A mesh with its materials, ready for element loops. It holds a reference to the mesh.
// elasticities, densities (kg/m^3): one a material. material_of: index into them for each element;
// empty: index 0 for all. point_mass: one a vertex, kg; empty: none.
struct Solid {
  const TetMesh& mesh;
  std::vector<StrainSample> samples;
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
  // One isotropic material; element loops are faster for it.
  bool uniform() const { return elasticities.size() == 1 && elasticities.front().isotropic; }
};
Solid make_solid(const TetMesh& mesh, const Material& material);
Solid make_solid(const TetMesh& mesh, const MaterialTable& table);
// For a part of a mesh: element i of `part` is element tetrahedra[i] of the table's mesh.
Solid make_solid(const TetMesh& part, const std::vector<std::size_t>& tetrahedra,
                 const MaterialTable& table);

// Displacements and forces are vectors of length 3n: x, y, z of vertex 0, then of vertex 1 and so
// on.
using Field = Eigen::VectorXd;
using FieldRef = Eigen::Ref<const Eigen::VectorXd>;

// Returns G of one element, dimensionless. u: 3n, m.
Eigen::Matrix3d displacement_gradient(const Solid& solid, std::size_t element, const FieldRef& u);

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

// Returns the 12x12 stiffness at rest, N/m, rows and columns 3*a + axis.
Eigen::Matrix<double, 12, 12> rest_stiffness(const Elasticity& elasticity,
                                             const StrainSample& sample);

}  // namespace tremolo
