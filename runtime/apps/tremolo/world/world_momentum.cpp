#include "runtime/apps/tremolo/world/world_momentum.h"

#include <algorithm>

#include "runtime/bodies/reduced/frames/frame_inertia.h"

namespace tremolo {

using Eigen::Vector3d;

WorldMomentum::Impulses WorldMomentum::impulses_of(const ContactBody& body) {
  Impulses impulses;
  impulses.all = body.contact_account().impulse_vector;
  if (body.contact() != nullptr)
    for (const Vector3d& on_collider : body.contact()->record().collider_impulses)
      impulses.of_colliders -= on_collider;
  for (const Grip& grip : body.grips()) impulses.hands += body.options().step * grip.force;
  return impulses;
}

void WorldMomentum::add(Known& known, const Vector3d& momentum, bool asleep,
                        const Impulses& impulses, const Vector3d& gravity) {
  const Vector3d change = momentum - known.momentum;
  known.momentum = momentum;
  // A body that falls asleep is stopped; afterwards nothing is computed for it.
  const bool moved = !asleep && !known.asleep;
  known.asleep = asleep;
  if (!moved) return;
  exchanged_ += impulses.all.norm() + impulses.hands.norm();
  if (!known.free) {
    rest_ += impulses.all - impulses.of_colliders;
    return;
  }
  const Vector3d weight = step_ * known.mass * gravity;
  exchanged_ += weight.norm();
  rest_ += change - weight - impulses.hands - impulses.of_colliders;
}

// The two forces of a joint between two free bodies cancel.
void WorldMomentum::add_joints(const SceneWorld& world) {
  const std::vector<SceneJoint>& joints = world.scene().joints;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const Joint* joint = world.joint(i);
    const auto first = world.find(joints[i].body), second = world.find(joints[i].to);
    if (joint == nullptr || !first || !second || world.asleep(*first)) continue;
    const Vector3d impulse = step_ * joint->force;
    exchanged_ += impulse.norm();
    if (!known_[*first].free) rest_ += impulse;
    if (!known_[*second].free) rest_ -= impulse;
  }
}

void WorldMomentum::observe(const SceneWorld& world, const WorldTetsRun& tets) {
  const bool starts = known_.empty();
  step_ = world.step_size();
  const Vector3d gravity = world.scene().gravity.at(world.time() - 0.5 * step_);
  known_.resize(world.size() + tets.size());
  for (std::size_t i = 0; i < world.size(); ++i) {
    const ContactBody& body = world.body(i);
    Known& known = known_[i];
    const bool free = body.frame() == FrameKind::kFree;
    const Vector3d momentum = free ? body.momentum().linear : Vector3d(Vector3d::Zero());
    if (starts) {
      known.free = free && world.scene().bodies[i].loads.empty();
      known.mass = free ? body.model().inertia_about_centre()->mass : 0.0;
      known.momentum = momentum;
      exchanged_ += momentum.norm();
    } else if (!world.failed(i)) {
      add(known, momentum, world.asleep(i), impulses_of(body), gravity);
    }
  }
  for (std::size_t i = 0; i < tets.size(); ++i) {
    const TetBody& body = tets.guests().body(i);
    Known& known = known_[world.size() + i];
    const Vector3d momentum = body.momentum();
    if (starts) {
      const std::span<const std::uint8_t> held = body.model().held();
      known.free =
          body.options().drag == 0.0 &&
          std::none_of(held.begin(), held.end(), [](std::uint8_t one) { return one != 0; });
      known.mass = body.model().mass();
      known.momentum = momentum;
      exchanged_ += momentum.norm();
      continue;
    }
    Impulses impulses;
    impulses.all = tets.guests().account(i).impulse_vector;
    for (const ContactedPoint& point : tets.guests().contacted(i))
      if (!point.on_body) impulses.of_colliders += point.impulse;
    add(known, momentum, false, impulses, gravity);
  }
  if (!starts) add_joints(world);
  largest_ = std::max(largest_, rest_.norm());
}

}  // namespace tremolo
