// The force between a point of a body and an obstacle, over one step (docs/theory.md, section
// "Contact").
//
// Nearer than B, a point at the distance d has the depth x = B - d and the energy psi(x). psi
// belongs to the pair and to the area a around the point, not to the step:
//
//     psi' = a kappa x^2 up to x = w, a kappa w (2 x - w) beyond
//
// psi is convex with two continuous derivatives. For a step from x0 to x1, in the obstacle's frame,
// the force is the discrete gradient
//
//     f = -s n,   s = (psi(d1) - psi(d0)) / (d1 - d0),   n.(x1 - x0) = d1 - d0
//
// in closed form. n is the normal in the middle, corrected along x1 - x0, so that the work of f is
// exactly psi(d0) - psi(d1).
//
// If the obstacle deforms by w while the point moves by p along it, the correction is split: the
// force on the point is along n + c p, the force that deforms the obstacle along n - c w, and
// (n + c p).p - (n - c w).w = d1 - d0. A correction along p - w alone would grow without bound
// where the point sticks to a deformable obstacle.
//
// Restitution e multiplies s by 2/(1 + e^2) during approach and by 2 e^2/(1 + e^2) during
// separation, with a smooth transition at small speeds: a point mass leaves with e times the speed
// of its arrival. Approach and separation are those of the pair, by the rate at which its energy
// falls (PairRate). Therefore a ball, whose front points approach while its rear points separate,
// continues to roll. A fiftieth of the factor depends on the point's own rate, which damps small
// rocking. Friction is that of friction.h with the limit mu |s n|.
//
// B is the margin M, except for a point that was found nearer than M without a memory of contact
// (the body starts there, or was moved there). Its contact starts with B = d or less, without
// energy. B then follows outwards up to M, together with that of the body's other points
// (contact_memories.h), which costs no energy either.
//
// A round point is the centre of a ball of radius rho: its distance is that of the centre less rho.
// s n acts at the centre, through which it passes. Friction acts on the ball's surface, at -rho n
// from the centre: its path has the additional part theta x (-rho n), with theta the rotation of
// the body relative to the obstacle, and it turns the body and the obstacle by opposite torques. A
// ball rolls therefore exactly.
#pragma once

#include <limits>
#include <span>

#include <Eigen/Core>

#include "common/state_stream.h"
#include "runtime/contact/collider.h"
#include "runtime/contact/entry_side.h"
#include "runtime/contact/friction.h"
#include "runtime/math/pose.h"

namespace tremolo {

// The law of one point.
struct ContactLaw {
  double margin = 0.0;                                           // M, m
  double begins = 0.0;                                           // B, m; at most M
  double stiffness = 0.0;                                        // a kappa, N/m^2
  double linear_from = std::numeric_limits<double>::infinity();  // w, m
  double restitution = 0.5;                                      // e
  double friction = 0.3;                                         // mu
  double rebound_speed = 0.0;  // speed from which restitution is whole, m/s
  double shear = 0.0;          // k of friction.h, N/m
  double shear_damping = 0.0;  // c of friction.h, N s/m
  double radius = 0.0;         // rho of a round point, m
  // Of a contact with a rigid body, which comes to rest entirely: changes of distance below this
  // are rounding errors, and the normal is not corrected for them, m.
  double rounding = 0.0;

  double energy(double distance) const;
};

// The law of a point against another body: two bodies are two springs in series. law: of the point
// with the friction and restitution of the pair. own, theirs: of a unit of area of the two bodies;
// their stiffness is kappa. area: of the point, m^2.
ContactLaw law_in_series(ContactLaw law, const ContactLaw& own, const ContactLaw& theirs,
                         double area);

// The memory of a contact between steps, for a point that ended a step nearer than the margin.
// Vectors are along the obstacle's axes.
struct ContactMemory {
  std::size_t obstacle = 0, point = 0;
  double begins = 0.0;                                // B, m
  double limit = 0.0;                                 // friction limit in the last step, N
  Eigen::Vector3d slip = Eigen::Vector3d::Zero();     // xi of friction.h, m
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  // of the plane of xi, length 1
  std::uint32_t element = 0;  // of an obstacle of tetrahedra, where the point was
  EntrySide side = {};        // where the point is past the middle
  double depth = 0.0;         // by that side, m

