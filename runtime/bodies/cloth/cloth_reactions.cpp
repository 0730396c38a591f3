#include "runtime/bodies/cloth/cloth_reactions.h"

#include <algorithm>
#include <cmath>

namespace tremolo {
namespace {

using Eigen::Vector3d;

// m: a particle nearer to its position than this is there.
constexpr double kThere = 1e-6;
// The stiffness of a reaction divided by the particle's effective stiffness in a step.
constexpr double kReactionShare = 30.0;
constexpr double kLeastRelaxed = 0.02;
// A shorter gradient of a collider's distance has no direction.
constexpr double kNoDirection = 1e-4;
constexpr std::size_t kMostKnown = 64;

Vector3d particle_at(const Eigen::VectorXd& x, std::size_t particle) {
  return x.segment<3>(3 * static_cast<Eigen::Index>(particle));
}

std::uint64_t bit_of(const ParticleTouch& touch, std::size_t balls) {
  const std::size_t number =
      touch.ball != ParticleTouch::kNone ? touch.ball : balls + touch.collider;
  return std::uint64_t{1} << number;
}

}  // namespace

Vector3d clear_of(std::span<const PlacedCollider> colliders, double radius, const Vector3d& x) {
  Vector3d clear = x;
  for (const PlacedCollider& collider : colliders) {
    const CollisionDistance found = distance_at_end(collider, clear);
    const double square = found.normal.squaredNorm();
    if (found.distance < radius && square > kNoDirection)
      clear += (radius - found.distance) / square * found.normal;
  }
  return clear;
}

ClothReactions::ClothReactions(const ClothModel& model, ClothSurroundings& around, double thickness,
                               double friction)
    : model_(model),
      around_(around),
      thickness_(thickness),
      friction_(friction),
      pressed_(model.size(), 0),
      pushes_(around.balls.size(), Vector3d::Zero()),
      ahead_(Eigen::VectorXd::Zero(model.parts().x.size())) {
  reactions_.reserve(2 * model.size());
}

double ClothReactions::stiffness_of(std::size_t particle) const {
  const double h = around_.h, mass = model_.mass()[particle];
  return kReactionShare * (4.0 * mass / (h * h) + 8.0 * model_.structural().law().stiffness);
}

// Pose at the end of the step.
CollisionDistance ClothReactions::nearest(const ParticleTouch& touch, const Vector3d& x) const {
  if (touch.collider != ParticleTouch::kNone)
    return distance_at_end(around_.colliders[touch.collider], x);
  const Vector3d apart = x - around_.ways[touch.ball].end;
  const double length = apart.norm();
  return {length - around_.balls[touch.ball].radius,
          length > 0.0 ? Vector3d(apart / length) : Vector3d::UnitZ()};
}

// Displacement of the obstacle in the step at x0, m.
Vector3d ClothReactions::way_of(const ParticleTouch& touch, const Vector3d& x0) const {
  if (touch.collider != ParticleTouch::kNone) {
    const PlacedCollider& collider = around_.colliders[touch.collider];
    return collider.end * (collider.start.rotation.conjugate() * (x0 - collider.start.position)) -
           x0;
  }
  return around_.ways[touch.ball].end - around_.ways[touch.ball].start;
}

// Finds p and m; returns the depth of x1 inside, m.
double ClothReactions::aim(ClothReaction& reaction, const Vector3d& x0, const Vector3d& x1) const {
  const CollisionDistance found = nearest(reaction.touch, x1);
  if (found.normal.squaredNorm() < kNoDirection) return 0.0;
  const Vector3d normal = found.normal.normalized();
  const double depth = thickness_ - found.distance;
  const Vector3d middle = 0.5 * (x0 + way_of(reaction.touch, x0) + x1);
  const Vector3d halfway = nearest(reaction.touch, middle).normal;
  reaction.normal = normal;
  if (halfway.squaredNorm() > kNoDirection && halfway.normalized().dot(normal) > 0.5)
    reaction.normal = halfway.normalized();
  reaction.place = x1 + depth * normal;
  return depth;
}

bool ClothReactions::add_what_is_inside(const Eigen::VectorXd& x0, const Eigen::VectorXd& x1) {
  const std::size_t balls = around_.balls.size();
  const std::size_t known = std::min(balls + around_.colliders.size(), kMostKnown);
  const std::span<const std::uint8_t> held = model_.held();
  bool any = false;
  for (std::size_t i = 0; i < held.size(); ++i) {
    if (held[i] != 0) continue;
    const Vector3d place = particle_at(x1, i);
    for (std::size_t k = 0; k < known; ++k) {
      if ((pressed_[i] >> k & 1U) != 0) continue;
      ParticleTouch touch;
      (k < balls ? touch.ball : touch.collider) = k < balls ? k : k - balls;
      const CollisionDistance found = nearest(touch, place);
      if (!(found.distance < thickness_ - kThere)) continue;
      if (found.normal.squaredNorm() < kNoDirection) continue;
      if (reactions_.size() == reactions_.capacity()) return any;
      ClothReaction reaction{.particle = i, .touch = touch, .stiffness = stiffness_of(i)};
      aim(reaction, particle_at(x0, i), place);
      reactions_.push_back(reaction);
      pressed_[i] |= std::uint64_t{1} << k;
      any = true;
    }
  }
  return any;
}

void ClothReactions::begin(const NodalState& state) {
  round_ = 0;
  const double h = around_.h;
  ahead_ = state.x + h * state.v;
  for (std::size_t i = 0; i < model_.size(); ++i)
    ahead_.segment<3>(3 * static_cast<Eigen::Index>(i)) += (h * h) * model_.gravity();
  std::erase_if(reactions_, [&](const ClothReaction& r) {
    if (r.presses && model_.held()[r.particle] == 0) return false;
    if (r.presses) pressed_[r.particle] &= ~bit_of(r.touch, around_.balls.size());
    return true;
  });
  for (ClothReaction& r : reactions_) {
    r.impulse.setZero();
    r.rubbed.setZero();
    r.rub_time = 0.0;
    aim(r, particle_at(state.x, r.particle), particle_at(ahead_, r.particle));
  }
  add_what_is_inside(state.x, ahead_);
}

bool ClothReactions::let_go() {
  bool any = false;
  for (ClothReaction& r : reactions_) {
    if (!r.presses || r.force >= 0.0) continue;
    any = true;
    r.presses = false;
    r.force = 0.0;
    r.rub.setZero();
    pressed_[r.particle] &= ~bit_of(r.touch, around_.balls.size());
  }
  return any;
}

// Known friction is no larger than mu times what presses now.
bool ClothReactions::limit_friction() {
  constexpr double kAbove = 1.0 + 1e-6;
  bool any = false;
  for (ClothReaction& r : reactions_) {
    if (!r.presses || r.rub.isZero(0.0)) continue;
    const double other = r.touch.ball != ParticleTouch::kNone
                             ? around_.balls[r.touch.ball].friction
                             : around_.colliders[r.touch.collider].friction;
    const double most = std::sqrt(friction_ * other) * r.force, size = r.rub.norm();
    if (size <= kAbove * most) continue;
    r.rub *= most / size;
    any = true;
  }
  return any;
}

// The ends of balls depend on the forces on them, and these on the ends: Aitken's relaxation.
bool ClothReactions::move_balls(double share) {
  bool any = false;
  for (std::size_t b = 0; b < pushes_.size(); ++b) {
    BallInStep& way = around_.ways[b];
    if (way.give == 0.0) continue;
    Vector3d push = Vector3d::Zero();
    for (const ClothReaction& r : reactions_)
      if (r.presses && r.touch.ball == b) push -= r.force * r.normal + r.rub;
    way.push += push - pushes_[b];
    pushes_[b] = push;
    const Vector3d wanted = clear_of(around_.colliders, around_.balls[b].radius,
                                     way.free_end + share * way.give * way.push);
    const Vector3d miss = wanted - way.end;
    if (miss.norm() <= kThere) continue;
    if (way.missed) {
      const Vector3d change = miss - way.miss;
      const double next = -way.relaxed * way.miss.dot(change) / change.squaredNorm();
      way.relaxed = next > 0.0 ? std::clamp(next, kLeastRelaxed, 1.0) : 0.5 * way.relaxed;
    }
    way.miss = miss;
    way.missed = true;
    way.end += way.relaxed * miss;
    any = true;
  }
  return any;
}

bool ClothReactions::revise(const Eigen::VectorXd& x0, const Eigen::VectorXd& x1, double share) {
  for (ClothReaction& r : reactions_)
    if (r.presses) r.force = r.force_at(x1);
  // The forces are then those of the present positions.
  const auto settle = [&] {
    for (ClothReaction& r : reactions_)
      if (r.presses) r.place = particle_at(x1, r.particle);
  };
  if (round_ >= kRounds) {
    settle();
    return false;
  }
  ++round_;
  for (ClothReaction& r : reactions_) r.solved_normal = r.normal;
  bool changed = let_go();
  changed = limit_friction() || changed;
  changed = move_balls(share) || changed;
  for (ClothReaction& r : reactions_)
    if (r.presses)
      changed =
          std::abs(aim(r, particle_at(x0, r.particle), particle_at(x1, r.particle))) > kThere ||
          changed;
  if (round_ <= kAddingRounds) changed = add_what_is_inside(x0, x1) || changed;
  if (!changed) {
    // The solve used the normals of the round before.
    for (ClothReaction& r : reactions_) r.normal = r.solved_normal;
    settle();
  }
  return changed;
}

void ClothReactions::add_force(const Eigen::VectorXd& x1, Eigen::VectorXd& f) const {
  for (const ClothReaction& r : reactions_)
    if (r.presses)
      f.segment<3>(3 * static_cast<Eigen::Index>(r.particle)) += r.force_at(x1) * r.normal + r.rub;
}

void ClothReactions::add_tangent(BlockMatrix& a) const {
  for (const ClothReaction& r : reactions_)
    if (r.presses) a.diagonal(r.particle) += (r.stiffness * r.normal) * r.normal.transpose();
}

double ClothReactions::work(const Eigen::VectorXd& x0, const Eigen::VectorXd& x1,
                            double share) const {
  double work = 0.0;
  for (const ClothReaction& r : reactions_)
    if (r.presses)
      work += share * (r.force_at(x1) * r.normal + r.rub)
                          .dot(particle_at(x1, r.particle) - particle_at(x0, r.particle));
  return work;
}

void ClothReactions::keep(const Eigen::VectorXd& x1, double h, double share) {
  pressed_last_ = false;
  for (ClothReaction& r : reactions_) {
    if (!r.presses) continue;
    const double force = r.force_at(x1);
    r.impulse += share * h * force * r.normal;
    r.rubbed += share * h * r.rub;
    r.rub_time += share * h;
    pressed_last_ = pressed_last_ || force != 0.0;
  }
}

}  // namespace tremolo
