// tremolo_contacts_*: bodies that touch and hold each other, from C.
#include <algorithm>
#include <optional>
#include <span>
#include <vector>

#include "common/text.h"
#include "runtime/c/c_api.h"
#include "runtime/contact/islands/body_group.h"

// NOLINTBEGIN(readability-identifier-naming): the names of the C header
struct tremolo_contacts {
  tremolo::BodyGroup group;
  std::vector<tremolo_body*> bodies = {};
  // Lists of a step, kept for their room.
  std::vector<tremolo::ContactBody*> stepped = {};
  std::vector<tremolo::StepReport> reports = {};
  std::vector<tremolo::PlacedCollider> around = {};
};
// NOLINTEND(readability-identifier-naming)

namespace {

using tremolo::Result;
using tremolo::Status;
using tremolo::Success;
using tremolo::usage_error;
using tremolo::c_api::need;
using tremolo::c_api::with;

Result<tremolo_body*> body_of(const tremolo_contacts& contacts, uint32_t number) {
  if (number < contacts.bodies.size()) return contacts.bodies[number];
  return usage_error("there are " + std::to_string(contacts.bodies.size()) + " bodies, no body " +
                     std::to_string(number));
}

Status add_body(tremolo_contacts& contacts, tremolo_body* body) {
  if (body->body.contact() == nullptr)
    return usage_error("bodies that touch need tremolo_body_set_contact first");
  if (std::find(contacts.bodies.begin(), contacts.bodies.end(), body) != contacts.bodies.end())
    return usage_error("the body is there already");
  if (!contacts.bodies.empty()) {
    const double step = contacts.bodies.front()->body.options().step;
    if (body->body.options().step != step)
      return usage_error("the body's step is " + tremolo::number_text(body->body.options().step) +
                         " s, that of the others " + tremolo::number_text(step) +
                         " s: bodies that touch share one");
  }
  contacts.bodies.push_back(body);
  contacts.stepped.push_back(&body->body);
  contacts.reports.emplace_back();
  return Success{};
}

// Lists those that failed; the error is that of the first.
Status failures(const tremolo_contacts& contacts, std::span<uint32_t> failed, size_t* count) {
  size_t found = 0;
  std::optional<size_t> first;
  for (size_t i = 0; i < contacts.reports.size(); ++i) {
    if (contacts.reports[i].converged) continue;
    if (!first) first = i;
    if (found < failed.size()) failed[found] = static_cast<uint32_t>(i);
    ++found;
  }
  if (count != nullptr) *count = found;
  if (!first) return Success{};
  const tremolo::StepReport& report = contacts.reports[*first];
  return tremolo::Error{tremolo::error_kind(report.failure),
                        "body " + std::to_string(*first) + ": " +
                            tremolo::failure_message(report, contacts.bodies[*first]->body.time())};
}

Result<tremolo::Joint> joint_between(const tremolo_joint_options& wanted, const tremolo_body& a,
                                     const tremolo_body& b) {
  tremolo::JointOptions options;
  if (wanted.stiffness > 0.0) options.stiffness = wanted.stiffness;
  if (!(wanted.stiffness >= 0.0)) return usage_error("a joint's stiffness must not be negative");
  options.damping = wanted.damping;
  options.length = wanted.length;
  options.touch = wanted.touch != 0;
  const Result<tremolo::VertexId> at = tremolo::c_api::to_vertex(wanted.vertex);
  if (!at) return at.error();
  if (wanted.to_place != 0) return tremolo::make_joint(a.body, *at, b.body, options);
  const Result<tremolo::VertexId> to = tremolo::c_api::to_vertex(wanted.to_vertex);
  if (!to) return to.error();
  return tremolo::make_joint(a.body, *at, b.body, *to, options);
}

}  // namespace

tremolo_status tremolo_contacts_create(int32_t sleep, tremolo_contacts** contacts) {
  return tremolo::c_api::guarded([&]() -> Status {
    if (Status s = need({{contacts, "the place for the contacts"}}); !s) return s;
    *contacts = new tremolo_contacts{tremolo::BodyGroup({.sleep = sleep != 0})};
    return Success{};
  });
}

void tremolo_contacts_destroy(tremolo_contacts* contacts) {
  delete contacts;
}

tremolo_status tremolo_contacts_set_threads(tremolo_contacts* contacts, uint32_t threads) {
  return with(contacts,
              [&](tremolo_contacts& known) -> Status { return known.group.set_threads(threads); });
}

