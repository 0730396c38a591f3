// The force between a point of a body and an obstacle, over one step (docs/theory.md, section
// "Contact").
//
// Nearer than B, a point at the distance d has the depth x = B - d and the energy psi(x), which
// belongs to the pair and to the area a that the point stands for, not to the step:
//
//     psi' = a kappa x^2 up to x = w, a kappa w (2 x - w) beyond
//
// psi is convex with two continuous derivatives. Over a step from x0 to x1, in the obstacle's
// frame, the force is the discrete gradient
//
//     f = -s n,   s = (psi(d1) - psi(d0)) / (d1 - d0),   n.(x1 - x0) = d1 - d0
//
// in closed form, with n the normal in the middle, corrected along x1 - x0: its work is exactly
// psi(d0) - psi(d1). Where the obstacle bends as well, by w, while the point moves by p along it,
// the correction is shared: n + c p pushes the point, n - c w the bending, and
// (n + c p).p - (n - c w).w = d1 - d0. Along p - w alone it would grow without bound where the
// point sticks to what bends. Restitution e multiplies
// s by 2/(1 + e^2) on the way in and by 2 e^2/(1 + e^2) on the way out, with a smooth passage at
// small speeds: a point mass leaves with e times the speed of its arrival. In and out are those of
// the pair, by the rate at which its energy falls (PairRate), so that a ball, whose points come in
// before it and go out behind it, rolls on; a fiftieth is by the point's own rate, which lets small
// rocking die away. Friction is that of friction.h with the limit mu |s n|.
//
// B is the margin M, but for a point that was found nearer than M without a memory of contact: a
// body that begins there, or was put there. Its contact begins where it is, B = d, without energy,
// and B follows the point outwards up to M, which costs no energy either.
#pragma once

#include <limits>

#include <Eigen/Core>

#include "common/state_stream.h"
#include "runtime/contact/collider.h"
#include "runtime/contact/friction.h"
#include "runtime/frames/pose.h"

namespace tremolo {

// The law of one point.
struct ContactLaw {
  double margin = 0.0;                                           // M, m
  double begins = 0.0;                                           // B, m; at most M
  double stiffness = 0.0;                                        // a kappa, N/m^2
  double linear_from = std::numeric_limits<double>::infinity();  // w, m
  double restitution = 0.5;                                      // e
  double friction = 0.3;                                         // mu
  double rebound_speed = 0.0;  // m/s, from which on restitution is whole
  double shear = 0.0;          // k of friction.h, N/m
  double shear_damping = 0.0;  // c of friction.h, N s/m

  double energy(double distance) const;
};

// The memory of a contact between steps: a point that ended a step nearer than the margin. Vectors
// are along the obstacle's axes.
struct ContactMemory {
  std::size_t obstacle = 0, point = 0;
  double begins = 0.0;                                // B, m
  double limit = 0.0;                                 // of friction in the last step, N
  Eigen::Vector3d slip = Eigen::Vector3d::Zero();     // xi of friction.h, m
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  // of the plane of xi, length 1

  void carry(StateStream& stream) { stream(obstacle, point, begins, limit, slip, normal); }
};

// A collider in the world, in one step. Its frame moves from `start` to `end`. friction,
// restitution: of the pair with whatever touches it.
struct PlacedCollider {
  Collider shape;
  Pose start, end;
  double friction = 0.3;
  double restitution = 0.5;
};

// A point near a collider at the start of a step. place: x0 in the collider's frame then, m.
struct ContactStart {
  Eigen::Vector3d place = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  // there
  double distance = 0.0;                              // d0, m
  double energy = 0.0;                                // psi(d0), J
};

// How a body and an obstacle part in a step, of all their points: v = -dPsi/(h sum s). All points
// of a pair have the same e and rebound_speed.
struct PairRate {
  double force = 0.0;  // the sum of s without restitution, N
  double given = 0.0;  // the fall of the energy Psi, the sum of s (d1 - d0), J

  // A point with this s, N, whose distance grows by `change`, m.
  void add(double pressure, double change) {
    force += pressure;
    given += pressure * change;
  }
  double way() const { return force > 0.0 ? given / force : 0.0; }  // v h, m
};

// By how much a force falls.
struct ContactSlope {
  Eigen::Vector3d by_distance;  // with the distance d1, N/m, at a held rate of the pair
  Eigen::Matrix3d by_path;      // with p, N/m
  Eigen::Matrix3d by_bend;      // with w, N/m
  Eigen::Vector3d by_taken;     // with the fraction that restitution takes from the whole pair, N
};

struct ContactSlopes {
  ContactSlope point, bend;  // of the force on the point, and of the one that bends the obstacle
  double taken_by_distance = 0.0;  // how that fraction grows with d1, 1/m
};

// The force of a contact over the step.
struct ContactForce {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();  // on the point, N, world
  // The opposite of bend_force bends the obstacle, N, world.
  Eigen::Vector3d bend_force = Eigen::Vector3d::Zero();
  bool acts = false;      // there is a force
  double pressure = 0.0;  // the length of s n without restitution and friction, N
  double limit = 0.0;     // mu |s n|, as it is, N
  double energy = 0.0;    // psi(d1) and that of friction, J
  double lost = 0.0;      // taken by restitution, J
  double rubbed = 0.0;    // taken by friction, J
  double distance = 0.0;  // d1, m
  Eigen::Vector3d slip = Eigen::Vector3d::Zero();  // xi1, in the frame of the way, m

