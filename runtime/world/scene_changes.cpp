// SceneWorld: bodies, colliders and joints that come, go and are moved by calls between steps.
#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <utility>

#include "common/overflow.h"
#include "common/text.h"
#include "runtime/contact/solve/contact_step.h"
#include "runtime/scene/scene_bones.h"
#include "runtime/scene/scene_start.h"
#include "runtime/world/identity.h"
#include "runtime/world/scene_world.h"

namespace tremolo {
namespace {

// Distance of a collider that was removed from its last place, m.
constexpr double kAway = 1e9;

constexpr const char* kNoMotion =
    "what is added after the first step has no motion: move it by calls";

Error of_body(const std::string& name, Error error) {
  error.message = "body '" + name + "': " + error.message;
  return error;
}

// The problem of a pose; empty: none.
std::string problem_of(const Pose& pose) {
  if (!pose.position.allFinite() || !(std::abs(pose.rotation.norm() - 1.0) <= 1e-6))
    return "a pose must be finite, with a rotation of length one to 1e-6";
  const double far = pose.position.lpNorm<Eigen::Infinity>();
  return overflows(far) ? overflow_text("its position", far, "m") : "";
}

}  // namespace

// The next number in the group, of that body.
std::size_t SceneWorld::new_number(std::size_t body) {
  const std::size_t number = stepped_.size();
  stepped_.push_back(nullptr);
  reports_.resize(stepped_.size());
  order_.resize(stepped_.size(), kNobody);
  order_[number] = body;
  group_->make_room(stepped_.size());
  return number;
}

// Removes the last number again.
void SceneWorld::drop_number() {
  stepped_.pop_back();
  reports_.resize(stepped_.size());
  order_.resize(stepped_.size());
  group_->make_room(stepped_.size());
}

SceneWorld::BeforeChange SceneWorld::before_change() const {
  BeforeChange before{{}, touching_.size(), anchors_.size(), guests_ != nullptr};
  for (const Actor& actor : actors_) before.contact.push_back(actor.body.contact() != nullptr);
  return before;
}

void SceneWorld::take_back(const BeforeChange& before) {
  for (std::size_t i = 0; i < size(); ++i) {
    if (i < before.contact.size() && before.contact[i] != 0) continue;
    (void)actors_[i].body.exchange_contact();
    actors_[i].size = actors_[i].begins_within = 0.0;
  }
  touching_.resize(before.touching);
  while (anchors_.size() > before.anchors) {
    anchors_.pop_back();
    anchor_numbers_.pop_back();
    drop_number();
  }
  if (before.guests || !guests_) return;
  group_->set_guests(nullptr);
  links_.reset();
  guests_.reset();
  guest_identity_.clear();
}

void SceneWorld::replay_step() {
  for (Actor& actor : actors_) actor.old = actor.removed;
}

void SceneWorld::wake_all() {
  for (std::size_t i = 0; i < size(); ++i)
    if (!actors_[i].failed) group_->wake(place_[i]);
  if (guests_) guests_->wake_all();
}

Status SceneWorld::check_apart_from_all(std::size_t i) const {
  if (replaying_ || !scene_.bodies[i].feels_contact) return Success{};
  for (std::size_t k = 0; k < size(); ++k) {
    if (k == i || removed(k) || !scene_.bodies[k].feels_contact) continue;
    for (const auto& [a, b] : {std::pair(i, k), std::pair(k, i)}) {
      const ContactBody &points = actors_[a].body, &shape = actors_[b].body;
      if (points.contact() == nullptr || shape.contact() == nullptr) continue;
      const PresentPlace place = shape.present_place(), own = points.present_place();
      if ((own.centre - place.centre).norm() > own.radius + place.radius) continue;
      const double depth = depth_in_body(points, shape, place);
      const double margin = points.contact()->surface().law.margin;
      if (depth > margin)
        return content_error("it begins " + number_text(depth) + " m inside body '" +
                             name(a == i ? b : a) + "', more than the contact-margin of " +
                             number_text(margin) + " m: put one of them elsewhere");
    }
  }
  return Success{};
}

// Contact of the body that was added, and of those that meet others only now.
Status SceneWorld::begin_added(std::size_t i) {
  touching_.resize(size() * colliders_.placed().size());
  const ContactNeeds needs(scene_);
  for (std::size_t k = 0; k < size(); ++k) {
    const SceneBody& body = scene_.bodies[k];
    if (removed(k) || actors_[k].body.contact() != nullptr) continue;
    const bool needed = needs.of(body) || (guests_ && body.feels_contact);
    if (Status s = begin_contact(k, needed); !s)
      return k == i ? s : Status(of_body(body.name, s.error()));
  }
  return check_apart_from_all(i);
}

Result<std::size_t> SceneWorld::add_body(const SceneBody& given, const ModelSource& source) {
  SceneBody wanted = given;
  if (has_name(wanted.name)) return content_error("two bodies are called '" + wanted.name + "'");
  const auto moves = [](const SceneBone& bone) { return !bone.motion.parts.empty(); };
  if (steps_ > 0 && (!wanted.motion.parts.empty() || wanted.rig ||
                     std::any_of(wanted.bones.begin(), wanted.bones.end(), moves)))
    return usage_error("body '" + wanted.name + "': " + kNoMotion);
  Scene alone;
  alone.step = scene_.step;
  alone.bodies = {wanted};
  if (Status s = check_scene(alone); !s) return s.error();
  Result<Model::Pointer> model = model_of(wanted, source);
  if (!model) return of_body(wanted.name, model.error());
  if (wanted.rig)
    if (Status s = take_rig(wanted, **model); !s) return of_body(wanted.name, s.error());
  Result<Actor> actor = make(wanted, std::move(*model));
  if (!actor) return of_body(wanted.name, actor.error());
  const BeforeChange before = before_change();
  const auto free = std::find_if(actors_.begin(), actors_.end(),
                                 [](const Actor& one) { return one.removed && one.old; });
  const auto i = static_cast<std::size_t>(free - actors_.begin());
  const bool is_new = free == actors_.end();
  if (is_new) {
    actors_.push_back(std::move(*actor));
    scene_.bodies.push_back(wanted);
    place_.push_back(new_number(i));
    failures_.reserve(actors_.size());
  } else {
    std::swap(*free, *actor);
    std::swap(scene_.bodies[i], wanted);
  }
  numbers_[name(i)] = i;
  const Status begun = begin_added(i);
  shapes_.clear();
  if (begun) {
    group_->wake(place_[i]);
    return i;
  }
  Error error = of_body(name(i), begun.error());
  numbers_.erase(name(i));
  if (is_new) {
    actors_.pop_back();
    scene_.bodies.pop_back();
    place_.pop_back();
    drop_number();
  } else {
    std::swap(*free, *actor);
    std::swap(scene_.bodies[i], wanted);
  }
  take_back(before);
  return error;
}

void SceneWorld::remove_body(std::size_t i) {
  Actor& actor = actors_[i];
  if (actor.removed) return;
  actor.removed = actor.failed = true;
  actor.old = false;
  for (JointOf& joint : joints_)
    if (joint.a == place_[i] || joint.b == place_[i]) joint.joint.let_go(*group_);
  if (links_) links_->part_from(place_[i]);
  for (Hand& hand : hands_) hand.over = hand.over || hand.body == i;
  for (const Pair& pair : pairs_)
    if (pair.a == i || pair.b == i) group_->wake(place_[pair.a == i ? pair.b : pair.a]);
  if (guests_) guests_->wake_all();
  std::erase_if(pairs_, [i](const Pair& pair) { return pair.a == i || pair.b == i; });
  std::erase_if(events_,
                [i](const ContactEvent& event) { return event.body == i || event.other == i; });
  std::erase_if(passing_, [i](const auto& pair) { return pair.first == i || pair.second == i; });
  for (std::size_t c = 0; c < colliders_.placed().size(); ++c)
    if (const std::size_t at = i * colliders_.placed().size() + c; at < touching_.size())
      touching_[at] = {};
  numbers_.erase(name(i));
}

Status SceneWorld::add_load(std::size_t i, const SceneLoad& load) {
  ContactBody& body = actors_[i].body;
  if (Status s = add_loads({load}, body); !s) return of_body(name(i), s.error());
  scene_.bodies[i].loads.push_back(load);
  return Success{};
}

Status SceneWorld::move_body(std::size_t i, const Pose& next) {
  Actor& actor = actors_[i];
  if (actor.bones) return usage_error("body '" + name(i) + "': its frames are bones");
  if (const std::string problem = problem_of(next); !problem.empty())
    return usage_error("body '" + name(i) + "': " + problem);
  // The same refusals as in the step.
  if (Status s = actor.body.move_to(next); !s) return of_body(name(i), s.error());
  actor.given = next;
  return Success{};
}

Result<std::size_t> SceneWorld::add_collider(const SceneCollider& wanted) {
  for (std::size_t c = 0; c < scene_.colliders.size(); ++c)
    if (!collider_removed(c) && scene_.colliders[c].name == wanted.name)
      return content_error("two colliders are called '" + wanted.name + "'");
  if (steps_ > 0 && !wanted.motion.parts.empty())
    return usage_error("collider '" + wanted.name + "': " + kNoMotion);
  Scene alone;
  alone.step = scene_.step;
  alone.colliders = {wanted};
  alone.guests = {"a body"};
  if (Status s = check_scene(alone); !s) return s.error();
  const std::size_t before = colliders_.placed().size();
  SceneColliders more = colliders_;
  if (Status s = more.add(wanted); !s) return s.error();
  const PlacedCollider& placed = more.placed()[before];
  for (std::size_t i = 0; i < size() && !replaying_; ++i) {
    const ContactBody& body = actors_[i].body;
    if (removed(i) || !scene_.bodies[i].feels_contact || body.contact() == nullptr) continue;
    const DeepestPoint deepest = deepest_point(body, std::span(&placed, 1));
    if (deepest.depth > body.contact()->surface().law.margin)
      return content_error("collider '" + wanted.name + "': body '" + name(i) + "' is " +
                           number_text(deepest.depth) + " m inside it, more than its margin");
  }
  // The table has a row for each body.
  std::vector<Touching> table(size() * (before + 1));
  for (std::size_t i = 0; i < size() && before > 0; ++i)
    for (std::size_t c = 0; c < before; ++c)
      if (i * before + c < touching_.size())
        table[i * (before + 1) + c] = touching_[i * before + c];
  const BeforeChange kept = before_change();
  std::swap(colliders_, more);
  std::swap(touching_, table);
  scene_.colliders.push_back(wanted);
  events_.reserve(touching_.size());
  const ContactNeeds needs(scene_);
  for (std::size_t i = 0; i < size(); ++i) {
    if (removed(i) || actors_[i].body.contact() != nullptr) continue;
    if (const Status s = begin_contact(i, needs.of(scene_.bodies[i])); !s) {
      scene_.colliders.pop_back();
      std::swap(colliders_, more);
      std::swap(touching_, table);
      take_back(kept);
      shapes_.clear();
      return of_body(name(i), s.error());
    }
  }
  for (std::size_t i = 0; i < size(); ++i)
    if (!removed(i)) actors_[i].body.reserve_contact(felt_by(i), 0);
  shapes_.clear();
  wake_all();
  return before;
}

Status SceneWorld::move_collider(std::size_t c, const Pose& next) {
  if (const std::string problem = problem_of(next); !problem.empty())
    return usage_error("collider '" + scene_.colliders[c].name + "': " + problem);
  colliders_.move_to(c, next);
  return Success{};
}

void SceneWorld::remove_collider(std::size_t c) {
  gone_colliders_.insert(c);
  Pose pose = colliders_.placed()[c].end;
  pose.position -= kAway * (pose.rotation * Eigen::Vector3d::UnitZ());
  colliders_.put(c, pose);
  for (std::size_t i = 0; i < size(); ++i)
    if (const std::size_t at = i * colliders_.placed().size() + c; at < touching_.size())
      touching_[at].now = false;
  std::erase_if(events_, [c](const ContactEvent& event) { return event.collider == c; });
  wake_all();
}

Result<std::size_t> SceneWorld::add_joint(const SceneJoint& wanted) {
  std::set<std::string> names;
  for (const std::string* end : {&wanted.body, &wanted.to})
    if (has_name(*end)) names.insert(*end);
  const std::size_t i = scene_.joints.size();
  if (const Status s = check_joint(wanted, names); !s)
    return error_of_listed("joint", i, wanted, s.error());
  const std::optional<std::size_t> a = find(wanted.body), b = find(wanted.to);
  const BeforeChange before = before_change();
  scene_.joints.push_back(wanted);
  own_joints_.emplace_back();
  anchor_of_.emplace_back();
  const auto join = [&]() -> Status {
    for (const auto& end : {a, b}) {
      if (!end || actors_[*end].body.contact() != nullptr) continue;
      if (Status s = begin_contact(*end, true); !s) return of_body(name(*end), s.error());
    }
    if (wanted.to.empty()) {
      anchor_of_[i] = anchors_.size();
      if (Status s = add_anchor(); !s) return s;
    }
    const double load = joint_loads().of(i);
    if (a && b) return begin_joint(i, load, *a, actors_[*b].body, place_[*b]);
    if (a && anchor_of_[i]) return begin_joint(i, load, *a, anchor(i), anchor_number(i));
    return links_->join(*this, i);
  };
  const Status joined = join();
  shapes_.clear();
  if (!joined) {
    scene_.joints.pop_back();
    own_joints_.pop_back();
    anchor_of_.pop_back();
    take_back(before);
    return joined.error();
  }
  if (!wanted.options.touch && a && b) passing_.insert(std::minmax(*a, *b));
  if (!own_joints_[i]) wake_all();
  return i;
}

void SceneWorld::remove_joint(std::size_t i) {
  if (own_joints_[i]) {
    joints_[*own_joints_[i]].joint.let_go(*group_);
    const std::optional<std::size_t> a = find(scene_.joints[i].body), b = find(scene_.joints[i].to);
    if (a && b) passing_.erase(std::minmax(*a, *b));
  } else if (links_) {
    links_->end_joint(i);
    wake_all();
  }
}

void SceneWorld::set_filter(PairFilter filter) {
  if (!filter) return group_->set_filter({});
  group_->set_filter([filter = std::move(filter), this](std::size_t a, std::size_t b) {
    if (order_[a] == kNobody || order_[b] == kNobody) return true;
    return filter(order_[a], order_[b]);
  });
}

void SceneWorld::forget_guest(std::size_t guest, const std::string& name) {
  links_->forget(guest);
  scene_.guests.erase(name);
  std::erase_if(guest_identity_,
                [&](const SavedPart& part) { return part.name == "body '" + name + "'"; });
  wake_all();
}

void SceneWorld::note_guest_load(const std::string& name, const SceneLoad& load) {
  for (SavedPart& part : guest_identity_)
    if (part.name == "body '" + name + "'") part.hash = with_load(part.hash, load);
}

// A body without contact gets it.
Status SceneWorld::expect_hand(std::size_t i) {
  if (actors_[i].body.contact() != nullptr) return Success{};
  const BeforeChange before = before_change();
  const Status begun = begin_contact(i, true);
  shapes_.clear();
  if (begun) return begun;
  take_back(before);
  return usage_error("body '" + name(i) + "': no hand can hold it: " + begun.error().message);
}

Status SceneWorld::expect_guests() {
  for (std::size_t i = 0; i < size(); ++i) {
    if (removed(i) || !scene_.bodies[i].feels_contact || actors_[i].body.contact() != nullptr)
      continue;
    if (Status s = begin_contact(i, true); !s) return of_body(name(i), s.error());
  }
  return Success{};
}

}  // namespace tremolo
