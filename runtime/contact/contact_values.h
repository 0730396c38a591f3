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

// How a body feels contact. points: at most so many of its boundary's vertices. margin: where
// contact begins, as a share of the body's extent. stiffness: of the contact, as (h omega)^2 of the
// whole body on one point at the depth of the margin; larger: less penetration, and shorter
// contacts than the step resolves. shape: what other bodies' points bump into, in the mesh's
// coordinates at rest; without one they pass through. friction, restitution: towards other bodies,
// of a pair the geometric means. colliders: false: it feels hands alone.
struct ContactOptions {
  int points = 200;
  double margin = 0.005;
  double stiffness = 16.0;
  std::optional<Collider> shape = {};
  double friction = 0.3;
  double restitution = 0.5;
  bool colliders = true;
};

// Where the body's mesh frame is in the step. Of a free body `end` is a prediction.
struct StepPoses {
  Pose start, end;
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
  int passed = 0;  // points that went through what they should bump into (contact/passage.h)
};

inline void carry(StateStream& stream, ContactAccount& account) {
  stream(account.energy, account.work, account.lost, account.rubbed, account.given);
  stream(account.surplus, account.hand_work, account.hand_damped, account.penetration);
  stream(account.joint_work);
  stream(account.impulse, account.active, account.way, account.passed);
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
