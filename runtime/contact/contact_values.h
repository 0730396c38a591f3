// What a body, its hands and those who look at them say and hear of contact.
#pragma once

#include <algorithm>
#include <optional>

#include <Eigen/Core>

#include "common/mesh/tet_mesh.h"
#include "common/state_stream.h"
#include "runtime/contact/collider.h"
#include "runtime/frames/pose.h"
#include "runtime/values/vertex_rows.h"

namespace tremolo {

// The time scale of contact: stiffness, restitution at small speeds and sleep follow from it and
// not from the step, s.
inline constexpr double kContactTime = 3e-3;

// How a body feels contact.
struct ContactOptions {
  int points = 200;       // at most so many of its boundary's vertices
  double margin = 0.005;  // where contact begins, as a fraction of the body's extent
  // (kContactTime omega)^2 of the whole body on the whole of its boundary at the depth of the
  // margin. Larger: less penetration and shorter contacts.
  double stiffness = 16.0;
  // Instead of the stiffness, Pa: the pressure is modulus x/extent at the depth x, from a tenth of
  // the margin on; see elastic_layer_modulus().
  std::optional<double> modulus = {};
  // The solid that other bodies' points meet, in the mesh's coordinates at rest; without one they
  // pass through.
  std::optional<Collider> shape = {};
  double friction = 0.3;     // towards other bodies; of a pair the geometric mean
  double restitution = 0.5;  // the same
  bool colliders = true;     // false: it feels hands alone
};

// The modulus of an elastic layer of thickness t on a body of that extent, Pa: (1 - nu) E/((1 + nu)
// (1 - 2 nu)) extent/t. young: E, Pa; poisson: nu, below 1/2; thickness and extent: m.
inline double elastic_layer_modulus(double young, double poisson, double thickness, double extent) {
  return (1.0 - poisson) * young / ((1.0 + poisson) * (1.0 - 2.0 * poisson)) * extent / thickness;
}

// Where the body's mesh frame is in the step. Of a free body `end` is a prediction.
struct StepPoses {
  Pose start, end;
};

// All that acts on a body in the step to come, as far as that is known before it.
struct StepPush {
  const Eigen::VectorXd* force = nullptr;                  // on the coordinates, r
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();  // of a free body's centre, m/s^2
};

// Account of one step, J but for the last two. energy: of contact at the end. work: what contact
// forces did to the body, or to the motion of a driven one relative to its frame. lost, rubbed:
// taken by restitution and friction. given: by colliders and supports that move. surplus: contact
// energy that was there at the start and not at the end of the step before. penetration: deepest of
// a point behind a surface, m. impulse: sum of |F| h, N s. way: farthest that a point near
// something went relative to it, m.
struct ContactAccount {
  double energy = 0.0, work = 0.0, lost = 0.0, rubbed = 0.0, given = 0.0, surplus = 0.0;
  double hand_work = 0.0, hand_damped = 0.0;
  double joint_work = 0.0;
  double penetration = 0.0;
  double impulse = 0.0;
  double way = 0.0;
  int active = 0;  // points that push
  // Sum of F h on the body, N s, world: of colliders and of other bodies.
  Eigen::Vector3d impulse_vector = Eigen::Vector3d::Zero();
  int passed = 0;  // points that went through what they should bump into (contact/passage.h)
};

// A contact point of a body that pushed in the last step.
struct ContactedPoint {
  VertexId vertex = 0;       // of the body's mesh
  bool on_body = false;      // the obstacle is a body, else a collider,
  std::size_t obstacle = 0;  // of this number in its group or among the colliders
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  // at the end of the step, m, world
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();    // out of the obstacle, length 1, world
  Eigen::Vector3d impulse = Eigen::Vector3d::Zero();   // on the body in the step, N s, world
};

inline void carry(StateStream& stream, ContactAccount& account) {
  stream(account.energy, account.work, account.lost, account.rubbed, account.given);
  stream(account.surplus, account.hand_work, account.hand_damped, account.penetration);
  stream(account.joint_work);
  stream(account.impulse, account.active, account.way, account.passed, account.impulse_vector);
}

// The spring and the damper by which a hand or a joint holds.
struct HandSpring {
  double stiffness = 0.0;  // N/m
  double damping = 0.0;    // N s/m
};

// A spring stiffer than `most` is replaced by `most` with its damper, or a larger one. In the
// equations of a step of h seconds a damper c has the stiffness 2 c/h, which has the same limit.
inline void limit_spring(const HandSpring& most, double h, double& stiffness, double& damping) {
  if (stiffness > most.stiffness) {
    stiffness = most.stiffness;
    damping = std::max(damping, most.damping);
  }
  damping = std::min(damping, 0.5 * h * most.stiffness);
}

// A hand on a vertex, or in a triangle near it (not at_vertex): a spring of `stiffness` (N/m) and a
// damper (N s/m) from it to a point that moves from `start` to `end` in the step, m, world. place:
// of the vertex. Both are implicit; Body::stiffest_hand() limits them. force: on the body in the
// last step, N, world; the hand feels its opposite. work: on the body in that step, J; of that the
// damper took `damped`, J, where the spring stores energy(), J.
struct Grip {
  VertexId vertex = 0;
  VertexRows place;
  double stiffness = 0.0;
  double damping = 0.0;
  Eigen::Vector3d start = Eigen::Vector3d::Zero(), end = Eigen::Vector3d::Zero();
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  double work = 0.0, damped = 0.0;
  bool at_vertex = true;
};

// modes: r, which what is read must have.
inline void carry(StateStream& stream, Grip& grip, Eigen::Index modes) {
  stream(grip.vertex, grip.stiffness, grip.damping, grip.start, grip.end, grip.force);
  stream(grip.work, grip.damped);
  carry(stream, grip.place, modes);
  stream.require(grip.stiffness >= 0.0 && grip.damping >= 0.0);
}

}  // namespace tremolo
