// C functions tremolo_collider_*, and the tremolo_body_* functions for contact and grabs.
#include <algorithm>
#include <cmath>
#include <span>
#include <string>

#include "common/text.h"
#include "runtime/c/c_api.h"
#include "runtime/contact/solve/contact_step.h"

namespace {

using Eigen::Vector3d;
using tremolo::Collider;
using tremolo::ContactBody;
using tremolo::ContactOptions;
using tremolo::PlacedCollider;
using tremolo::Pose;
using tremolo::Result;
using tremolo::Status;
using tremolo::Success;
using tremolo::usage_error;
using tremolo::c_api::need;
using tremolo::c_api::put;
using tremolo::c_api::with;

constexpr double kLengthSlack = 1e-6;  // of a quaternion

// Calls `check` on the shape and creates the collider.
tremolo_status make(const Collider& shape, tremolo_collider** collider) noexcept {
  return tremolo::c_api::guarded([&]() -> Status {
    if (Status s = need({{collider, "the place for the collider"}}); !s) return s;
    if (Status s = tremolo::check(shape); !s) return s;
    *collider = new tremolo_collider{shape};
    return Success{};
  });
}

Result<Pose> collider_pose(const double position[3], const double quaternion[4]) {
  const Pose pose{Vector3d(position),
                  Eigen::Quaterniond(quaternion[0], quaternion[1], quaternion[2], quaternion[3])};
  if (!pose.position.allFinite()) return usage_error("a collider's position is not finite");
  const double length = pose.rotation.norm();
  if (!(std::abs(length - 1.0) <= kLengthSlack))
    return usage_error("a collider's quaternion is of length " + tremolo::number_text(length) +
                       ", must be 1");
  return Pose{pose.position, pose.rotation.normalized()};
}

Status place(const tremolo_placed_collider& given, PlacedCollider& placed) {
  if (Status s = need({{given.collider, "a collider"}}); !s) return s;
  if (!(given.friction >= 0.0) || !std::isfinite(given.friction))
    return usage_error("a collider's friction is " + tremolo::number_text(given.friction) +
                       ", must be finite and not negative");
  if (!(given.restitution >= 0.0 && given.restitution <= 1.0))
    return usage_error("a collider's restitution is " + tremolo::number_text(given.restitution) +
                       ", must be from 0 to 1");
  if (Status s = take(placed.start, collider_pose(given.position, given.quaternion)); !s) return s;
  if (Status s = take(placed.end, collider_pose(given.next_position, given.next_quaternion)); !s)
    return s;
  placed.shape = given.collider->shape;
  placed.friction = given.friction;
  placed.restitution = given.restitution;
  return Success{};
}

}  // namespace

Status tremolo::c_api::place_colliders(const tremolo_placed_collider* given, std::size_t count,
                                       std::vector<PlacedCollider>& placed) {
  placed.resize(count);
  for (size_t i = 0; i < count; ++i)
    if (Status s = place(given[i], placed[i]); !s) return s;
  return Success{};
}

void tremolo_contact_options_init(tremolo_contact_options* options) {
  if (options == nullptr) return;
  const ContactOptions defaults;
  *options = {.size = sizeof(tremolo_contact_options),
              .points = defaults.points,
              .margin = defaults.margin,
              .stiffness = defaults.stiffness,
              .shape = nullptr,
              .friction = defaults.friction,
              .restitution = defaults.restitution,
              .modulus = 0.0};
}

tremolo_status tremolo_body_set_contact(tremolo_body* body,
                                        const tremolo_contact_options* options) {
  return with(body, [&](ContactBody& known) -> Status {
    const auto full = tremolo::c_api::complete(options, tremolo_contact_options_init,
                                               "tremolo_contact_options_init");
    if (!full) return full.error();
    ContactOptions wanted{.points = full->points,
                          .margin = full->margin,
                          .stiffness = full->stiffness,
                          .friction = full->friction,
                          .restitution = full->restitution};
    if (full->shape != nullptr) wanted.shape = full->shape->shape;
    if (full->modulus != 0.0) wanted.modulus = full->modulus;
    return known.set_contact(wanted);
  });
}

