// SceneWorld: contacts that begin and end in a step, their places and sums.
#include <algorithm>
#include <span>
#include <utility>

#include "runtime/contact/solve/contact_step.h"
#include "runtime/world/contact_sum.h"
#include "runtime/world/scene_world.h"

namespace tremolo {

using Eigen::Vector3d;

// A sleeping body presses with the force of its last step.
void SceneWorld::press_on(std::size_t i) {
  const std::vector<Vector3d>& last = actors_[i].body.contact()->record().collider_impulses;
  for (std::size_t c = 0; c < std::min(last.size(), felt_by(i).size()); ++c)
    touching_[i * colliders_.placed().size() + c].whole += last[c];
}

// After a step of the body that was made.
void SceneWorld::note_contact(std::size_t i) {
  Actor& actor = actors_[i];
  if (actor.body.contact() == nullptr) return;
  if (asleep(i)) return press_on(i);
  const ContactAccount account = actor.body.contact_account();
  if (actor.size > 0.0)
    actor.penetration = std::max(actor.penetration, account.penetration / actor.size);
  actor.speed = std::max(actor.speed, account.way / scene_.step);
  actor.passed += account.passed;
  const std::span<const double> impulses = actor.body.contact()->record().impulses;
  for (std::size_t c = 0; c < std::min(impulses.size(), felt_by(i).size()); ++c) {
    Touching& touching = touching_[i * colliders_.placed().size() + c];
    touching.whole += actor.body.contact()->record().collider_impulses[c];
    const bool before = std::exchange(touching.now, impulses[c] > 0.0);
    if (touching.now) {
      if (!before) touching.place = {};
      ContactSum sum;
      for (const ContactedPoint& point : actor.body.contact()->record().contacted)
        if (!point.on_body && point.obstacle == c) sum.add(point, 1.0);
      sum.put_into(touching.place);
    }
    if (touching.now == before) continue;
    if (touching.now) ++actor.contacts;
    events_.push_back({i, c, ContactEvent::kNone,
                       before ? ContactEvent::Kind::kEnd : ContactEvent::Kind::kBegin,
                       touching.place});
  }
}

// The points of a that met b in the last step, with the sign 1, and of b that met a, with -1.
template <class Visit>
void SceneWorld::for_points_of(std::size_t a, std::size_t b, Visit&& visit) const {
  const auto points = [&](std::size_t own, std::size_t other, double sign) {
    if (actors_[own].body.contact() == nullptr) return;
    for (const ContactedPoint& point : actors_[own].body.contact()->record().contacted)
      if (point.on_body && point.obstacle == place_[other]) visit(point, sign);
  };
  points(a, b, 1.0);
  points(b, a, -1.0);
}

std::vector<ContactedPoint> SceneWorld::points_of(const ContactEvent& event) const {
  std::vector<ContactedPoint> points;
  if (event.kind == ContactEvent::Kind::kEnd) return points;
  if (event.collider == ContactEvent::kNone) {
    for_points_of(event.body, event.other, [&points](const ContactedPoint& point, double sign) {
      points.push_back(point);
      points.back().normal *= sign;
      points.back().impulse *= sign;
    });
    return points;
  }
  for (const ContactedPoint& point : actors_[event.body].body.contact()->record().contacted)
    if (!point.on_body && point.obstacle == event.collider) points.push_back(point);
  return points;
}

// Bodies that began to touch each other in the step, and that ended it. Those that sleep stay as
// they were.
void SceneWorld::note_pairs() {
  for (Pair& pair : pairs_) pair.seen = asleep(pair.a) && asleep(pair.b);
  for (const BodyGroup::Touch& touch : group_->touches()) {
    const std::size_t first = order_[touch.a], second = order_[touch.b];
    const std::size_t a = std::min(first, second), b = std::max(first, second);
    bool began = false;
    auto found = std::find_if(pairs_.begin(), pairs_.end(),
                              [a, b](const Pair& pair) { return pair.a == a && pair.b == b; });
    if (found == pairs_.end()) {
      pairs_.push_back({a, b, {}, true});
      found = pairs_.end() - 1;
      ++actors_[a].contacts;
      ++actors_[b].contacts;
      events_.push_back({a, ContactEvent::kNone, b, ContactEvent::Kind::kBegin, {}});
      began = true;
    }
    ContactSum sum;
    for_points_of(a, b, [&sum](const ContactedPoint& point, double sign) { sum.add(point, sign); });
    sum.put_into(found->place);
    if (began) events_.back().place = found->place;
    found->seen = true;
  }
  for (const Pair& pair : pairs_)
    if (!pair.seen)
      events_.push_back(
          {pair.a, ContactEvent::kNone, pair.b, ContactEvent::Kind::kEnd, pair.place});
  std::erase_if(pairs_, [](const Pair& pair) { return !pair.seen; });
}

}  // namespace tremolo
