// SceneWorld: saves and restores its state between steps.
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "common/state_stream.h"
#include "formats/saved/saved_file.h"
#include "runtime/contact/solve/contact_step.h"
#include "runtime/world/scene_world.h"

namespace tremolo {
namespace {

std::string grabbed(const std::string& name) {
  return "body '" + name + "', grabbed by calls";
}

}  // namespace

// True if the body, which is there, would have no contact without the hands of calls.
bool SceneWorld::has_contact_for_hands(std::size_t i, const ContactNeeds& needs) const {
  const SceneBody& body = scene_.bodies[i];
  return actors_[i].body.contact() != nullptr && !needs.of(body) &&
         !(guests_ && body.feels_contact);
}

SavedState SceneWorld::saved_parts() const {
  std::vector<const Model*> models;
  std::vector<const Collider*> shapes;
  for (const Actor& actor : actors_) {
    models.push_back(&actor.body.model());
    shapes.push_back(actor.body.contact() == nullptr
                         ? nullptr
                         : actor.body.contact()->surface().shape_or_null());
  }
  std::vector<SavedPart> parts = scene_parts(scene_, models, shapes, colliders_.placed());
  // The first part is of the scene.
  for (std::size_t i = 0; i < size(); ++i)
    if (removed(i)) parts[1 + i] = {"removed body " + std::to_string(i), 0};
  for (const std::size_t c : gone_colliders_)
    parts[1 + size() + c] = {"removed collider " + std::to_string(c), 0};
  for (std::size_t i = 0; i < size(); ++i)
    if (actors_[i].given && !removed(i))
      parts.push_back({"body '" + name(i) + "', moved by calls", 0});
  for (std::size_t c = 0; c < scene_.colliders.size(); ++c)
    if (colliders_.is_given(c) && !collider_removed(c))
      parts.push_back({"collider '" + scene_.colliders[c].name + "', moved by calls", 0});
  const ContactNeeds needs(scene_);
  for (std::size_t i = 0; i < size(); ++i)
    if (!removed(i) && has_contact_for_hands(i, needs)) parts.push_back({grabbed(name(i)), 0});
  parts.insert(parts.end(), guest_identity_.begin(), guest_identity_.end());
  return {"a world", TREMOLO_VERSION, std::move(parts), {}};
}

SavedState SceneWorld::saved_state() const {
  SavedState saved = saved_parts();
  saved.state = state_bytes(*this);
  return saved;
}

std::vector<std::byte> SceneWorld::save() const {
  return encode_saved(saved_state());
}

Status SceneWorld::save(const std::string& path) const {
  return write_saved(path, saved_state());
}

// Gives contact to the bodies that have it for hands in the saved state, and takes it from those
// that have it for hands here alone.
Status SceneWorld::match_hands(const SavedState& saved, std::vector<HandContact>& changed) {
  const ContactNeeds needs(scene_);
  for (std::size_t i = 0; i < size(); ++i) {
    if (removed(i)) continue;
    const bool is = has_contact_for_hands(i, needs);
    const bool was =
        std::any_of(saved.parts.begin(), saved.parts.end(),
                    [&](const SavedPart& part) { return part.name == grabbed(name(i)); });
    if (is && !was) changed.push_back({i, actors_[i].body.exchange_contact()});
    if (was && actors_[i].body.contact() == nullptr) {
      if (Status s = expect_hand(i); !s) return s;
      changed.push_back({i, nullptr});
    }
  }
  return Success{};
}

Status SceneWorld::restore_from(const Result<SavedState>& saved, const std::string& name) {
  if (!saved) return saved.error();
  const std::string before = state_bytes(*this);
  std::vector<HandContact> changed;
  Status restored = match_hands(*saved, changed);
  if (restored) restored = check_belongs(*saved, saved_parts());
  if (restored && restore_state(*this, saved->state)) return Success{};
  for (HandContact& one : changed)
    (void)actors_[one.body].body.exchange_contact(std::move(one.before));
  if (!changed.empty()) (void)restore_state(*this, before);
  if (!restored) return error_of_file(name, restored.error());
  return content_error(name +
                       ": it does not fit this world: its bodies have other loads, or it was "
                       "made by hand");
}

Status SceneWorld::restore(std::span<const std::byte> bytes) {
  const std::string name = "the saved world";
  return restore_from(read_saved(bytes, name), name);
}

Status SceneWorld::restore(const std::string& path) {
  return restore_from(read_saved(path), path);
}

void SceneWorld::carry_contacts(StateStream& stream) {
  stream(touching_);
  stream.sized(events_);
  stream.sized(pairs_);
  if (stream.reads()) {
    for (const Touching& touching : touching_)
      stream.require(std::isfinite(touching.place.impulse) && touching.whole.allFinite());
    for (const ContactEvent& event : events_) stream.require(std::isfinite(event.place.impulse));
    for (const Pair& pair : pairs_) stream.require(std::isfinite(pair.place.impulse));
  }
  const auto is_body = [this](std::size_t i) { return i < size(); };
  for (const ContactEvent& event : events_)
    stream.require(
        is_body(event.body) &&
        (event.collider == ContactEvent::kNone || event.collider < scene_.colliders.size()) &&
        (event.other == ContactEvent::kNone || is_body(event.other)) &&
        (event.kind == ContactEvent::Kind::kBegin || event.kind == ContactEvent::Kind::kEnd));
  for (const Pair& pair : pairs_) stream.require(pair.a < pair.b && is_body(pair.b));
}

void SceneWorld::carry(StateStream& stream) {
  std::int64_t steps = steps_;
  stream(steps);
  stream.require(steps >= 0);
  if (!stream.good()) return;
  steps_ = steps;
  for (Actor& actor : actors_) {
    if (actor.removed) continue;
    if (actor.given) stream(*actor.given);
    std::size_t piece = actor.piece;
    stream(piece, actor.energy_at_start, actor.failed, actor.penetration);
    stream(actor.contacts, actor.speed, actor.passed);
    stream.require(piece <= actor.path.jumps().size());
    if (stream.reads())
      stream.require(std::isfinite(actor.energy_at_start) && std::isfinite(actor.penetration) &&
                     std::isfinite(actor.speed));
    if (!stream.good()) return;
    actor.piece = piece;
    actor.body.carry(stream);
  }
  carry_contacts(stream);
  for (Hand& hand : hands_)
    if (!hand.over) hand.hand.carry(stream, actors_[hand.body].body);
  if (stream.reads())
    for (JointOf& joint : joints_) joint.joint.let_go(*group_);
  for (JointOf& joint : joints_) joint.joint.carry(stream, *group_, joint.a, joint.b);
  group_->carry(stream, stepped_.size());
  if (guests_) guests_->carry(stream, stepped_.size());
  if (links_) links_->carry(stream);
  if (!stream.reads()) {
    colliders_.carry(stream);
    return;
  }
  failures_.clear();
  (void)colliders_.move(std::max<std::int64_t>(steps_ - 1, 0), scene_.step);
  colliders_.carry(stream);
}

}  // namespace tremolo
