// runtime/tremolo_scene.h: the bodies of a world from C.
#include <algorithm>
#include <string>
#include <vector>

#include "common/text.h"
#include "runtime/c/world_c_api.h"

namespace {

using Eigen::Vector3d;
using tremolo::ContactedPoint;
using tremolo::Result;
using tremolo::Status;
using tremolo::Success;
using tremolo::usage_error;
using tremolo::World;
using tremolo::WorldBody;
using tremolo::c_api::body_of;
using tremolo::c_api::exists;
using tremolo::c_api::id_of;
using tremolo::c_api::need_buffer;
using tremolo::c_api::put;
using tremolo::c_api::with_body;
using tremolo::c_api::with_world;

// Fills a buffer with values of the body's vertices: write(World, body, span) -> Status.
template <class Real, class Write>
tremolo_status fill(const tremolo_world* world, tremolo_body_id body, Real* out, std::size_t length,
                    const Write& write) noexcept {
  return with_body(world, body, {}, [&](const World& all, WorldBody known) -> Status {
    if (Status s = need_buffer(out, length, 3 * all.vertices(known)); !s) return s;
    return write(all, known, std::span(out, length));
  });
}

tremolo::WorldSite site_of(const tremolo_site& site) {
  return {body_of(site.body), site.triangle, Vector3d(site.weights)};
}

// Runs action(World&, WorldSite) -> Status.
template <class Handle, class Action>
tremolo_status with_site(Handle* world, const tremolo_site* site, const Action& action) noexcept {
  return with_world(world, {{site, "the site"}}, [&](World& all) -> Status {
    const tremolo::WorldSite known = site_of(*site);
    if (Status s = all.check(known.body); !s) return s;
    if (!known.weights.allFinite()) return usage_error("the weights of a site must be finite");
    return action(all, known);
  });
}

// Stores the number of a hand, and warns if its spring is not as stiff as it should be.
Status keep(const World& all, WorldBody body, const Result<std::size_t>& hand, double stiffness,
            std::uint64_t* out) {
  if (!hand) return hand.error();
  *out = *hand;
  const Result<tremolo::HandSpring> spring = all.hand_spring(body, *hand);
  if (spring && spring->stiffness < stiffness)
    tremolo::c_api::log(TREMOLO_LOG_WARNING,
                        ("body '" + all.name(body) + "': the spring of its hand has " +
                         tremolo::number_text(spring->stiffness) + " N/m instead of " +
                         tremolo::number_text(stiffness) + ", as stiff as mass and step allow")
                            .c_str());
  return Success{};
}

}  // namespace

size_t tremolo_world_bodies(const tremolo_world* world) {
  return world == nullptr ? 0 : world->world->size();
}

tremolo_body_id tremolo_world_body(const tremolo_world* world, size_t index) {
  tremolo_body_id id = 0;
  (void)with_world(world, {}, [&](const World& all) -> Status {
    const std::vector<WorldBody> bodies = all.bodies();
    if (index < bodies.size()) id = id_of(bodies[index]);
    return Success{};
  });
  return id;
}

tremolo_status tremolo_world_find(const tremolo_world* world, const char* name,
                                  tremolo_body_id* body) {
  return with_world(world, {{name, "the name"}, {body, "the place for the id"}},
                    [&](const World& all) -> Status {
                      const auto found = all.find(name);
                      if (!found)
                        return usage_error("there is no body '" + std::string(name) + "'");
                      *body = id_of(*found);
                      return Success{};
                    });
}

const char* tremolo_world_name(const tremolo_world* world, tremolo_body_id body) {
  return exists(world, body) ? world->world->name(body_of(body)).c_str() : nullptr;
}

tremolo_status tremolo_world_kind(const tremolo_world* world, tremolo_body_id body,
                                  tremolo_body_kind* kind) {
  return with_body(world, body, {{kind, "the place for the kind"}},
                   [&](const World& all, WorldBody known) -> Status {
                     *kind = static_cast<tremolo_body_kind>(all.kind(known));
                     return Success{};
                   });
}

