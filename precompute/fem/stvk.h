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

// One sample a tetrahedron, in order. The mesh must have passed check_mesh.
std::vector<StrainSample> strain_samples(const TetMesh& mesh);

// The mesh with its materials, ready for element loops. Borrows the mesh. elasticities, densities
// (kg/m^3): of each material. material_of: an index into them for each element; empty: all the
// first. point_mass: of each vertex, kg; empty: none.
struct Solid {
  const TetMesh& mesh;
  std::vector<StrainSample> samples;
  std::vector<Elasticity> elasticities;
  std::vector<double> densities;
  std::vector<std::int32_t> material_of;
  std::vector<double> point_mass = {};

  std::size_t material(std::size_t element) const {
    return material_of.empty() ? 0 : static_cast<std::size_t>(material_of[element]);
  }
  const Elasticity& elasticity(std::size_t element) const {
    return elasticities[material(element)];
  }
  double density(std::size_t element) const { return densities[material(element)]; }
  // One isotropic material: the loops over elements have a shorter way for it.
  bool uniform() const { return elasticities.size() == 1 && elasticities.front().isotropic; }
};
Solid make_solid(const TetMesh& mesh, const Material& material);
Solid make_solid(const TetMesh& mesh, const MaterialTable& table);
// Of a part of a mesh: element i of `part` is element tetrahedra[i] of the table's mesh.
Solid make_solid(const TetMesh& part, const std::vector<std::size_t>& tetrahedra,
                 const MaterialTable& table);

// Displacements and forces are 3n vectors, x y z of vertex 0 first.
using Field = Eigen::VectorXd;
using FieldRef = Eigen::Ref<const Eigen::VectorXd>;

Eigen::Matrix3d displacement_gradient(const Solid& solid, std::size_t element, const FieldRef& u);

// Of a displacement gradient.
Eigen::Matrix3d green_strain(const Eigen::Matrix3d& g);

double strain_energy(const Solid& solid, const FieldRef& u);  // J
Field internal_force(const Solid& solid, const FieldRef& u);  // N, the gradient of the energy
// The part of it that the first `count` elements contribute.
Field internal_force(const Solid& solid, const FieldRef& u, std::size_t count);

// The second derivative of the force at rest, H[a, b] (thesis section 4.1.3; Barbic & James 2005).
// StVK's force is cubic; the part of F S that is bilinear in two displacement gradients A, B is
//   S(sym(A^T B)) + A S(sym B) + B S(sym A).
// Adds H[a, b] to rows row_of_vertex[v] .. +2 of `out`; vertices with a negative row are skipped.
// `elements` lists the tetrahedra to visit.
void add_second_derivative(const Solid& solid, const std::vector<int>& elements, const FieldRef& a,
                           const FieldRef& b, const std::vector<int>& row_of_vertex, double* out);

// 12x12 stiffness at rest, rows and columns 3*a + axis.
Eigen::Matrix<double, 12, 12> rest_stiffness(const Elasticity& elasticity,
                                             const StrainSample& sample);

}  // namespace tremolo