  void carry(StateStream& stream) {
    stream(obstacle, point, begins, limit, slip, normal, element);
    side.carry(stream);
    stream(depth);
  }
};

// A collider in the world, in one step.
struct PlacedCollider {
  Collider shape;
  Pose start, end;           // of its frame, in the step
  double friction = 0.3;     // of the pair with the body in contact with it
  double restitution = 0.5;  // the same
};

// True if a collider that moves in the step comes nearer to the place than `reach`, m.
bool moves_near(std::span<const PlacedCollider> colliders, const Eigen::Vector3d& place,
                double reach);

// A point near a collider at the start of a step.
struct ContactStart {
  Eigen::Vector3d place = Eigen::Vector3d::Zero();    // x0 in the collider's frame at the start, m
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  // at that position, length 1
  double distance = 0.0;                              // d0, m
  double energy = 0.0;                                // psi(d0), J
  EntrySide side;                                     // that counts, of the centre of a round point
  Eigen::Vector3d inward = Eigen::Vector3d::Zero();   // entry_side.h, in the collider's frame
};

// The rate at which a body and an obstacle separate in a step, averaged over all their points: v =
// -dPsi/(h sum s). All points of a pair have the same e and rebound_speed.
struct PairRate {
  double force = 0.0;  // the sum of s without restitution, N
  double given = 0.0;  // the fall of the energy Psi, the sum of s (d1 - d0), J

  // Adds a point with this s, N, whose distance grows by `change`, m.
  void add(double pressure, double change) {
    force += pressure;
    given += pressure * change;
  }
  double way() const { return force > 0.0 ? given / force : 0.0; }  // v h, m
};

// Derivatives of a force, with the sign of its fall.
struct ContactSlope {
  Eigen::Vector3d by_distance;  // with the distance d1, N/m, at a held rate of the pair
  Eigen::Matrix3d by_path;      // with p, N/m
  Eigen::Matrix3d by_bend;      // with w, N/m
  Eigen::Vector3d by_taken;     // with the fraction that restitution takes from the whole pair, N
};

struct ContactSlopes {
  ContactSlope point, bend;  // of the force on the point, and of the one that bends the obstacle
  // Of a round point: of friction alone, and the fall of friction with the path of the surface.
  ContactSlope rub;
  Eigen::Matrix3d by_roll;
  double taken_by_distance = 0.0;  // growth of that fraction with d1, 1/m
  // Fall of the force on the point with the distance d0 where the point begins outside, N/m; else
  // zero. Only an obstacle that deforms changes d0.
  Eigen::Vector3d by_start;
};

// The force of a contact over the step.
struct ContactForce {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();  // on the point, N, world
  // Its opposite deforms the obstacle, N, world.
  Eigen::Vector3d bend_force = Eigen::Vector3d::Zero();
  Eigen::Vector3d rub = Eigen::Vector3d::Zero();  // of a round point: the part that is friction, N
  bool acts = false;                              // there is a force
  bool released = false;       // it is beside its side (entry_side.h): its energy is lost
  double pressure = 0.0;       // the length of s n without restitution and friction, N
  double limit = 0.0;          // friction limit mu |s n| found in this evaluation, N
  double energy = 0.0;         // psi(d1) and that of friction, J
  double lost = 0.0;           // taken by restitution, J
  double friction_loss = 0.0;  // taken by friction, J
  double distance = 0.0;       // d1, m
  Eigen::Vector3d slip = Eigen::Vector3d::Zero();  // xi1, in the frame of the displacement, m

