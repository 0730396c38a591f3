// Contact by projection at the end of a step: particles and balls are put where nothing is inside
// anything, and get the impulses of runtime/cloth/ball_motion.h.
//
// Sweeps go over all pairs until none is too near. Of two that move, each gives way by the inverse
// of its mass; from the third sweep on, particles that lie on something that does not move give way
// no more, so that a heavy ball comes to lie on cloth that lies on the ground.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "runtime/cloth/ball_motion.h"
#include "runtime/cloth/cloth_model.h"
#include "runtime/contact/contact_law.h"
#include "runtime/nodal/nodal_integrator.h"

namespace tremolo {

// touched: it was moved or pushed in this step. grounded: a flag a particle.
struct ContactCloth {
  const ClothModel* model = nullptr;
  NodalState* state = nullptr;
  double thickness = 0.0, friction = 0.0, restitution = 0.0;
  bool touched = false;
  std::vector<std::uint8_t> grounded;
};

// touched: anything was. penetration: of the deepest particle at the end, m, 0 where none is
// inside.
struct ContactReport {
  bool touched = false;
  double penetration = 0.0;
};

class ClothContact {
 public:
  // What lies in the step's end: colliders where they end, h the step, s. Nothing is allocated.
  ContactReport project(std::span<ContactCloth> cloths, std::span<MovingBall> balls,
                        std::span<const PlacedCollider> colliders, const Eigen::Vector3d& gravity,
                        double h);

 private:
  // What the pairs of a step share.
  struct Pass {
    std::span<const PlacedCollider> colliders;
    double h = 0.0, rest_speed = 0.0;
    int sweep = 0;
    bool moved = false;
    double nearest = 0.0;  // m, the most negative distance
  };

  void cloth_colliders(ContactCloth& cloth, Pass& pass) const;
  void cloth_ball(ContactCloth& cloth, MovingBall& ball, Pass& pass) const;
  void ball_collider(MovingBall& ball, const PlacedCollider& collider, Pass& pass) const;
  void ball_ball(MovingBall& a, MovingBall& b, Pass& pass) const;
};

// A ball as one side of a contact at a point.
ContactSide ball_side(MovingBall& ball, const Eigen::Vector3d& point);

// The velocity of a collider's surface at a point of the world, at the end of the step.
Eigen::Vector3d surface_velocity(const PlacedCollider& collider, const Eigen::Vector3d& x,
                                 double h);

// Distance of a point of the world to a collider where it ends its step; its normal in the world.
CollisionDistance distance_at_end(const PlacedCollider& collider, const Eigen::Vector3d& x);

}  // namespace tremolo