tremolo_status tremolo_collider_plane(tremolo_collider** collider) {
  return make(tremolo::PlaneShape{}, collider);
}
tremolo_status tremolo_collider_sphere(double radius, tremolo_collider** collider) {
  return make(tremolo::SphereShape{radius}, collider);
}
tremolo_status tremolo_collider_capsule(double radius, double half_length,
                                        tremolo_collider** collider) {
  return make(tremolo::CapsuleShape{radius, half_length}, collider);
}
tremolo_status tremolo_collider_box(const double half_extents[3], tremolo_collider** collider) {
  if (half_extents == nullptr)
    return tremolo::c_api::guarded([&] { return need({{half_extents, "the half extents"}}); });
  return make(tremolo::BoxShape{Vector3d(half_extents)}, collider);
}
tremolo_status tremolo_collider_cylinder(double radius, double half_length,
                                         tremolo_collider** collider) {
  return make(tremolo::CylinderShape{radius, half_length}, collider);
}

tremolo_status tremolo_collider_load(const char* path, tremolo_collider** collider) {
  return tremolo::c_api::guarded([&]() -> Status {
    if (Status s = need({{path, "the path"}, {collider, "the place for the collider"}}); !s)
      return s;
    Result<Collider> shape = tremolo::load_collider(path);
    if (!shape) return shape.error();
    *collider = new tremolo_collider{std::move(*shape)};
    return Success{};
  });
}

void tremolo_collider_destroy(tremolo_collider* collider) {
  delete collider;
}

tremolo_status tremolo_collider_distance(const tremolo_collider* collider, const double point[3],
                                         double* distance, double normal[3]) {
  return with(collider, {{point, "the point"}, {distance, "the place for the distance"}},
              [&](const Collider& shape) -> Status {
                const Vector3d x(point);
                if (!x.allFinite()) return usage_error("the point is not finite");
                const tremolo::CollisionDistance found = tremolo::signed_distance(shape, x);
                *distance = found.distance;
                if (normal != nullptr) std::copy(found.normal.begin(), found.normal.end(), normal);
                return Success{};
              });
}

void tremolo_placed_collider_init(tremolo_placed_collider* placed,
                                  const tremolo_collider* collider) {
  if (placed == nullptr) return;
  const PlacedCollider defaults;
  *placed = {.collider = collider,
             .position = {0.0, 0.0, 0.0},
             .quaternion = {1.0, 0.0, 0.0, 0.0},
             .next_position = {0.0, 0.0, 0.0},
             .next_quaternion = {1.0, 0.0, 0.0, 0.0},
             .friction = defaults.friction,
             .restitution = defaults.restitution};
}

tremolo_status tremolo_body_step_among(tremolo_body* body, const tremolo_placed_collider* colliders,
                                       size_t count) {
  return with(body, [&](ContactBody& known) -> Status {
    if (count > 0)
      if (Status s = need({{colliders, "the colliders"}}); !s) return s;
    if (Status s = tremolo::c_api::place_colliders(colliders, count, body->around); !s) return s;
    const tremolo::StepReport report = known.step(body->around);
    if (report.converged) return Success{};
    return tremolo::Error{tremolo::error_kind(report.failure),
                          tremolo::failure_message(report, known.time())};
  });
}

tremolo_status tremolo_body_contact(const tremolo_body* body, double* penetration, double* impulse,
                                    int32_t* points) {
  return with(body, [&](const ContactBody& known) -> Status {
    const tremolo::ContactAccount account = known.contact_account();
    put(account.penetration, penetration);
    put(account.impulse, impulse);
    put(account.active, points);
    return Success{};
  });
}

tremolo_status tremolo_body_contact_impulses(const tremolo_body* body, double* out, size_t length) {
  return with(body, [&](const ContactBody& known) -> Status {
    std::span<const double> impulses;
    if (known.contact() != nullptr) impulses = known.contact()->record().impulses;
    return tremolo::c_api::fill_buffer(impulses, out, length);
  });
}