tremolo_status tremolo_world_set_user_data(tremolo_world* world, tremolo_body_id body, void* user) {
  return with_body(world, body, {}, [&](World& all, WorldBody known) -> Status {
    all.set_user_data(known, user);
    return Success{};
  });
}

// A filter may ask for it.
void* tremolo_world_user_data(const tremolo_world* world, tremolo_body_id body) {
  if (world == nullptr || !world->world->check(body_of(body))) return nullptr;
  return world->world->user_data(body_of(body));
}

size_t tremolo_world_vertices(const tremolo_world* world, tremolo_body_id body) {
  return exists(world, body) ? world->world->vertices(body_of(body)) : 0;
}

size_t tremolo_world_triangles(const tremolo_world* world, tremolo_body_id body) {
  return exists(world, body) ? world->world->triangles(body_of(body)).size() : 0;
}

tremolo_status tremolo_world_triangle_corners(const tremolo_world* world, tremolo_body_id body,
                                              uint32_t* out, size_t length) {
  return with_body(world, body, {}, [&](const World& all, WorldBody known) {
    return tremolo::c_api::fill_buffer(all.triangles(known), out, length);
  });
}

tremolo_status tremolo_world_positions_float(const tremolo_world* world, tremolo_body_id body,
                                             float* out, size_t length) {
  return fill(world, body, out, length, [](const World& all, WorldBody known, auto numbers) {
    return all.positions(known, numbers);
  });
}

tremolo_status tremolo_world_positions_double(const tremolo_world* world, tremolo_body_id body,
                                              double* out, size_t length) {
  return fill(world, body, out, length, [](const World& all, WorldBody known, auto numbers) {
    return all.positions(known, numbers);
  });
}

tremolo_status tremolo_world_velocities(const tremolo_world* world, tremolo_body_id body,
                                        double* out, size_t length) {
  return fill(world, body, out, length, [](const World& all, WorldBody known, auto numbers) {
    return all.velocities(known, numbers);
  });
}

tremolo_status tremolo_world_coordinates(const tremolo_world* world, tremolo_body_id body,
                                         double* out, size_t length) {
  return with_body(world, body, {}, [&](const World& all, WorldBody known) -> Status {
    const tremolo::ContactBody* of = all.reduced(known);
    if (of == nullptr) return usage_error("body '" + all.name(known) + "' has no basis");
    return tremolo::c_api::fill_buffer(of->shown(), out, length);
  });
}

tremolo_status tremolo_world_account(const tremolo_world* world, tremolo_body_id body,
                                     tremolo_energy_account* account) {
  return with_body(world, body, {{account, "the place for the account"}},
                   [&](const World& all, WorldBody known) -> Status {
                     const tremolo::WorldAccount a = all.account(known);
                     *account = {.kinetic = a.sums.kinetic,
                                 .potential = a.sums.potential,
                                 .contact = a.sums.contact,
                                 .at_start = a.sums.at_start,
                                 .load = a.sums.load,
                                 .support = a.sums.support,
                                 .gravity = a.sums.gravity,
                                 .wind = a.wind,
                                 .contact_given = a.sums.contact_given,
                                 .restitution = a.sums.restitution,
                                 .friction = a.sums.friction,
                                 .hand = a.sums.hand,
                                 .joint = a.sums.joint,
                                 .damping = a.sums.damping,
                                 .method = a.method,
                                 .remainder = a.remainder};
                     return Success{};
                   });
}

tremolo_status tremolo_world_momentum(const tremolo_world* world, tremolo_body_id body,
                                      double linear[3], double angular[3]) {
  return with_body(world, body, {}, [&](const World& all, WorldBody known) -> Status {
    const tremolo::Momenta momenta = all.momenta(known);
    put(momenta.linear, linear);
    put(momenta.angular, angular);
    return Success{};
  });
}

