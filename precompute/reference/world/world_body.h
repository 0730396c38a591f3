// The whole mesh with all its vertices in the coordinates of the world: free ones are unknowns,
// fixed ones follow the support. Displacements are from the rest shape, in the world, for any
// motion of the body: St. Venant-Kirchhoff's energy does not depend on rigid motion.
#pragma once

#include "precompute/fem/assembly.h"
#include "precompute/reference/full/full_order_solver.h"
#include "precompute/reference/world/pose_path.h"

namespace tremolo {

// path: of the support; none: the body has none and flies. body and solver are not owned, and the
// solver is the body's.
struct WorldBody {
  FullOrder& body;
  FullOrderSolver& solver;
  MassKind mass = MassKind::kConsistent;
  const PosePath* path = nullptr;
};

// Displacements (m) of the held vertices where the support takes them, and their velocities (m/s):
// 3n, zero at the others.
Field held_displacement(const WorldBody& world, const RigidMotion& support);
Field held_velocity(const WorldBody& world, const RigidMotion& support);

// Velocities (m/s) that the free vertices would have at the displacements u if they rode along.
Vector riding_velocity(const WorldBody& world, const RigidMotion& support, const Vector& u);

// M x with the rows and columns of all vertices, point masses included. x: 3n.
Field whole_mass_times(const WorldBody& world, const Field& x);

}  // namespace tremolo