  // Nothing acts; `stored` (J), of friction's memory, is friction's loss.
  void clear(double at, double stored) {
    acts = false;
    pressure = limit = energy = lost = 0.0;
    rubbed = stored;
    distance = at;
    slip.setZero();
  }
};

// What a solver holds while it looks for the end of the step: the normal of the middle, and the
// limit of friction. With both held the force has a symmetric derivative but for curvature, which a
// line search needs; the step is solved once the limit is what it should be.
struct ContactHeld {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double limit = 0.0;                              // N
  Eigen::Vector3d slip = Eigen::Vector3d::Zero();  // xi0, in the plane of the normal, m
};

// What an evaluation renews of what is held.
struct ContactRenewal {
  bool normals = false;
  double limits = 0.0;  // the fraction of the way to what they are, 0 to 1
};

// p, by which the point goes along what it touches as if that did not bend, and w, by which that
// bends there, m. The point's way over it is p - w.
struct ContactWay {
  Eigen::Vector3d path = Eigen::Vector3d::Zero();
  Eigen::Vector3d bend = Eigen::Vector3d::Zero();
};

// The distance of a point in a step.
struct ContactGap {
  double d0 = 0.0;        // at the start, m
  double e0 = 0.0;        // psi(d0), J
  double d1 = 0.0;        // at the end, m
  double pressure = 0.0;  // s without restitution, N
  double fall = 0.0;      // how that falls with d1, N/m
};

ContactGap make_gap(const ContactLaw& law, double d0, double e0, double d1);

// Sets the held normal, of any length, and turns the memory's slip into its plane.
void hold_normal(const Eigen::Vector3d& normal, const ContactMemory& memory, ContactHeld& held);

// A step of length h, s, and how the pair parts in it.
struct ContactTime {
  double h = 0.0;
  PairRate rate;
};

// The force of a contact. limits: as of ContactRenewal. Vectors in any one frame.
ContactForce contact_force(const ContactLaw& law, const ContactGap& gap, const ContactWay& way,
                           const ContactTime& time, double limits, ContactHeld& held);

// How that force, which acts, falls. follows: friction's limit is not held but goes with the force.
ContactSlopes contact_slopes(const ContactLaw& law, const ContactGap& gap, const ContactWay& way,
                             const ContactTime& time, const ContactHeld& held, bool follows);

// The rotations of a collider's frame in a step: at its ends, and their mean.
struct ColliderTurns {
  Eigen::Matrix3d start, end, mean;
};
ColliderTurns turns_of(const PlacedCollider& collider);

// x: world, m.
ContactStart contact_start(const ContactLaw& law, const PlacedCollider& collider,
                           const Eigen::Vector3d& x);

// Where a point ends a step.
struct ContactEnd {
  Eigen::Vector3d place = Eigen::Vector3d::Zero();    // in the collider's frame then, m
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  // there, along its axes
  ContactGap gap;
};

// x1: world, m.
ContactEnd contact_end(const ContactLaw& law, const PlacedCollider& collider,
                       const ColliderTurns& turns, const ContactStart& start,
                       const Eigen::Vector3d& x1);

ContactForce contact_force(const ContactLaw& law, const PlacedCollider& collider,
                           const ColliderTurns& turns, const ContactStart& start,
                           const ContactMemory& memory, const ContactEnd& end,
                           const ContactTime& time, const ContactRenewal& renewal,
                           ContactHeld& held);

// How far the point went relative to the collider, m; through: whether it went through it
// (passage.h). A plane has no other side.
double contact_passage(const PlacedCollider& collider, const ContactStart& start,
                       const ContactEnd& end, bool& through);

// How the force on a point, which acts, falls. World.
struct PlacedSlope {
  Eigen::Matrix3d by_end;    // with x1, N/m, at a held rate of the pair
  Eigen::Vector3d by_taken;  // with the fraction that restitution takes from the pair, N
  Eigen::Vector3d taken;     // how that fraction grows with x1, 1/m
};
// follows: as of contact_slopes().
PlacedSlope contact_slope(const ContactLaw& law, const ColliderTurns& turns,
                          const ContactStart& start, const ContactEnd& end, const ContactTime& time,
                          const ContactHeld& held, bool follows);

}  // namespace tremolo
