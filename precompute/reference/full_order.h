// The unreduced St. Venant-Kirchhoff body: M u'' + f(u) = load over the displacement components
// that move. One process; loops over elements use threads, and sums do not depend on their number.
#pragma once

#include "precompute/dense/sparse_rows.h"
#include "precompute/fem/stvk.h"
#include "precompute/problem/problem.h"
#include "precompute/reference/unknowns.h"
#include "precompute/system/petsc.h"

namespace tremolo {

// mass (kg), stiffness (N/m, at rest): values on `pattern`. rigid: N x 6 a part, M-orthonormal
// rigid motions of a free body, which are left out of every motion as they are out of a reduced
// basis; mass_rigid: M times them. Both have no columns when the body is held.
struct FullOrder {
  Solid solid;  // borrows the problem's mesh
  Unknowns unknowns;
  Pattern pattern;
  std::vector<double> mass, stiffness;
  Columns rigid, mass_rigid;
  unsigned threads = 1;

  Eigen::Index size() const { return unknowns.count(); }
};

// Borrows the problem's mesh. Throws Failure: kUsage on several ranks, kContent when nothing moves.
FullOrder make_full_order(const Problem& problem, MassKind kind, unsigned threads);

SparseRows rows_of(const FullOrder& body, const std::vector<double>& values);

// y = A x of a matrix on the body's pattern.
Vector multiply(const FullOrder& body, const std::vector<double>& values, const Vector& x);

double potential_energy(const FullOrder& body, const Vector& u);  // V, J

// sum_i w_i f(u + s_i d), N; u, d: size().
Vector segment_force(const FullOrder& body, const std::vector<SegmentPoint>& points,
                     const Vector& u, const Vector& d);

// values <- its derivative by d, N/m, on the body's pattern.
void segment_tangent(const FullOrder& body, const std::vector<SegmentPoint>& points,
                     const Vector& u, const Vector& d, std::vector<double>& values);

// Takes the rigid motions out of a displacement, and their share out of a force.
void remove_rigid_motion(const FullOrder& body, Vector& u);
void remove_rigid_force(const FullOrder& body, Vector& force);

// The load without its rigid share; zero when that is all of it but for rounding.
Vector deforming_load(const FullOrder& body, const Vector& load);

// Of these vertices, m; 0 of none.
double largest_displacement(const FullOrder& body, const std::vector<VertexId>& vertices,
                            const Vector& u);

// The forces of a default load on the unknowns, N.
Vector point_load(const FullOrder& body, const DefaultLoad& load);

// The weight of the body in a field of gravity (m/s^2), point masses included: consistent, N.
Vector gravity_load(const FullOrder& body, const Eigen::Vector3d& gravity);

}  // namespace tremolo
