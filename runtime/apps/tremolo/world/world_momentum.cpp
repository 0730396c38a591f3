#include "runtime/apps/tremolo/world/world_momentum.h"

#include <algorithm>
#include <optional>
#include <string>

#include "common/mesh/tet_mesh.h"
#include "runtime/bodies/reduced/frames/frame_inertia.h"
#include "runtime/energy_bound.h"

namespace tremolo {

using Eigen::Vector3d;

namespace {

bool any(std::span<const std::uint8_t> flags) {
  return std::any_of(flags.begin(), flags.end(), [](std::uint8_t one) { return one != 0; });
}

Vector3d momentum_of(const MixedGuests& guests, std::size_t guest) {
  if (const TetStep* tets = guests.tets(guest)) return tets->body().momentum();
  return guests.cloth(guest)->body().momenta().linear;
}

double longest_side(const BoundingBox& box) {
  return (box.high - box.low).maxCoeff();
}

double size_of(const MixedGuests& guests, std::size_t guest) {
  if (const TetStep* tets = guests.tets(guest))
    return longest_side(bounding_box(tets->body().model().mesh().vertices));
  const Eigen::VectorXd& x = guests.cloth(guest)->body().model().parts().x;
  const Eigen::Map<const Eigen::Matrix3Xd> particles(x.data(), 3, x.size() / 3);
  return (particles.rowwise().maxCoeff() - particles.rowwise().minCoeff()).maxCoeff();
}

}  // namespace

WorldMomentum::Known WorldMomentum::start_of(const MixedGuests& guests, std::size_t guest) {
  Known known;
  known.momentum = momentum_of(guests, guest);
  if (const TetStep* tets = guests.tets(guest)) {
    const TetBody& body = tets->body();
    known.free = body.options().drag == 0.0 && !any(body.model().held()) && !guests.has_load(guest);
    known.mass = body.model().mass();
    return known;
  }
  const ClothBody& cloth = guests.cloth(guest)->body();
  known.free = cloth.cloth().drag == 0.0 && !any(cloth.model().held()) && !guests.has_load(guest);
  known.mass = cloth.mass();
  return known;
}

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

// The two forces of a joint between two free bodies cancel. The world takes the one on it.
void WorldMomentum::add_joints(const SceneWorld& world, const MixedGuests* guests) {
  const std::vector<SceneJoint>& joints = world.scene().joints;
  const auto find = [&](const std::string& name) {
    std::optional<std::size_t> found = world.find(name);
    for (std::size_t i = 0; !found && guests != nullptr && i < guests->size(); ++i)
      if (guests->name(i) == name) found = world.size() + i;
    return found;
  };
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const Joint* joint = world.joint(i);
    const auto first = find(joints[i].body), second = find(joints[i].to);
    const bool to_world = joints[i].to.empty();
    if (joint == nullptr || !first || (!second && !to_world)) continue;
    const bool asleep =
        *first < world.size() ? world.asleep(*first) : guests->asleep(*first - world.size());
    if (asleep) continue;
    const Vector3d impulse = step_ * joint->force;
    exchanged_ += impulse.norm();
    if (!known_[*first].free) rest_ += impulse;
    if (to_world || !known_[*second].free) rest_ -= impulse;
  }
}

void WorldMomentum::add_at_rest(const Known& known, double size) {
  if (known.free) at_rest_ += known.mass * kRoundedMove * size / step_;
}

void WorldMomentum::observe(const SceneWorld& world, const MixedGuests* guests) {
  const bool starts = known_.empty();
  step_ = world.step_size();
  const Vector3d gravity = world.scene().gravity.at(world.time() - 0.5 * step_);
  known_.resize(world.size() + (guests == nullptr ? 0 : guests->size()));
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
      add_at_rest(known, longest_side(bounding_box(body.model().surface().rest)));
    } else if (!world.failed(i)) {
      add(known, momentum, world.asleep(i), impulses_of(body), gravity);
    }
  }
  for (std::size_t i = 0; guests != nullptr && i < guests->size(); ++i) {
    Known& known = known_[world.size() + i];
    if (starts) {
      known = start_of(*guests, i);
      exchanged_ += known.momentum.norm();
      add_at_rest(known, size_of(*guests, i));
      continue;
    }
    Impulses impulses;
    impulses.all = guests->account(i).impulse_vector;
    for (const ContactedPoint& point : guests->contacted(i))
      if (!point.on_body) impulses.of_colliders += point.impulse;
    impulses.hands = step_ * guests->hands_force(i);
    add(known, momentum_of(*guests, i), guests->asleep(i), impulses, gravity);
  }
  if (!starts) add_joints(world, guests);
  largest_ = std::max(largest_, rest_.norm());
}

}  // namespace tremolo