tremolo_status tremolo_world_contact(const tremolo_world* world, tremolo_body_id body,
                                     int64_t* contacts, double* penetration, double force[3],
                                     int32_t* points) {
  return with_body(world, body, {}, [&](const World& all, WorldBody known) -> Status {
    const tremolo::WorldContact contact = all.contact(known);
    put(contact.contacts, contacts);
    put(contact.penetration, penetration);
    put(contact.force, force);
    put(contact.points, points);
    return Success{};
  });
}

tremolo_status tremolo_world_look(const tremolo_world* world, tremolo_body_id body, int32_t* asleep,
                                  int32_t* failed) {
  return with_body(world, body, {}, [&](const World& all, WorldBody known) -> Status {
    put(all.asleep(known) ? 1 : 0, asleep);
    put(all.failed(known) ? 1 : 0, failed);
    return Success{};
  });
}

tremolo_status tremolo_world_pose(const tremolo_world* world, tremolo_body_id body,
                                  double position[3], double quaternion[4]) {
  return with_body(world, body, {}, [&](const World& all, WorldBody known) -> Status {
    const tremolo::ContactBody* of = all.reduced(known);
    if (of == nullptr) return usage_error("body '" + all.name(known) + "' has no frame");
    const tremolo::Pose pose = of->pose();
    put(pose.position, position);
    const Eigen::Quaterniond& q = pose.rotation;
    put(Eigen::Vector4d(q.w(), q.x(), q.y(), q.z()), quaternion);
    return Success{};
  });
}

tremolo_status tremolo_world_apply_force(tremolo_world* world, tremolo_body_id body,
                                         uint32_t vertex, const double force[3], int32_t steps) {
  return with_body(world, body, {{force, "the force"}}, [&](World& all, WorldBody known) -> Status {
    const Result<tremolo::VertexId> id = tremolo::c_api::to_vertex(vertex);
    if (!id) return id.error();
    return all.apply_force(known, *id, Vector3d(force), steps);
  });
}

tremolo_status tremolo_world_pick(const tremolo_world* world, const double origin[3],
                                  const double direction[3], tremolo_site* site, double* distance,
                                  double point[3]) {
  return with_world(
      world,
      {{origin, "the origin"}, {direction, "the direction"}, {site, "the place for the site"}},
      [&](const World& all) -> Status {
        const auto found = all.pick(Vector3d(origin), Vector3d(direction));
        if (!found) return found.error();
        *site = {};
        if (!*found) return Success{};
        const tremolo::WorldHit& hit = **found;
        site->body = id_of(hit.site.body);
        site->triangle = static_cast<std::uint32_t>(hit.site.triangle);
        put(hit.site.weights, site->weights);
        put(hit.distance, distance);
        put(hit.point, point);
        return Success{};
      });
}

tremolo_status tremolo_world_site(const tremolo_world* world, const tremolo_site* site,
                                  double position[3], double velocity[3]) {
  return with_site(world, site, [&](const World& all, const tremolo::WorldSite& known) -> Status {
    Vector3d x, v;
    if (Status s = all.where(known, position != nullptr ? &x : nullptr,
                             velocity != nullptr ? &v : nullptr);
        !s)
      return s;
    put(x, position);
    put(v, velocity);
    return Success{};
  });
}

tremolo_status tremolo_world_grab(tremolo_world* world, tremolo_body_id body, uint32_t vertex,
                                  double stiffness, double damping, uint64_t* hand) {
  return with_body(
      world, body, {{hand, "the place for the hand"}}, [&](World& all, WorldBody known) -> Status {
        const Result<tremolo::VertexId> id = tremolo::c_api::to_vertex(vertex);
        if (!id) return tremolo::content_error("there is no vertex " + std::to_string(vertex));
        return keep(all, known, all.grab(known, *id, stiffness, damping), stiffness, hand);
      });
}

