// World: contacts that begin and end, of bodies of all kinds, and their points.
#include <algorithm>

#include "runtime/contact/solve/contact_step.h"
#include "runtime/world/contact_sum.h"
#include "runtime/world/world.h"

namespace tremolo {

// The body of a number of contact; of a SceneWorld's body it is the index there.
WorldBody World::body_of(std::size_t number) const {
  const std::size_t slot =
      number < kFirstGuest ? own_slots_[number] : guests_[number - kFirstGuest].slot;
  return {static_cast<std::uint32_t>(slot), slots_[slot].generation};
}

std::size_t World::number_of(WorldBody body) const {
  return is_guest(body) ? kFirstGuest + index(body) : index(body);
}

// The points between two numbers with a force in the last step: visit(point, sign), 1 for points of
// the first, -1 for those of the second.
template <class Visit>
void World::for_points_of(std::size_t first, std::size_t second, const Visit& visit) const {
  const auto points = [&](std::size_t own, std::size_t other, double sign) {
    if (own >= kFirstCollider) return;
    std::span<const ContactedPoint> all;
    if (own >= kFirstGuest) {
      if (!guests()->removed(own - kFirstGuest)) all = guests()->contacted(own - kFirstGuest);
    } else if (!own_.removed(own) && own_.body(own).contact() != nullptr) {
      all = own_.body(own).contact()->record().contacted;
    }
    // A SceneWorld's bodies know colliders by their index, and each other by the group's numbers.
    const bool collider = other >= kFirstCollider;
    std::size_t obstacle = other;
    if (collider && own < kFirstGuest) obstacle = other - kFirstCollider;
    if (other < kFirstGuest) obstacle = own_.group_number(other);
    for (const ContactedPoint& point : all)
      if (point.on_body != collider && point.obstacle == obstacle) visit(point, sign);
  };
  points(first, second, 1.0);
  points(second, first, -1.0);
}

std::vector<ContactedPoint> World::points(WorldBody body, std::optional<WorldBody> other,
                                          std::size_t collider) const {
  std::vector<ContactedPoint> all;
  for_points_of(number_of(body), other ? number_of(*other) : kFirstCollider + collider,
                [&all](const ContactedPoint& point, double sign) {
                  all.push_back(point);
                  all.back().normal *= sign;
                  all.back().impulse *= sign;
                });
  return all;
}

// Notes that two things touched in the last step.
void World::meet(std::size_t first, std::size_t second) {
  if (first > second) std::swap(first, second);
  const auto found = std::find_if(touches_.begin(), touches_.end(), [&](const Touch& touch) {
    return touch.first == first && touch.second == second;
  });
  if (found == touches_.end())
    touches_.push_back({first, second, {}, true});
  else
    found->seen = true;
}

// Contacts of guests that began in the step, and that ended it.
void World::note_guests() {
  const std::size_t before = touches_.size();
  for (Touch& touch : touches_) touch.seen = false;
  for (std::size_t g = 0; g < guests_.size(); ++g) {
    if (guests()->removed(g) || guests()->failed(g)) continue;
    for (const ContactedPoint& point : guests()->contacted(g)) {
      const bool own = point.on_body && point.obstacle < kFirstGuest;
      meet(kFirstGuest + g, own ? own_.body_of_number(point.obstacle) : point.obstacle);
    }
  }
  for (std::size_t i = 0; i < own_.size(); ++i) {
    if (own_.removed(i) || own_.body(i).contact() == nullptr) continue;
    for (const ContactedPoint& point : own_.body(i).contact()->record().contacted)
      if (point.on_body && point.obstacle >= kFirstGuest) meet(i, point.obstacle);
  }
  const auto note = [this](ContactEvent::Kind kind, const Touch& touch) {
    WorldEvent event{kind,         own_.time(),         body_of(touch.first),
                     std::nullopt, ContactEvent::kNone, touch.place};
    if (touch.second >= kFirstCollider)
      event.collider = touch.second - kFirstCollider;
    else
      event.other = body_of(touch.second);
    events_.push_back(event);
  };
  for (std::size_t k = 0; k < touches_.size(); ++k) {
    Touch& touch = touches_[k];
    if (!touch.seen) {
      note(ContactEvent::Kind::kEnd, touch);
      continue;
    }
    ContactSum sum;
    for_points_of(touch.first, touch.second,
                  [&sum](const ContactedPoint& point, double sign) { sum.add(point, sign); });
    sum.put_into(touch.place);
    if (k >= before) note(ContactEvent::Kind::kBegin, touch);
  }
  std::erase_if(touches_, [](const Touch& touch) { return !touch.seen; });
}

// Those of the last step.
void World::note_events() {
  for (const ContactEvent& event : own_.events()) {
    WorldEvent noted{event.kind,   own_.time(),    body_of(event.body),
                     std::nullopt, event.collider, event.place};
    if (event.other != ContactEvent::kNone) noted.other = body_of(event.other);
    events_.push_back(noted);
  }
  if (guests() != nullptr) note_guests();
}

}  // namespace tremolo
