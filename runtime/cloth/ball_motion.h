// Rigid balls that fall and turn, and impulses between what touches.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "common/result.h"
#include "runtime/cloth/cloth_scene.h"
#include "runtime/cloth/cloth_world.h"
#include "runtime/scene/motion.h"

namespace tremolo {

// A ball on its way. inverse_mass, inverse_inertia (2/5 m r^2): 0 of one that is fixed.
struct MovingBall {
  ClothWorld::Ball now;
  double radius = 0.0;
  double inverse_mass = 0.0, inverse_inertia = 0.0;
  double friction = 0.0, restitution = 0.0;
  MotionPath path;
  Pose start;
};

// Errors: those of MotionPath::create.
Result<MovingBall> make_ball(const SceneBall& ball);

// From t to t + h: free ones fall exactly, fixed ones go as their motion does.
void move_ball(const Eigen::Vector3d& gravity, double t, double h, MovingBall& ball);

// One side of a contact. velocity, spin: none where it does not move by impulses. arm: from its
// centre to the point that touches, m. surface: that point's velocity, m/s, where it has no own.
struct ContactSide {
  double inverse_mass = 0.0, inverse_inertia = 0.0;
  Eigen::Vector3d arm = Eigen::Vector3d::Zero();
  Eigen::Vector3d* velocity = nullptr;
  Eigen::Vector3d* spin = nullptr;
  Eigen::Vector3d surface = Eigen::Vector3d::Zero();
};

// Those of the pair. rest_speed: approach below this does not rebound, m/s.
struct BallContact {
  double friction = 0.0, restitution = 0.0, rest_speed = 0.0;
};

// Equal and opposite impulses at the point where both touch, n from b to a, of length 1, along the
// arms of what turns: along n as Newton's restitution has it, across n by Coulomb's friction. Where
// they part nothing is done. True if there was an impulse.
bool collide(const Eigen::Vector3d& n, const BallContact& touch, ContactSide& a, ContactSide& b);

// The same for what a reaction of `pressed`, N s, has already kept apart: the speed along n becomes
// `speed`, m/s, whichever it was, and Coulomb's friction is of all that presses.
void settle_sides(const Eigen::Vector3d& n, double speed, double pressed, double friction,
                  ContactSide& a, ContactSide& b);

}  // namespace tremolo