tremolo_status tremolo_world_grab_site(tremolo_world* world, const tremolo_site* site,
                                       double stiffness, double damping, uint64_t* hand) {
  return with_site(world, site, [&](World& all, const tremolo::WorldSite& known) -> Status {
    if (Status s = tremolo::c_api::need({{hand, "the place for the hand"}}); !s) return s;
    return keep(all, known.body, all.grab(known, stiffness, damping), stiffness, hand);
  });
}

tremolo_status tremolo_world_move_hand(tremolo_world* world, tremolo_body_id body, uint64_t hand,
                                       const double place[3]) {
  return with_body(world, body, {{place, "the place"}}, [&](World& all, WorldBody known) {
    return all.move_hand(known, hand, Vector3d(place));
  });
}

tremolo_status tremolo_world_hand_force(const tremolo_world* world, tremolo_body_id body,
                                        uint64_t hand, double force[3]) {
  return with_body(world, body, {{force, "the place for the force"}},
                   [&](const World& all, WorldBody known) -> Status {
                     const Result<Vector3d> on_body = all.hand_force(known, hand);
                     if (!on_body) return on_body.error();
                     put(*on_body, force);
                     return Success{};
                   });
}

tremolo_status tremolo_world_let_go(tremolo_world* world, tremolo_body_id body, uint64_t hand) {
  return with_body(world, body, {},
                   [&](World& all, WorldBody known) { return all.let_go(known, hand); });
}

size_t tremolo_world_events(const tremolo_world* world) {
  return world == nullptr ? 0 : world->world->events().size();
}

tremolo_status tremolo_world_event(const tremolo_world* world, size_t index, tremolo_event* event) {
  return with_world(world, {{event, "the place for the event"}}, [&](const World& all) -> Status {
    if (index >= all.events().size())
      return usage_error("there are " + std::to_string(all.events().size()) + " events, no event " +
                         std::to_string(index));
    const tremolo::WorldEvent& known = all.events()[index];
    *event = {};
    event->time = known.time;
    event->body = id_of(known.body);
    if (known.other)
      event->other = id_of(*known.other);
    else
      event->collider = static_cast<std::uint32_t>(known.collider);
    event->begins = known.kind == tremolo::ContactEvent::Kind::kBegin ? 1 : 0;
    event->impulse = known.place.impulse;
    put(known.place.push, event->push);
    put(known.place.position, event->position);
    put(known.place.normal, event->normal);
    return Success{};
  });
}

tremolo_status tremolo_world_contact_points(const tremolo_world* world, tremolo_body_id body,
                                            tremolo_body_id other, uint32_t collider,
                                            tremolo_contact_point* out, size_t capacity,
                                            size_t* count) {
  return with_body(world, body, {{count, "the place for the count"}},
                   [&](const World& all, WorldBody known) -> Status {
                     if (other != 0)
                       if (Status s = all.check(body_of(other)); !s) return s;
                     if (other == 0 && collider >= all.own().scene().colliders.size())
                       return usage_error("there is no collider " + std::to_string(collider));
                     const std::vector<ContactedPoint> points =
                         other != 0 ? all.points(known, body_of(other))
                                    : all.points(known, std::nullopt, collider);
                     if (capacity > 0)
                       if (Status s = tremolo::c_api::need({{out, "the place for the points"}}); !s)
                         return s;
                     *count = points.size();
                     for (std::size_t i = 0; i < std::min(capacity, points.size()); ++i) {
                       out[i] = {};
                       out[i].vertex = static_cast<std::uint32_t>(points[i].vertex);
                       out[i].on_body = other != 0 ? 1 : 0;
                       out[i].obstacle = other != 0 ? other : collider;
                       put(points[i].position, out[i].position);
                       put(points[i].normal, out[i].normal);
                       put(points[i].impulse, out[i].impulse);
                     }
                     return Success{};
                   });
}
