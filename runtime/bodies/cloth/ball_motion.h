// Rigid balls that fall and rotate, and impulses at contacts.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "common/result.h"
#include "runtime/bodies/cloth/cloth_scene.h"
#include "runtime/bodies/cloth/cloth_world.h"
#include "runtime/math/motion.h"

namespace tremolo {

// A ball in motion.
struct MovingBall {
  ClothWorld::Ball now;
  double radius = 0.0;  // m
  // 1/m and 1/(2/5 m r^2), SI units; 0 for a fixed ball.
  double inverse_mass = 0.0, inverse_inertia = 0.0;
  double friction = 0.0, restitution = 0.0;
  MotionPath path;  // of a fixed ball
  Pose start;
};

// Errors: those of MotionPath::create.
Result<MovingBall> make_ball(const SceneBall& ball);

// Moves a ball from t to t + h: a free ball falls exactly, a fixed one follows its motion.
void move_ball(const Eigen::Vector3d& gravity, double t, double h, MovingBall& ball);

// One side of a contact.
struct ContactSide {
  double inverse_mass = 0.0, inverse_inertia = 0.0;
  Eigen::Vector3d arm = Eigen::Vector3d::Zero();  // from its centre to the contact point, m
  Eigen::Vector3d* velocity = nullptr;            // m/s; null if impulses do not change it
  Eigen::Vector3d* spin = nullptr;                // rad/s; null if impulses do not change it
  // Velocity of the contact point, m/s, for a side without a velocity of its own.
  Eigen::Vector3d surface = Eigen::Vector3d::Zero();
};

// Values of the pair.
struct BallContact {
  // Rest_speed: a slower approach does not rebound, m/s.
  double friction = 0.0, restitution = 0.0, rest_speed = 0.0;
};

// Applies equal and opposite impulses at the contact point; n points from b to a and has length 1.
// They act on the arms of rotating sides: along n by Newton's restitution, across n by Coulomb's
// friction. No impulse if the sides separate. True if there was an impulse.
bool collide(const Eigen::Vector3d& n, const BallContact& touch, ContactSide& a, ContactSide& b);

// The same after a reaction with the impulse `pressed`, N s, has kept the sides apart: the speed
// along n becomes `speed`, m/s, whatever it was, and `pressed` limits Coulomb's friction.
// before: what friction gave a in the step already, N s. Returns all that it gave.
Eigen::Vector3d settle_sides(const Eigen::Vector3d& n, double speed, double pressed,
                             double friction, const Eigen::Vector3d& before, ContactSide& a,
                             ContactSide& b);

}  // namespace tremolo
