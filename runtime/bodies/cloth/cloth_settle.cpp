// Before and after the solves of an implicit step: reactions on particles (ClothReactions), their
// impulses on balls, friction and restitution; contact must add no energy.
#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

#include "runtime/bodies/cloth/cloth_world_inside.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

Vector3d ball_velocity_at(const MovingBall& ball, const Vector3d& x) {
  return ball.now.velocity + ball.now.spin.cross(x - ball.now.position);
}

bool stands(const PlacedCollider& collider) {
  return collider.start.position == collider.end.position &&
         collider.start.rotation.coeffs() == collider.end.rotation.coeffs();
}

}  // namespace

bool ClothWorld::Inside::solves_steps() const {
  return std::isinf(stability_number(scene.integrator)) || scene.integrator == "imex";
}

void ClothWorld::Inside::begin_contact(double t, double h) {
  around.h = h;
  around.colliders = colliders.placed();
  for (std::size_t b = 0; b < balls.size(); ++b) {
    MovingBall moved = balls[b];
    move_ball(gravity, t, h, moved);
    BallInStep& way = around.ways[b];
    way.start = balls[b].now.position;
    way.free_end = moved.now.position;
    way.give = 0.5 * h * h * balls[b].inverse_mass;
    way.missed = false;
    way.end = way.give > 0.0
                  ? clear_of(around.colliders, balls[b].radius, way.free_end + way.give * way.push)
                  : way.free_end;
  }
  for (const auto& cloth : cloths) cloth->reactions->begin(cloth->state);
}

// The reactions' impulses on balls. Their positions are those of the mean of their velocities.
void ClothWorld::Inside::push_balls(double h) {
  for (const auto& cloth : cloths)
    for (const ClothReaction& r : cloth->reactions->all()) {
      if (r.touch.ball == ParticleTouch::kNone || r.impulse.isZero(0.0)) continue;
      MovingBall& ball = balls[r.touch.ball];
      if (ball.inverse_mass == 0.0) continue;
      const Vector3d impulse = r.impulse + r.rubbed;
      const Vector3d change = -ball.inverse_mass * impulse;
      // The impulse changes angular momentum as if it acted at (x0 + x1)/2 on a body that moves
      // from x0 to x1 at the mean of its velocities: the particle under the midpoint rule, and the
      // ball.
      const auto at = 3 * static_cast<Eigen::Index>(r.particle);
      const auto& way = around.ways[r.touch.ball];
      const Vector3d arm = 0.5 * (cloth->before.x.segment<3>(at) + cloth->state.x.segment<3>(at) -
                                  way.start - way.end);
      ball.now.velocity += change;
      ball.now.position -= 0.5 * h * change;
      ball.now.spin -= ball.inverse_inertia * arm.cross(impulse);
    }
}

// Along the normal a particle stays on the obstacle or leaves by restitution; friction acts across
// it.
void ClothWorld::Inside::settle(WorldCloth& cloth, std::size_t number, double h) {
  const ClothReaction& r = cloth.reactions->all()[number];
  const Eigen::Index at = r.particle;
  const Vector3d x = cloth.state.x.segment<3>(3 * at);
  Vector3d v = cloth.state.v.segment<3>(3 * at), surface = Vector3d::Zero();
  ContactSide particle{.inverse_mass = 1.0 / cloth.model.mass()[at], .velocity = &v}, other;
  double friction = 0.0, restitution = 0.0;
  Vector3d normal = r.normal;
  if (r.touch.ball != ParticleTouch::kNone) {
    MovingBall& ball = balls[r.touch.ball];
    normal = (x - ball.now.position).normalized();
    other = ball_side(ball, x);
    surface = ball_velocity_at(ball, x);
    friction = ball.friction;
    restitution = ball.restitution;
  } else {
    const PlacedCollider& collider = colliders.placed()[r.touch.collider];
    normal = distance_at_end(collider, x).normal.normalized();
    surface = other.surface = surface_velocity(collider, x, h);
    friction = collider.friction;
    restitution = collider.restitution;
  }
  const double arrival = -normal.dot(cloth.before.v.segment<3>(3 * at) - surface);
  const double rebound = arrival > 2.0 * h * gravity.norm()
                             ? arrival * std::sqrt(restitution * cloth.scene.restitution)
                             : 0.0;
  const Vector3d rub =
      settle_sides(normal, rebound, r.impulse.norm(), std::sqrt(friction * cloth.scene.friction),
                   r.rubbed, particle, other);
  cloth.reactions->remember_friction(number, rub);
  cloth.state.v.segment<3>(3 * at) = v;
  cloth.touched = true;
}

