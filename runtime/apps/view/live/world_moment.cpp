#include "runtime/apps/view/live/world_moment.h"

#include <cmath>

#include "runtime/apps/view/live/live_guests.h"

namespace tremolo {
namespace {

void mix_numbers(const std::vector<float>& a, const std::vector<float>& b, double share,
                 std::vector<float>& out) {
  out.resize(a.size());
  const auto late = static_cast<float>(share);
  for (std::size_t i = 0; i < a.size(); ++i) out[i] = a[i] + late * (b[i] - a[i]);
}

Pose mixed_pose(const Pose& a, const Pose& b, double share) {
  return {a.position + share * (b.position - a.position), a.rotation.slerp(share, b.rotation)};
}

}  // namespace

Status look_at_world(const SceneWorld& world, const LiveGuests& guests, WorldMoment& moment) {
  moment.time = world.time();
  moment.bodies.resize(world.size() + guests.size());
  for (std::size_t i = 0; i < guests.size(); ++i) guests.look(i, moment.bodies[world.size() + i]);
  for (std::size_t i = 0; i < world.size(); ++i) {
    const ContactBody& body = world.body(i);
    BodyMoment& seen = moment.bodies[i];
    seen.q = body.shown();
    if (body.bones() == 0) {
      seen.pose = body.pose();
      continue;
    }
    const std::size_t numbers = 3 * body.model().drawn().rest.size();
    seen.positions.resize(numbers);
    seen.normals.resize(numbers);
    if (Status s = body.surface(seen.positions, seen.normals); !s) return s;
  }
  moment.colliders.resize(world.colliders().size());
  for (std::size_t i = 0; i < moment.colliders.size(); ++i)
    moment.colliders[i] = world.colliders()[i].end;
  return Success{};
}

void between(const WorldMoment& a, const WorldMoment& b, double share, WorldMoment& out) {
  out.time = a.time + share * (b.time - a.time);
  out.bodies.resize(b.bodies.size());
  for (std::size_t i = 0; i < b.bodies.size(); ++i) {
    const BodyMoment &early = a.bodies[i], &late = b.bodies[i];
    out.bodies[i].q = early.q + share * (late.q - early.q);
    out.bodies[i].pose = mixed_pose(early.pose, late.pose, share);
    mix_numbers(early.positions, late.positions, share, out.bodies[i].positions);
    mix_numbers(early.normals, late.normals, share, out.bodies[i].normals);
    mix_numbers(early.degrees, late.degrees, share, out.bodies[i].degrees);
  }
  out.colliders.resize(b.colliders.size());
  for (std::size_t i = 0; i < b.colliders.size(); ++i)
    out.colliders[i] = mixed_pose(a.colliders[i], b.colliders[i], share);
  out.hands = b.hands;
  for (std::size_t i = 0; i < b.hands.size() && i < a.hands.size(); ++i)
    if (a.hands[i].holds && b.hands[i].holds) {
      out.hands[i].held = a.hands[i].held + share * (b.hands[i].held - a.hands[i].held);
      out.hands[i].point = a.hands[i].point + share * (b.hands[i].point - a.hands[i].point);
    }
}

}  // namespace tremolo