tremolo_status tremolo_contacts_add(tremolo_contacts* contacts, tremolo_body* body,
                                    uint32_t* number) {
  return with(contacts, {{body, "the body"}}, [&](tremolo_contacts& known) -> Status {
    if (Status s = add_body(known, body); !s) return s;
    if (number != nullptr) *number = static_cast<uint32_t>(known.bodies.size() - 1);
    return Success{};
  });
}

tremolo_status tremolo_contacts_step(tremolo_contacts* contacts,
                                     const tremolo_placed_collider* colliders, size_t count,
                                     uint32_t* failed, size_t length, size_t* failed_count) {
  return with(contacts, [&](tremolo_contacts& known) -> Status {
    if (count > 0)
      if (Status s = need({{colliders, "the colliders"}}); !s) return s;
    if (length > 0)
      if (Status s = need({{failed, "the place for the numbers"}}); !s) return s;
    if (Status s = tremolo::c_api::place_colliders(colliders, count, known.around); !s) return s;
    known.group.step(known.stepped, known.around, known.reports);
    return failures(known, std::span(failed, length), failed_count);
  });
}

tremolo_status tremolo_contacts_touches(const tremolo_contacts* contacts, uint32_t* bodies,
                                        double* impulses, size_t length, size_t* count) {
  return with(contacts, [&](const tremolo_contacts& known) -> Status {
    const std::span<const tremolo::BodyGroup::Touch> touches = known.group.touches();
    if (count != nullptr) *count = touches.size();
    for (size_t i = 0; i < std::min(length, touches.size()); ++i) {
      if (bodies != nullptr) {
        bodies[2 * i] = static_cast<uint32_t>(touches[i].a);
        bodies[2 * i + 1] = static_cast<uint32_t>(touches[i].b);
      }
      if (impulses != nullptr) impulses[i] = touches[i].impulse;
    }
    return Success{};
  });
}

tremolo_status tremolo_contacts_asleep(const tremolo_contacts* contacts, uint32_t body,
                                       int32_t* asleep) {
  return with(contacts, {{asleep, "the place for the answer"}},
              [&](const tremolo_contacts& known) -> Status {
                if (const auto there = body_of(known, body); !there) return there.error();
                *asleep = known.group.asleep(body) ? 1 : 0;
                return Success{};
              });
}

tremolo_status tremolo_contacts_wake(tremolo_contacts* contacts, uint32_t body) {
  return with(contacts, [&](tremolo_contacts& known) -> Status {
    if (const auto there = body_of(known, body); !there) return there.error();
    known.group.wake(body);
    return Success{};
  });
}

void tremolo_joint_options_init(tremolo_joint_options* options) {
  if (options == nullptr) return;
  *options = {.size = sizeof(tremolo_joint_options),
              .vertex = 0,
              .to_vertex = 0,
              .to_place = 0,
              .touch = 0,
              .reserved = 0,
              .stiffness = 0.0,
              .damping = 0.0,
              .length = 0.0};
}

tremolo_status tremolo_contacts_join(tremolo_contacts* contacts, uint32_t a, uint32_t b,
                                     const tremolo_joint_options* options, uint64_t* joint) {
  return with(contacts, {{options, "the joint's options"}, {joint, "the place for the joint"}},
              [&](tremolo_contacts& known) -> Status {
                const auto full = tremolo::c_api::complete(options, tremolo_joint_options_init,
                                                           "tremolo_joint_options_init");
                if (!full) return full.error();
                const auto first = body_of(known, a), second = body_of(known, b);
                if (!first) return first.error();
                if (!second) return second.error();
                if (a == b) return usage_error("a joint is between two bodies");
                Result<tremolo::Joint> made = joint_between(*full, **first, **second);
                if (!made) return made.error();
                *joint = known.group.join(a, b, std::move(*made));
                return Success{};
              });
}

tremolo_status tremolo_contacts_separate(tremolo_contacts* contacts, uint64_t joint) {
  return with(contacts, [&](tremolo_contacts& known) -> Status {
    if (known.group.separate(joint)) return Success{};
    return usage_error("there is no joint " + std::to_string(joint));
  });
}

tremolo_status tremolo_contacts_joint(const tremolo_contacts* contacts, uint64_t joint,
                                      double force[3], double* energy, double* damped) {
  return with(contacts, [&](const tremolo_contacts& known) -> Status {
    const tremolo::Joint* held = known.group.joint(joint);
    if (held == nullptr) return usage_error("there is no joint " + std::to_string(joint));
    tremolo::c_api::put(held->force, force);
    tremolo::c_api::put(held->energy, energy);
    tremolo::c_api::put(held->damped, damped);
    return Success{};
  });
}
