// Contact by projection at the end of a step: particles and balls are moved out of each other and
// of colliders, and get the impulses of runtime/bodies/cloth/ball_motion.h.
//
// Sweeps check all pairs until none is too near. Of two moving partners each is displaced by the
// inverse of its mass. From the third sweep on, particles on a fixed obstacle are no longer
// displaced, so that a heavy ball comes to rest on cloth that lies on the ground.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "runtime/bodies/cloth/ball_motion.h"
#include "runtime/bodies/cloth/cloth_model.h"
#include "runtime/contact/contact_law.h"
#include "runtime/step/nodal_integrator.h"

namespace tremolo {

// A cloth in contact.
struct ContactCloth {
  const ClothModel* model = nullptr;
  NodalState* state = nullptr;
  // thickness: m.
  double thickness = 0.0, friction = 0.0, restitution = 0.0;
  // By how much a change of velocity in this step changes positions, s: friction_time().
  double friction_time = 0.0;
  bool touched = false;                // it was moved or pushed in this step
  std::vector<std::uint8_t> grounded;  // one flag per particle: it lies on a fixed obstacle
};

// Result of the projection.
struct ContactReport {   // any cloth or ball was moved
  bool touched = false;  // of the deepest particle at the end, m; 0 if none is inside
  double penetration = 0.0;
};

class ClothContact {
 public:
  // Projects at the end of a step of h, s; colliders are at their end poses. Allocates nothing.
  ContactReport project(std::span<ContactCloth> cloths, std::span<MovingBall> balls,
                        std::span<const PlacedCollider> colliders, const Eigen::Vector3d& gravity,
                        double h);

 private:
  // Data for all pairs of a step.
  struct Pass {
    std::span<const PlacedCollider> colliders;
    double h = 0.0, rest_speed = 0.0;
    Eigen::Vector3d gravity = Eigen::Vector3d::Zero();  // m/s^2
    int sweep = 0;
    bool moved = false;
    double nearest = 0.0;  // the most negative distance, m
  };

  void cloth_colliders(ContactCloth& cloth, Pass& pass) const;
  void cloth_ball(ContactCloth& cloth, MovingBall& ball, Pass& pass) const;
  void ball_collider(MovingBall& ball, const PlacedCollider& collider, Pass& pass) const;
  void ball_ball(MovingBall& a, MovingBall& b, Pass& pass) const;
};

// Explicit methods move particles by x1 = x0 + h (w v1 + (1 - w) v0). Friction is an impulse of the
// step and changes velocities after it; the positions change by this time, s, times that change.
// A particle that sticks would else move by w h^2 times its acceleration in each step.
double friction_time(std::string_view method, double h);

// A ball as one side of a contact at a point.
ContactSide ball_side(MovingBall& ball, const Eigen::Vector3d& point);

// The velocity of a collider's surface at a point of the world, at the end of the step.
Eigen::Vector3d surface_velocity(const PlacedCollider& collider, const Eigen::Vector3d& x,
                                 double h);

// Distance of a point of the world to a collider at the end of its step; the normal is in the
// world.
CollisionDistance distance_at_end(const PlacedCollider& collider, const Eigen::Vector3d& x);

}  // namespace tremolo
