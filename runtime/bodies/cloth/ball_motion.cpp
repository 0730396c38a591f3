#include "runtime/bodies/cloth/ball_motion.h"

#include <algorithm>

#include "runtime/math/pose.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

Vector3d velocity_of(const ContactSide& side) {
  if (side.velocity == nullptr) return side.surface;
  return side.spin == nullptr ? *side.velocity : *side.velocity + side.spin->cross(side.arm);
}

void push(ContactSide& side, const Vector3d& impulse) {
  if (side.velocity != nullptr) *side.velocity += side.inverse_mass * impulse;
  if (side.spin != nullptr) *side.spin += side.inverse_inertia * side.arm.cross(impulse);
}

}  // namespace

Result<MovingBall> make_ball(const SceneBall& ball) {
  MovingBall made;
  made.radius = ball.radius;
  made.friction = ball.friction;
  made.restitution = ball.restitution;
  made.start.position = ball.position;
  Result<MotionPath> path = MotionPath::create(ball.motion, made.start);
  if (!path) return path.error();
  made.path = std::move(*path);
  made.now = {ball.position, Vector3d::Zero(), Vector3d::Zero(), Eigen::Quaterniond::Identity()};
  if (ball.fixed) return made;
  made.inverse_mass = 1.0 / ball.mass;
  made.inverse_inertia = 2.5 / (ball.mass * ball.radius * ball.radius);
  made.now.velocity = ball.velocity;
  made.now.spin = ball.spin;
  return made;
}

void move_ball(const Vector3d& gravity, double t, double h, MovingBall& ball) {
  ClothWorld::Ball& now = ball.now;
  if (ball.inverse_mass > 0.0) {
    now.position += h * now.velocity + (0.5 * h * h) * gravity;
    now.velocity += h * gravity;
    now.rotation = (turn_by(h * now.spin) * now.rotation).normalized();
    return;
  }
  if (ball.path.still()) return;
  const Pose before = ball.path.pose(t), after = ball.path.pose(t + h);
  now.velocity = (after.position - before.position) / h;
  now.spin = turn_of(after.rotation * before.rotation.conjugate()) / h;
  now.position = after.position;
  now.rotation = after.rotation;
}

bool collide(const Vector3d& n, const BallContact& touch, ContactSide& a, ContactSide& b) {
  const double inverse = a.inverse_mass + b.inverse_mass;
  if (inverse == 0.0) return false;
  const Vector3d relative = velocity_of(a) - velocity_of(b);
  const double speed = relative.dot(n);
  if (!(speed < 0.0)) return false;
  const double rebound = -speed > touch.rest_speed ? touch.restitution : 0.0;
  const double along = -(1.0 + rebound) * speed / inverse;
  const Vector3d slip = relative - speed * n;
  const double slip_speed = slip.norm();
  Vector3d impulse = along * n;
  if (slip_speed > 0.0) {
    const double stop = slip_speed / (inverse + a.arm.squaredNorm() * a.inverse_inertia +
                                      b.arm.squaredNorm() * b.inverse_inertia);
    impulse -= (std::min(touch.friction * along, stop) / slip_speed) * slip;
  }
  push(a, impulse);
  push(b, -impulse);
  return true;
}

Vector3d settle_sides(const Vector3d& n, double speed, double pressed, double friction,
                      const Vector3d& before, ContactSide& a, ContactSide& b) {
  const double inverse = a.inverse_mass + b.inverse_mass;
  if (inverse == 0.0) return Vector3d::Zero();
  const Vector3d relative = velocity_of(a) - velocity_of(b);
  const double along = (speed - relative.dot(n)) / inverse;
  const Vector3d slip = relative - relative.dot(n) * n;
  const double resists =
      inverse + a.arm.squaredNorm() * a.inverse_inertia + b.arm.squaredNorm() * b.inverse_inertia;
  const Vector3d given = before - before.dot(n) * n;
  Vector3d rub = given - slip / resists;  // it would stop the slip
  const double most = friction * std::max(pressed + along, 0.0), size = rub.norm();
  if (size > most) rub *= most / size;
  const Vector3d impulse = along * n + rub - given;
  push(a, impulse);
  push(b, -impulse);
  return rub;
}

}  // namespace tremolo
