#include "runtime/apps/tremolo/world/surface_depth.h"

#include <algorithm>
#include <string>

#include "runtime/contact/solve/contact_points.h"
#include "runtime/contact/solve/contact_step.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

// Velocity of a point fixed to the collider, m/s.
Vector3d velocity_at(const PlacedCollider& collider, const Vector3d& x, double h) {
  const Vector3d local = collider.end.rotation.conjugate() * (x - collider.end.position);
  return (collider.end * local - collider.start * local) / h;
}

// A sphere around the contact points of a body, m, world.
struct Ball {
  Vector3d centre;
  double radius;
};

Ball ball_of(const ContactBody& body) {
  const PresentPlace place = body.present_place();
  const double deformed = body.state().q.cwiseAbs().dot(body.contact()->surface().points->reach);
  return {place.centre, place.radius + deformed};
}

bool feels(const ContactBody& body) {
  return body.contact() != nullptr && body.contact()->surface().feels;
}

}  // namespace

std::span<const std::size_t> NearBodies::of(const SceneWorld& world, std::size_t body) {
  if (steps_ != world.steps()) {
    steps_ = world.steps();
    balls_.clear();
    for (std::size_t i = 0; i < world.size(); ++i) {
      if (!feels(world.body(i))) continue;
      const Ball ball = ball_of(world.body(i));
      balls_.add(i, ball.centre, ball.radius);
    }
    balls_.sort();
  }
  return balls_.of(body);
}

double SurfaceDepth::behind_body(const ContactBody& other, const PresentPlace& place,
                                 const Vector3d& x) {
  const ContactPoints& points = *other.contact()->surface().points;
  const BentShape bent{other.contact()->surface().shape_or_null(), &points, &displacement_};
  const std::optional<Vector3d> y = place.into_rest(x);
  return y ? -bent_distance(bent, *y) : 0.0;
}

double SurfaceDepth::measure(const SceneWorld& world, std::size_t body, NearBodies& near) {
  const ContactBody& own = world.body(body);
  if (!feels(own)) return 0.0;
  positions_.resize(3 * own.model().drawn().rest.size());
  if (!own.surface_positions(positions_)) return 0.0;
  const Eigen::Map<const Eigen::Matrix3Xd> places(positions_.data(), 3,
                                                  static_cast<Eigen::Index>(positions_.size() / 3));
  const Ball ball = ball_of(own);
  double depth = 0.0;
  for (const PlacedCollider& collider : world.colliders()) {
    const Eigen::Matrix3d turn = collider.end.rotation.toRotationMatrix().transpose();
    const auto into = [&](const Vector3d& x) {
      return Vector3d(turn * (x - collider.end.position));
    };
    if (signed_distance(collider.shape, into(ball.centre)).distance > ball.radius) continue;
    for (const auto& x : places.colwise())
      depth = std::max(depth, -signed_distance(collider.shape, into(x)).distance);
  }
  for (const std::size_t i : near.of(world, body)) {
    const ContactBody& other = world.body(i);
    if (!other.contact()->surface().shape || world.passes_through(body, i)) continue;
    const Ball its = ball_of(other);
    const PresentPlace place = other.present_place();
    other.contact()->surface().points->displacement(other.state().q, displacement_);
    for (const auto& x : places.colwise()) {
      if ((x - its.centre).norm() > its.radius) continue;
      depth = std::max(depth, behind_body(other, place, x));
    }
  }
  return depth;
}

double Rebound::speed_away(const SceneWorld& world, std::size_t body) const {
  const RigidState rigid = world.body(body).rigid_state();
  const PlacedCollider& collider = world.colliders()[collider_];
  return normal_.dot(rigid.velocity - velocity_at(collider, rigid.centre, world.step_size()));
}

void Rebound::observe(const SceneWorld& world, std::size_t body) {
  if (phase_ == Phase::kOver || world.body(body).frame() != FrameKind::kFree) return;
  const RigidState rigid = world.body(body).rigid_state();
  if (phase_ == Phase::kBefore) {
    for (const ContactEvent& event : world.events()) {
      if (event.body != body || event.collider == ContactEvent::kNone) continue;
      collider_ = event.collider;
      const PlacedCollider& collider = world.colliders()[collider_];
      normal_ = collider.end.rotation *
                signed_distance(collider.shape, collider.end.rotation.conjugate() *
                                                    (rigid.centre - collider.end.position))
                    .normal;
      arrival_ = normal_.dot(velocity_at(collider, rigid.centre, world.step_size()) - velocity_);
      phase_ = arrival_ > 0.0 ? Phase::kTouching : Phase::kOver;
      break;
    }
    velocity_ = rigid.velocity;
    if (phase_ != Phase::kTouching) return;
  }
  const double away = speed_away(world, body);
  if (away > 0.0) phase_ = Phase::kLeaving;
  if (away <= 0.0 && phase_ == Phase::kLeaving) phase_ = Phase::kOver;
  departure_ = std::max(departure_, away);
}

std::optional<double> Rebound::ratio() const {
  if (!(arrival_ > 0.0)) return std::nullopt;
  return departure_ / arrival_;
}

}  // namespace tremolo
