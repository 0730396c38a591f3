// The full-order St. Venant-Kirchhoff body: M u'' + f(u) = load on the unknowns. It runs in one
// process; element loops use threads, and sums do not depend on their number.
#pragma once

#include <span>

#include "precompute/dense/sparse_rows.h"
#include "precompute/fem/stvk.h"
#include "precompute/problem/problem.h"
#include "precompute/reference/full/step_equation.h"
#include "precompute/reference/full/unknowns.h"
#include "precompute/system/petsc.h"

namespace tremolo {

// The displacements (m) of the held components at the start of a step and their change in it: 3n,
// zero at the unknowns. Empty: they stay zero.
struct SupportStep {
  Field from, by;
};

// mass (kg), stiffness (N/m, at rest): values on `pattern`. rigid: N x 6 per part, M-orthonormal
// rigid motions of a free body, which are removed from every motion as in a reduced basis;
// mass_rigid: M * rigid. Both have no columns if the body is held. support: of the step being
// taken, where the support moves.
struct FullOrder {
  Solid solid;  // refers to the problem's mesh
  Unknowns unknowns;
  Pattern pattern;
  std::vector<double> mass, stiffness;
  Columns rigid, mass_rigid;
  unsigned threads = 1;
  SupportStep support = {};

  Eigen::Index size() const { return unknowns.count(); }
};

// Creates the body, which holds a reference to the problem's mesh. Throws Failure: kUsage on
// several ranks, kContent if every vertex is fixed.
FullOrder make_full_order(const Problem& problem, MassKind kind, unsigned threads);

// Returns a non-owning view of a matrix on the body's pattern.
SparseRows rows_of(const FullOrder& body, const std::vector<double>& values);

// Returns A x for a matrix with the body's pattern.
Vector multiply(const FullOrder& body, const std::vector<double>& values, const Vector& x);

double potential_energy(const FullOrder& body, const Vector& u);  // V at the step's end, J

// The integral of dE : C : dE over the change of the strains from u to u + d, the support's step
// included, J.
double strain_change_work(const FullOrder& body, const Vector& u, const Vector& d);

// Returns the forces of the elements on the held components, N, 3n, zero elsewhere; as
// segment_force().
Field held_force(const FullOrder& body, const std::vector<SegmentPoint>& points, const Vector& u,
                 const Vector& d);

// Returns sum_i w_i f(u + s_i d), N; u, d: size().
Vector segment_force(const FullOrder& body, const std::vector<SegmentPoint>& points,
                     const Vector& u, const Vector& d);

// Computes the derivative of segment_force with respect to d, N/m, on the body's pattern.
void segment_tangent(const FullOrder& body, const std::vector<SegmentPoint>& points,
                     const Vector& u, const Vector& d, std::vector<double>& values);

// Remove the rigid component of a displacement, and of a force.
void remove_rigid_motion(const FullOrder& body, Vector& u);
void remove_rigid_force(const FullOrder& body, Vector& force);

// Returns the load without its rigid component; zero if the rest is rounding.
Vector deforming_load(const FullOrder& body, const Vector& load);

// Returns the largest displacement of these vertices, m; 0 if there are none.
double largest_displacement(const FullOrder& body, const std::vector<VertexId>& vertices,
                            const Vector& u);

// Returns the forces of a default load on the unknowns, N.
Vector point_load(const FullOrder& body, const DefaultLoad& load);

// Returns the consistent weight of the body under gravity (m/s^2), point masses included, N.
Vector gravity_load(const FullOrder& body, const Eigen::Vector3d& gravity);

// Energy, force and tangent of one element (precompute/fem/stvk.h); force and tangent as weighted
// sums over points of a segment (step_equation.h).

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