// True if any reaction acted.
bool ClothWorld::Inside::settle_all(double h) {
  bool any = false;
  for (std::size_t c = 0; c < cloths.size(); ++c) {
    const std::span<const ClothReaction> all = cloths[c]->reactions->all();
    for (std::size_t i = 0; i < all.size(); ++i)
      if (!all[i].impulse.isZero(0.0)) settle(*cloths[c], i, h);
    any = any || cloths[c]->touched;
  }
  return any;
}

// True if only cloths and free balls move: prescribed motion may do work.
bool ClothWorld::Inside::stands_still() const {
  for (std::size_t b = 0; b < balls.size(); ++b)
    if (balls[b].inverse_mass == 0.0 && around.ways[b].start != around.ways[b].end) return false;
  const auto placed = colliders.placed();
  return std::all_of(placed.begin(), placed.end(), stands);
}

namespace {

// The rigid motion that has the momenta of a cloth's free particles: at x the velocity is velocity
// + turning x (x - centre). Particles in a line do not rotate about it.
struct RigidMotion {
  Vector3d centre = Vector3d::Zero(), velocity = Vector3d::Zero(), turning = Vector3d::Zero();

  Vector3d at(const Vector3d& x) const { return velocity + turning.cross(x - centre); }
};

// Calls a function with the mass, the position and the velocity of each free particle.
template <class Act>
void each_free_particle(WorldCloth& cloth, Act&& act) {
  for (std::size_t i = 0; i < cloth.model.size(); ++i)
    if (cloth.model.held()[i] == 0)
      act(cloth.model.mass()[i], cloth.state.x.segment<3>(3 * i), cloth.state.v.segment<3>(3 * i));
}

RigidMotion rigid_motion(WorldCloth& cloth) {
  RigidMotion motion;
  double total = 0.0;
  each_free_particle(cloth, [&](double mass, const auto& x, const auto& v) {
    total += mass;
    motion.centre += mass * x;
    motion.velocity += mass * v;
  });
  if (total == 0.0) return motion;
  motion.centre /= total;
  motion.velocity /= total;
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
  Vector3d spin = Vector3d::Zero();
  each_free_particle(cloth, [&](double mass, const auto& x, const auto& v) {
    const Vector3d arm = x - motion.centre;
    inertia += mass * (arm.squaredNorm() * Eigen::Matrix3d::Identity() - arm * arm.transpose());
    spin += mass * arm.cross(v - motion.velocity);
  });
  constexpr double kLeastInertia = 1e-12;  // relative to the largest: below this it is rounding
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(inertia);
  for (int k = 0; k < 3; ++k)
    if (axes.eigenvalues()[k] > kLeastInertia * axes.eigenvalues()[2])
      motion.turning +=
          axes.eigenvectors().col(k) * axes.eigenvectors().col(k).dot(spin) / axes.eigenvalues()[k];
  return motion;
}

}  // namespace

// If a step with contact ends with more energy than it started with and was given, the excess is
// taken from the motion of the cloths in contact relative to rigid_motion(). That relative motion
// has neither momentum nor angular momentum, so that shrinking it conserves both, and its energy
// and that of the rigid motion add up. Returns the energy that was taken, J.
double ClothWorld::Inside::take_excess(double excess) {
  double motion = 0.0;
  for (const auto& cloth : cloths) {
    if (!cloth->touched) continue;
    const RigidMotion rigid = rigid_motion(*cloth);
    each_free_particle(*cloth, [&](double mass, const auto& x, const auto& v) {
      motion += 0.5 * mass * (v - rigid.at(x)).squaredNorm();
    });
  }
  if (!(motion > 0.0)) return 0.0;
  const double left = std::sqrt(std::max(0.0, 1.0 - excess / motion));
  for (const auto& cloth : cloths) {
    if (!cloth->touched) continue;
    const RigidMotion rigid = rigid_motion(*cloth);
    each_free_particle(*cloth, [&](double, const auto& x, auto&& v) {
      const Vector3d kept = rigid.at(x);
      v = kept + left * (v - kept);
    });
  }
  return std::min(excess, motion);
}

}  // namespace tremolo