tremolo_status tremolo_body_collider_impulses(const tremolo_body* body, double* out,
                                              size_t length) {
  return with(body, [&](const ContactBody& known) -> Status {
    std::span<const Eigen::Vector3d> impulses;
    if (known.contact() != nullptr) impulses = known.contact()->record().collider_impulses;
    if (Status s = tremolo::c_api::need_buffer(out, length, 3 * impulses.size()); !s) return s;
    for (const Eigen::Vector3d& impulse : impulses) out = std::copy_n(impulse.data(), 3, out);
    return Success{};
  });
}

tremolo_status tremolo_body_contact_points(const tremolo_body* body, tremolo_contact_point* out,
                                           size_t capacity, size_t* count) {
  return with(body, {{count, "the place for the number of points"}},
              [&](const ContactBody& known) -> Status {
                std::span<const tremolo::ContactedPoint> points;
                if (known.contact() != nullptr) points = known.contact()->record().contacted;
                *count = points.size();
                if (out == nullptr && capacity != 0)
                  return tremolo::usage_error("the buffer for the contact points is NULL");
                for (std::size_t i = 0; i < std::min(capacity, points.size()); ++i) {
                  const tremolo::ContactedPoint& point = points[i];
                  out[i] = {.vertex = static_cast<uint32_t>(point.vertex),
                            .on_body = point.on_body ? 1 : 0,
                            .obstacle = point.obstacle,
                            .position = {},
                            .normal = {},
                            .impulse = {}};
                  std::copy_n(point.position.data(), 3, out[i].position);
                  std::copy_n(point.normal.data(), 3, out[i].normal);
                  std::copy_n(point.impulse.data(), 3, out[i].impulse);
                }
                return Success{};
              });
}

tremolo_status tremolo_body_contact_work(const tremolo_body* body, double* stored, double* given,
                                         double* restitution, double* friction, double* hand,
                                         double* error) {
  return with(body, [&](const ContactBody& known) -> Status {
    put(known.contact_account().energy, stored);
    put(known.contact_sums().given, given);
    put(0.0 - known.contact_sums().lost, restitution);
    put(0.0 - known.contact_sums().friction_loss, friction);
    put(known.contact_sums().hand, hand);
    put(known.contact_sums().error, error);
    return Success{};
  });
}

tremolo_status tremolo_body_grab(tremolo_body* body, uint32_t vertex, double stiffness,
                                 double damping, uint64_t* hand) {
  return with(body, {{hand, "the place for the hand"}}, [&](ContactBody& known) -> Status {
    const Result<tremolo::VertexId> id = tremolo::c_api::to_vertex(vertex);
    if (!id) return id.error();
    const Result<std::size_t> number = known.grab(*id, stiffness, damping);
    if (!number) return number.error();
    *hand = *number;
    return Success{};
  });
}

tremolo_status tremolo_body_move_hand(tremolo_body* body, uint64_t hand, const double place[3]) {
  return with(body, {{place, "the place"}},
              [&](ContactBody& known) { return known.move_hand(hand, Vector3d(place)); });
}

tremolo_status tremolo_body_release(tremolo_body* body, uint64_t hand) {
  return with(body, [&](ContactBody& known) { return known.release(hand); });
}

tremolo_status tremolo_body_hand_force(const tremolo_body* body, uint64_t hand, double force[3]) {
  return with(body, {{force, "the place for the force"}}, [&](const ContactBody& known) -> Status {
    const Vector3d found = known.hand_force(hand);
    std::copy(found.begin(), found.end(), force);
    return Success{};
  });
}

tremolo_status tremolo_body_hand_spring(const tremolo_body* body, uint64_t hand, double* stiffness,
                                        double* damping) {
  return with(body, [&](const ContactBody& known) -> Status {
    const tremolo::HandSpring spring = known.hand_spring(hand);
    put(spring.stiffness, stiffness);
    put(spring.damping, damping);
    return Success{};
  });
}
