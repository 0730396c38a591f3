#include "runtime/bodies/cloth/cloth_contact.h"

#include <algorithm>
#include <cmath>

namespace tremolo {
namespace {

using Eigen::Vector3d;

constexpr int kSweeps = 24;
// From kGroundSweep on, particles on the ground are no longer displaced; from kLastBallSweep on,
// balls.
constexpr int kGroundSweep = 2;
constexpr int kLastBallSweep = 16;
// Distance below which a particle counts as being at its position, m.
constexpr double kNearEnough = 1e-12;

BallContact pair_of(double friction, double other_friction, double restitution,
                    double other_restitution, double rest_speed) {
  return {std::sqrt(friction * other_friction), std::sqrt(restitution * other_restitution),
          rest_speed};
}

// Displacement by `depth` out of a collider, along its normal; a grid's normal may be shorter than
// 1.
Vector3d way_out(const CollisionDistance& found, double depth) {
  const double square = found.normal.squaredNorm();
  return square > 1e-4 ? Vector3d(depth / square * found.normal) : Vector3d::Zero();
}

Vector3d across(const Vector3d& v, const Vector3d& n) {
  return v - v.dot(n) * n;
}

}  // namespace

double friction_time(std::string_view method, double h) {
  if (method == "explicit-euler") return 0.0;
  return method == "symplectic-euler" || method == "implicit-euler-sweep" ? h : 0.5 * h;
}

ContactSide ball_side(MovingBall& ball, const Vector3d& point) {
  ContactSide side{.inverse_mass = ball.inverse_mass,
                   .inverse_inertia = ball.inverse_inertia,
                   .arm = point - ball.now.position};
  if (ball.inverse_mass > 0.0) {
    side.velocity = &ball.now.velocity;
    side.spin = &ball.now.spin;
  } else {
    side.surface = ball.now.velocity + ball.now.spin.cross(side.arm);
  }
  return side;
}

Vector3d surface_velocity(const PlacedCollider& collider, const Vector3d& x, double h) {
  const Vector3d inside = collider.end.rotation.conjugate() * (x - collider.end.position);
  return (x - collider.start * inside) / h;
}

CollisionDistance distance_at_end(const PlacedCollider& collider, const Vector3d& x) {
  const Pose& pose = collider.end;
  CollisionDistance found =
      signed_distance(collider.shape, pose.rotation.conjugate() * (x - pose.position));
  found.normal = pose.rotation * found.normal;
  return found;
}

void ClothContact::cloth_colliders(ContactCloth& cloth, Pass& pass) const {
  const std::span<const std::uint8_t> held = cloth.model->held();
  for (std::size_t i = 0; i < held.size(); ++i) {
    if (held[i] != 0) continue;
    const auto at = 3 * static_cast<Eigen::Index>(i);
    for (std::size_t c = 0; c < pass.colliders.size(); ++c) {
      const PlacedCollider& collider = pass.colliders[c];
      Vector3d x = cloth.state->x.segment<3>(at);
      const CollisionDistance found = distance_at_end(collider, x);
      pass.nearest = std::min(pass.nearest, found.distance);
      const double depth = cloth.thickness - found.distance;
      if (!(depth > kNearEnough)) continue;
      x += way_out(found, depth);
      cloth.state->x.segment<3>(at) = x;
      cloth.grounded[i] = 1;
      Vector3d v = cloth.state->v.segment<3>(at);
      ContactSide particle{.inverse_mass = 1.0 / cloth.model->mass()[i], .velocity = &v};
      ContactSide ground{.surface = surface_velocity(collider, x, pass.h)};
      const Vector3d n = found.normal.normalized();
      collide(n,
              pair_of(cloth.friction, collider.friction, cloth.restitution, collider.restitution,
                      pass.rest_speed),
              particle, ground);
      const Vector3d change = v - cloth.state->v.segment<3>(at);
      cloth.state->x.segment<3>(at) += cloth.friction_time * across(change, n);
      cloth.state->v.segment<3>(at) = v;
      cloth.touched = pass.moved = true;
    }
  }
}

void ClothContact::cloth_ball(ContactCloth& cloth, MovingBall& ball, Pass& pass) const {
  const std::span<const std::uint8_t> held = cloth.model->held();
  const double reach = ball.radius + cloth.thickness - kNearEnough;
  for (std::size_t i = 0; i < held.size(); ++i) {
    const auto at = 3 * static_cast<Eigen::Index>(i);
    Vector3d x = cloth.state->x.segment<3>(at);
    const double square = (x - ball.now.position).squaredNorm();
    if (!(square < reach * reach)) continue;
    const bool free = held[i] == 0;
    if (!free && (ball.inverse_mass == 0.0 || pass.sweep >= kLastBallSweep)) continue;
    const double distance = std::sqrt(square);
    if (free) pass.nearest = std::min(pass.nearest, distance - ball.radius);
    const Vector3d n =
        distance > 0.0 ? Vector3d((x - ball.now.position) / distance) : Vector3d::UnitZ();
    const double inverse = free ? 1.0 / cloth.model->mass()[i] : 0.0;
    // The parts that are displaced, and their fractions.
    const bool grounded =
        !free || (pass.sweep >= kGroundSweep && cloth.grounded[i] != 0 && ball.inverse_mass > 0.0);
    const bool stays = ball.inverse_mass == 0.0 || pass.sweep >= kLastBallSweep;
    const double share = stays ? 1.0 : grounded ? 0.0 : inverse / (inverse + ball.inverse_mass);
    const double depth = ball.radius + cloth.thickness - distance;
    x += share * depth * n;
    ball.now.position -= (1.0 - share) * depth * n;
    if (ball.inverse_mass == 0.0) cloth.grounded[i] = 1;
    Vector3d v = cloth.state->v.segment<3>(at);
    ContactSide particle{.inverse_mass = inverse, .surface = v};
    if (free) particle.velocity = &v;
    ContactSide other = ball_side(ball, x);
    collide(n,
            pair_of(cloth.friction, ball.friction, cloth.restitution, ball.restitution,
                    pass.rest_speed),
            particle, other);
    if (free) {
      const Vector3d change = v - cloth.state->v.segment<3>(at);
      cloth.state->x.segment<3>(at) = x + cloth.friction_time * across(change, n);
      cloth.state->v.segment<3>(at) = v;
      cloth.touched = true;
    }
    pass.moved = true;
  }
}

void ClothContact::ball_collider(MovingBall& ball, const PlacedCollider& collider,
                                 Pass& pass) const {
  if (ball.inverse_mass == 0.0) return;
  const CollisionDistance found = distance_at_end(collider, ball.now.position);
  const double depth = ball.radius - found.distance;
  if (!(depth > kNearEnough)) return;
  ball.now.position += way_out(found, depth);
  const Vector3d n = found.normal.normalized();
  const Vector3d point = ball.now.position - ball.radius * n;
  ContactSide side = ball_side(ball, point);
  ContactSide ground{.surface = surface_velocity(collider, point, pass.h)};
  const BallContact pair = pair_of(ball.friction, collider.friction, ball.restitution,
                                   collider.restitution, pass.rest_speed);
  // A ball that rebounds met the surface on its way down to `depth`, and has gone up since.
  const double fall = -pass.gravity.dot(n), speed = -n.dot(ball.now.velocity - ground.surface);
  const bool falls = speed > pair.rest_speed;
  const double met = falls ? std::sqrt(std::max(0.0, speed * speed - 2.0 * fall * depth)) : speed;
  ball.now.velocity += (speed - met) * n;
  collide(n, pair, side, ground);
  pass.moved = true;
  if (!falls || !(met > pair.rest_speed)) return;
  const double since = std::min(pass.h, 2.0 * depth / (speed + met));
  const double height = (pair.restitution * met - 0.5 * fall * since) * since;
  if (!(height > 0.0)) return;
  ball.now.position += height * n;
  ball.now.velocity -= fall * since * n;
}

void ClothContact::ball_ball(MovingBall& a, MovingBall& b, Pass& pass) const {
  const double inverse = a.inverse_mass + b.inverse_mass;
  const Vector3d apart = a.now.position - b.now.position;
  const double distance = apart.norm(), depth = a.radius + b.radius - distance;
  if (inverse == 0.0 || !(depth > kNearEnough)) return;
  const Vector3d n = distance > 0.0 ? Vector3d(apart / distance) : Vector3d::UnitZ();
  const Vector3d point = b.now.position + (b.radius - 0.5 * depth) * n;
  ContactSide one = ball_side(a, point), other = ball_side(b, point);
  collide(n, pair_of(a.friction, b.friction, a.restitution, b.restitution, pass.rest_speed), one,
          other);
  a.now.position += a.inverse_mass / inverse * depth * n;
  b.now.position -= b.inverse_mass / inverse * depth * n;
  pass.moved = true;
}

ContactReport ClothContact::project(std::span<ContactCloth> cloths, std::span<MovingBall> balls,
                                    std::span<const PlacedCollider> colliders,
                                    const Vector3d& gravity, double h) {
  ContactReport report;
  if (balls.empty() && colliders.empty()) return report;
  // The speed that gravity adds in a step does not count as a fall.
  Pass pass{
      .colliders = colliders, .h = h, .rest_speed = 2.0 * h * gravity.norm(), .gravity = gravity};
  for (ContactCloth& cloth : cloths) {
    cloth.touched = false;
    std::fill(cloth.grounded.begin(), cloth.grounded.end(), std::uint8_t{0});
  }
  for (; pass.sweep < kSweeps; ++pass.sweep) {
    pass.moved = false;
    pass.nearest = 0.0;
    if (pass.sweep < kLastBallSweep) {
      for (std::size_t i = 0; i < balls.size(); ++i)
        for (std::size_t k = i + 1; k < balls.size(); ++k) ball_ball(balls[i], balls[k], pass);
      for (MovingBall& ball : balls)
        for (const PlacedCollider& collider : colliders) ball_collider(ball, collider, pass);
    }
    for (ContactCloth& cloth : cloths) {
      for (MovingBall& ball : balls) cloth_ball(cloth, ball, pass);
      cloth_colliders(cloth, pass);
    }
    if (!pass.moved) break;
    report.touched = true;
  }
  report.penetration = -pass.nearest;
  return report;
}

}  // namespace tremolo
