// The whole mesh in the coordinates of the world, and a step of it.
#pragma once

#include "precompute/fem/assembly.h"
#include "precompute/reference/full/full_order_solver.h"
#include "precompute/reference/time_integration.h"
#include "precompute/reference/world/pose_path.h"

namespace tremolo {

// The whole mesh with all its vertices in the coordinates of the world: free ones are unknowns,
// fixed ones follow the support. Displacements are from the rest shape, in the world, for any
// motion of the body: St. Venant-Kirchhoff's energy does not depend on rigid motion.

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

// A step of the whole mesh in the world, by the rules of time_integration.h. f, h: free and held
// vertices; w: displacements in the world; d = w1 - w0, of which d_h is given by the support:
//
//     M_ff (2/h) (d_f/h - v0) + M_fh (v1_h - v0_h)/h + F_f(w0, w1) + D = load,   v1 = 2 d_f/h - v0
//
// with F the mean of the elements' forces over the step and v_h the support's own velocity.
// D is that of the strain rates, as in time_integration.h: it feels no rotation. Damping by the
// mass acts on the motion relative to the support: alpha multiplies v - V by exp(-alpha h/2) before
// and after, V the velocity of a point that moves with it. No quantity of a moving frame enters: no
// fictitious force, no integral of the mass over a mode.

// The motion at t = 0: the rest shape at the support's pose, moving with it; for a flying body,
// with the rigid motion `flight`.
Motion start_in_world(const WorldBody& world, const RigidMotion& flight);

// Displacements and velocities of all vertices at the motion's time, 3n.
Field whole_displacement(const WorldBody& world, const Motion& motion);
Field whole_velocity(const WorldBody& world, const Motion& motion);

// Advances by one step. motion.work includes that of the support, with mass damping also that of
// the support through the damper. load: on the unknowns, N. Throws Failure (kSolver) if the solve
// does not converge.
void advance_in_world(WorldBody& world, const TimeSettings& settings, const LoadHistory& load,
                      Motion& motion);

}  // namespace tremolo
