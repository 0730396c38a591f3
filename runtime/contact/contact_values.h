// Values of contact for a body, its grabs and its callers: options, energy balance, contact points.
#pragma once

#include <algorithm>
#include <optional>

#include <Eigen/Core>

#include "common/mesh/tet_mesh.h"
#include "common/state_stream.h"
#include "runtime/contact/collider.h"
#include "runtime/contact/springs.h"
#include "runtime/math/pose.h"
#include "runtime/math/state.h"

namespace tremolo {

// The time scale of contact, s. Stiffness, restitution at small speeds and sleep follow from it and
// not from the step.
inline constexpr double kContactTime = 3e-3;
// A body in contact whose kinetic energy is below that of this speed, m/s, is nearly at rest.
// margin: of its contact, m.
inline double slow_speed(double margin) {
  return 0.01 * margin / kContactTime;
}

// Contact properties of a body.
struct ContactOptions {
  int points = 200;       // at most this many vertices of its boundary
  double margin = 0.005;  // distance at which contact begins, as a fraction of the body's extent
  // (kContactTime omega)^2, where omega is the frequency of the whole body on its whole boundary at
  // the depth of the margin. A larger value gives less penetration and shorter contacts.
  double stiffness = 16.0;
  // Replaces the stiffness, Pa: the pressure is modulus x/extent at the depth x, from a tenth of
  // the margin on; see elastic_layer_modulus().
  std::optional<double> modulus = {};
  // The solid with which other bodies' points collide, in the mesh's coordinates at rest. Without
  // it they pass through.
  std::optional<Collider> shape = {};
  double friction = 0.3;     // with other bodies; a pair uses the geometric mean
  double restitution = 0.5;  // the same
  bool colliders = true;     // false: only grabs act on it
};

// Returns the modulus of an elastic layer of thickness t on a body of that extent, Pa: (1 - nu)
// E/((1 + nu) (1 - 2 nu)) extent/t. young: E, Pa; poisson: nu, below 1/2; thickness, extent: m.
inline double elastic_layer_modulus(double young, double poisson, double thickness, double extent) {
  return (1.0 - poisson) * young / ((1.0 + poisson) * (1.0 - 2.0 * poisson)) * extent / thickness;
}

// All known forces on a body in the next step.
struct StepPush {
  const Eigen::VectorXd* force = nullptr;                  // on the coordinates, r
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();  // of a free body's centre, m/s^2
};

// Energy balance and statistics of contact in one step.
struct ContactAccount {
  double energy = 0.0;  // stored in contact at the end, J
  // Of contact forces on the body, or on the motion of a driven body relative to its frame, J.
  double work = 0.0;
  double lost = 0.0;           // taken by restitution, J
  double friction_loss = 0.0;  // taken by friction, J
  double given = 0.0;          // by moving colliders, supports and jumps of bodies, J
  // Contact energy at the start of the step minus that at the end of the step before, J.
  double surplus = 0.0;
  double hand_work = 0.0, hand_damped = 0.0;  // J
  double joint_work = 0.0;                    // J
  double load_work = 0.0;                     // of loads on bodies of tetrahedra and cloths, J
  double penetration = 0.0;                   // greatest depth of a point behind a surface, m
  double impulse = 0.0;                       // sum of |F| h, N s
  double way = 0.0;  // longest path of a point relative to a nearby obstacle, m
  // Largest elastic displacement xi of a point that friction holds (friction.h), m.
  double slip = 0.0;
  int active = 0;  // number of points with a contact force
  // Sum of F h on the body by colliders and other bodies, N s, world.
  Eigen::Vector3d impulse_vector = Eigen::Vector3d::Zero();
  int passed = 0;  // number of points that passed through an obstacle (contact/collider.h)

  // Counts the surplus as given: the obstacle has moved between the steps.
  void give_surplus() {
    given += surplus;
    surplus = 0.0;
  }
};

// A contact point of a body with a force in the last step.
struct ContactedPoint {
  VertexId vertex = 0;       // of the body's mesh
  bool on_body = false;      // true: the obstacle is a body; false: a collider
  std::size_t obstacle = 0;  // its number in the group or among the colliders
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  // at the end of the step, m, world
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();    // out of the obstacle, length 1, world
  Eigen::Vector3d impulse = Eigen::Vector3d::Zero();   // on the body in the step, N s, world
};

inline void carry(StateStream& stream, ContactAccount& account) {
  stream(account.energy, account.work, account.lost, account.friction_loss, account.given);
  stream(account.surplus, account.hand_work, account.hand_damped, account.penetration);
  stream(account.joint_work);
  stream(account.impulse, account.active, account.way, account.passed, account.impulse_vector);
}

// A grab: an implicit spring and damper from a vertex, or a position in a triangle, to a moving
// point. ContactBody::stiffest_hand() limits both.
struct Grip {
  VertexId vertex = 0;     // or, without at_vertex, one near the position
  VertexRows place;        // rows of U at the grabbed position
  double stiffness = 0.0;  // N/m
  double damping = 0.0;    // N s/m
  // The moving point at both ends of the step, m, world.
  Eigen::Vector3d start = Eigen::Vector3d::Zero(), end = Eigen::Vector3d::Zero();
  // On the body in the last step, N, world; the hand feels its opposite.
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  // work: on the body in that step, J. damped: the part taken by the damper, J. The spring's
  // energy is stiffness times the square of its length over 2, J.
  double work = 0.0, damped = 0.0;
  bool at_vertex = true;  // false: a position in a triangle
};

// modes: the number r of columns that restored rows must have.
inline void carry(StateStream& stream, Grip& grip, Eigen::Index modes) {
  stream(grip.vertex, grip.stiffness, grip.damping, grip.start, grip.end, grip.force);
  stream(grip.work, grip.damped);
  carry(stream, grip.place, modes);
  stream.require(grip.stiffness >= 0.0 && grip.damping >= 0.0);
}

}  // namespace tremolo