  // Sets all forces to zero. The energy `stored` (J) in friction's memory becomes friction loss.
  void clear(double at, double stored) {
    acts = released = false;
    pressure = limit = energy = lost = 0.0;
    friction_loss = stored;
    distance = at;
    slip.setZero();
    rub.setZero();
  }
  // Counts the energy stored as lost.
  void release() {
    released = true;
    lost += energy;
    energy = 0.0;
    slip.setZero();
  }
};

// The elastic displacement of friction at the end of the step, m; 0 where the point slides or
// nothing presses.
double held_slip(const ContactLaw& law, const ContactForce& now);

// The values that a solver keeps constant while it searches for the end of the step: the normal of
// the middle and the friction limit. The derivative of the force is then symmetric except for
// curvature, as a line search needs. The step is solved once the limit agrees with the force.
struct ContactHeld {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double limit = 0.0;                              // N
  Eigen::Vector3d slip = Eigen::Vector3d::Zero();  // xi0, in the plane of the normal, m
};

// The kept values that an evaluation renews.
struct ContactRenewal {
  bool normals = false;
  double limits = 0.0;  // fraction of the step from the kept limits to the present ones, 0 to 1
};

// The motion of a point relative to an obstacle is path - bend, m.
struct ContactWay {
  Eigen::Vector3d path = Eigen::Vector3d::Zero();  // p: along the obstacle as if that were rigid, m
  // w: deformation of the obstacle at the contact, m
  Eigen::Vector3d bend = Eigen::Vector3d::Zero();
  // Of a round point: theta, the rotation of the body relative to the obstacle, rad.
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();
  // The gradient of d1 in derivatives may be that of a place so far away, m.
  double apart = 0.0;
};

// -rho n: from the centre of a round point to the surface, m.
Eigen::Vector3d surface_arm(const ContactLaw& law, const ContactHeld& held);

// The distance of a point in a step.
struct ContactGap {
  double d0 = 0.0;        // at the start, m
  double e0 = 0.0;        // psi(d0), J
  double d1 = 0.0;        // at the end, m
  double pressure = 0.0;  // s without restitution, N
  double fall = 0.0;      // its fall with d1, N/m
};

ContactGap make_gap(const ContactLaw& law, double d0, double e0, double d1);

// Sets the held normal, of any length, and turns the memory's slip into its plane.
void hold_normal(const Eigen::Vector3d& normal, const ContactMemory& memory, ContactHeld& held);

// The length of a step and the rate of the pair in it.
struct ContactTime {
  double h = 0.0;  // s
  PairRate rate;
};

// The force of a contact. limits: same as for ContactRenewal. Vectors may be in any one frame.
ContactForce contact_force(const ContactLaw& law, const ContactGap& gap, const ContactWay& way,
                           const ContactTime& time, double limits, ContactHeld& held);

// Slopes of that force, which acts. follows: the friction limit changes with the force.
ContactSlopes contact_slopes(const ContactLaw& law, const ContactGap& gap, const ContactWay& way,
                             const ContactTime& time, const ContactHeld& held, bool follows);

// The rotation of a collider's frame at the end of a step, and the mean of both ends.
struct ColliderTurns {
  Eigen::Matrix3d end, mean;
};
ColliderTurns turns_of(const PlacedCollider& collider);

// x: of the point, world, m. middle: of its body, if that is rigid, else x. memory: of the point's
// contact; null: none.
ContactStart contact_start(const ContactLaw& law, const PlacedCollider& collider,
                           const Eigen::Vector3d& x, const Eigen::Vector3d& middle,
                           const ContactMemory* memory);

// The position of a point at the end of a step.
struct ContactEnd {
  Eigen::Vector3d place = Eigen::Vector3d::Zero();    // in the collider's frame then, m
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  // there, along its axes
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();     // as in ContactWay; the caller sets it
  EntrySide side;                                     // as at the start
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

// Returns the length of the point's path relative to the collider, m. through: set to true if it
// passed through the collider (collider.h). A plane has no other side.
double contact_passage(const PlacedCollider& collider, const ContactStart& start,
                       const ContactEnd& end, bool& through);

// Derivatives of the force on a point, which acts; in the world.
struct PlacedSlope {
  Eigen::Matrix3d by_end;    // with x1, N/m, at a held rate of the pair
  Eigen::Vector3d by_taken;  // with the fraction that restitution takes from the pair, N
  Eigen::Vector3d taken;     // growth of that fraction with x1, 1/m
  // Of a round point: of friction alone, and the fall of both with the path of the surface.
  Eigen::Matrix3d rub_by_end, by_roll;  // N/m
  Eigen::Vector3d rub_by_taken;         // N
};
// follows: same as for contact_slopes().
PlacedSlope contact_slope(const ContactLaw& law, const ColliderTurns& turns,
                          const ContactStart& start, const ContactEnd& end, const ContactTime& time,
                          const ContactHeld& held, bool follows);

}  // namespace tremolo
