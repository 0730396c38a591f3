// runtime/tremolo_scene.h: the bodies of a world from C.
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "runtime/bodies/reduced/surface_velocity.h"
#include "runtime/c/scene_c_api.h"
#include "runtime/contact/solve/contact_step.h"

namespace {

using Eigen::Vector3d;
using tremolo::ContactBody;
using tremolo::Result;
using tremolo::SceneWorld;
using tremolo::Status;
using tremolo::Success;
using tremolo::usage_error;
using tremolo::c_api::need;
using tremolo::c_api::need_buffer;
using tremolo::c_api::put;
using tremolo::c_api::with_all;

std::size_t count_of(const tremolo_world& world) {
  return world.world.size() + world.guests.size();
}

bool exists(const tremolo_world* world, std::uint32_t body) {
  return world != nullptr && body < count_of(*world);
}

// A body of the world by its number: one of the SceneWorld's, or a guest.
struct Known {
  const tremolo_world& all;
  std::size_t number;

  const SceneWorld& world() const { return all.world; }
  bool is_guest() const { return number >= world().size(); }
  std::size_t guest() const { return number - world().size(); }
  const tremolo::MixedGuests& guests() const { return *all.made.guests; }
  const ContactBody& own() const { return world().body(number); }
  // Null: it is of another kind.
  const tremolo::TetStep* tets() const { return is_guest() ? guests().tets(guest()) : nullptr; }
  const tremolo::ClothBody* cloth() const {
    const tremolo::ClothStep* step = is_guest() ? guests().cloth(guest()) : nullptr;
    return step != nullptr ? &step->body() : nullptr;
  }
  const std::string& name() const {
    return is_guest() ? guests().name(guest()) : world().name(number);
  }
  tremolo_body_kind kind() const {
    if (tets() != nullptr) return TREMOLO_TETS;
    if (cloth() != nullptr) return TREMOLO_CLOTH;
    return world().scene().bodies[number].rigid ? TREMOLO_RIGID : TREMOLO_REDUCED;
  }
  std::span<const tremolo::Triangle> triangles() const {
    if (tets() != nullptr) return all.made.kind(guest()).surface->rest().triangles;
    if (cloth() == nullptr) return own().model().drawn().triangles;
    const tremolo::ClothParts& parts = cloth()->model().parts();
    return parts.drawn ? parts.drawn->triangles : parts.triangles;
  }
  std::size_t vertices() const {
    if (tets() != nullptr) return all.made.kind(guest()).surface->vertices();
    if (cloth() != nullptr) return all.guests[guest()].particles.size();
    return own().model().drawn().rest.size();
  }
};

// Runs action(Known) -> Status; kUsage if there is no such body.
template <class Action>
tremolo_status with_body(const tremolo_world* world, std::uint32_t body,
                         const Action& action) noexcept {
  return with_all({{world, "the world"}}, [&]() -> Status {
    if (exists(world, body)) return action(Known{*world, body});
    return usage_error("there are " + std::to_string(count_of(*world)) + " bodies, no body " +
                       std::to_string(body));
  });
}

// kUsage for a guest. what: why it does not have this.
Status need_own(const Known& body, const char* what) {
  if (!body.is_guest()) return Success{};
  return usage_error("body '" + body.name() + "' is of kind \"" +
                     (body.tets() != nullptr ? "tets" : "cloth") + "\": " + what);
}

// kUsage: the body has no such hand.
Status need_hand(const Known& body, std::uint64_t hand) {
  bool exists = false;
  if (body.is_guest()) {
    const tremolo::GuestHand* held = body.guests().hand(hand);
    exists = held != nullptr && held->guest == body.guest();
  } else {
    exists = body.own().has_hand(hand);
  }
  return exists ? Status(Success{})
                : usage_error("body '" + body.name() + "' has no hand " + std::to_string(hand));
}

// As a scene's hand.
Result<std::size_t> grab_guest(tremolo_world& world, const Known& body, tremolo::VertexId vertex,
                               double stiffness, double damping) {
  tremolo::MixedGuests& guests = *world.made.guests;
  const Result<std::size_t> point = guests.point_of_vertex(body.guest(), vertex);
  if (!point) return point.error();
  if (std::isfinite(guests.mass_at(body.guest(), *point)))
    limit_spring(guests.stiffest_hand(body.guest(), *point), world.world.step_size(), stiffness,
                 damping);
  return guests.hold(body.guest(), *point, {stiffness, damping});
}

// Positions or velocities of a guest at its drawn vertices.
template <class Real>
void place_guest(const Known& body, bool velocities, Real* out) {
  if (const tremolo::TetStep* step = body.tets()) {
    const tremolo::TetBody& tets = step->body();
    std::vector<Vector3d>& vertices = body.all.vertices;
    vertices.resize(body.vertices());
    body.all.normals.resize(body.vertices());
    // Velocities of the surface are sums of those of control points with the same weights.
    body.all.made.kind(body.guest())
        .surface->place(velocities ? tets.velocities() : tets.positions(), vertices,
                        body.all.normals);
    for (const Vector3d& one : vertices)
      for (const double value : one) *out++ = static_cast<Real>(value);
    return;
  }
  const tremolo::NodalState& state = body.cloth()->state();
  const Eigen::VectorXd& values = velocities ? state.v : state.x;
  for (const Eigen::Index particle : body.all.guests[body.guest()].particles)
    for (Eigen::Index k = 0; k < 3; ++k) *out++ = static_cast<Real>(values[3 * particle + k]);
}

template <class Real>
tremolo_status positions(const tremolo_world* world, std::uint32_t body, Real* out,
                         std::size_t length) noexcept {
  return with_body(world, body, [&](const Known& known) -> Status {
    if (Status s = need_buffer(out, length, 3 * known.vertices()); !s) return s;
    if (known.is_guest()) {
      place_guest(known, false, out);
      return Success{};
    }
    const std::span<Real> numbers(out, length);
    if constexpr (sizeof(Real) == sizeof(float))
      return known.own().surface(numbers);
    else
      return known.own().surface_positions(numbers);
  });
}

tremolo_energy_account account_of_own(const Known& body) {
  const tremolo::EnergyAccount a = body.world().account(body.number);
  return {.kinetic = a.kinetic,
          .potential = a.potential,
          .contact = a.contact,
          .at_start = a.at_start,
          .load = a.load,
          .support = a.support,
          .gravity = a.gravity,
          .wind = 0.0,
          .contact_given = a.contact_given,
          .restitution = a.restitution,
          .friction = a.friction,
          .hand = a.hand,
          .joint = a.joint,
          .damping = a.damping,
          .method = 0.0,
          .remainder = a.remainder()};
}

tremolo_energy_account account_of_guest(const Known& body) {
  const tremolo::GuestEnergy now = energy_of(body.guests(), body.guest());
  const tremolo::GuestEnergy& start = body.all.made.at_start[body.guest()];
  const tremolo::ContactSums& sums = body.guests().sums(body.guest());
  tremolo_energy_account a{};
  a.kinetic = now.kinetic;
  a.potential = now.elastic;
  a.contact = body.guests().account(body.guest()).energy;
  a.at_start = start.kinetic + start.elastic;
  a.contact_given = sums.given;
  a.restitution = 0.0 - sums.lost;
  a.friction = 0.0 - sums.friction_loss;
  a.hand = sums.hand;
  a.joint = sums.joint;
  const double change = a.kinetic + a.potential + a.contact - a.at_start;
  if (const tremolo::ClothBody* cloth = body.cloth()) {
    const tremolo::ClothWork& work = cloth->work();
    a.gravity = work.gravity;
    a.wind = work.wind;
    a.support = work.pins;
    a.damping = 0.0 - work.damped;
    a.method = work.numerical;
    a.remainder = change - (a.gravity + a.wind + a.support + a.damping + a.method +
                            a.contact_given + a.restitution + a.friction + a.hand + a.joint);
    return a;
  }
  a.gravity = start.gravity - now.gravity;
  a.method = change - (a.gravity + a.contact_given + a.restitution + a.friction + a.hand + a.joint);
  return a;
}

tremolo::Momenta momenta_of(const Known& body) {
  if (const tremolo::TetStep* step = body.tets())
    return {step->body().momentum(), step->body().angular_momentum()};
  if (body.cloth() != nullptr) return body.cloth()->momenta();
  return body.world().momenta(body.number);
}

}  // namespace

size_t tremolo_world_bodies(const tremolo_world* world) {
  return world == nullptr ? 0 : count_of(*world);
}

tremolo_status tremolo_world_find(const tremolo_world* world, const char* name, uint32_t* body) {
  return with_all({{world, "the world"}, {name, "the name"}, {body, "the place for the number"}},
                  [&]() -> Status {
                    for (std::size_t i = 0; i < count_of(*world); ++i) {
                      if (Known{*world, i}.name() != name) continue;
                      *body = static_cast<uint32_t>(i);
                      return Success{};
                    }
                    return usage_error("there is no body '" + std::string(name) + "'");
                  });
}

const char* tremolo_world_name(const tremolo_world* world, uint32_t body) {
  return exists(world, body) ? Known{*world, body}.name().c_str() : nullptr;
}

tremolo_status tremolo_world_kind(const tremolo_world* world, uint32_t body,
                                  tremolo_body_kind* kind) {
  return with_body(world, body, [&](const Known& known) -> Status {
    if (Status s = need({{kind, "the place for the kind"}}); !s) return s;
    *kind = known.kind();
    return Success{};
  });
}

size_t tremolo_world_vertices(const tremolo_world* world, uint32_t body) {
  return exists(world, body) ? Known{*world, body}.vertices() : 0;
}

size_t tremolo_world_triangles(const tremolo_world* world, uint32_t body) {
  return exists(world, body) ? Known{*world, body}.triangles().size() : 0;
}

tremolo_status tremolo_world_triangle_corners(const tremolo_world* world, uint32_t body,
                                              uint32_t* out, size_t length) {
  return with_body(world, body, [&](const Known& known) {
    return tremolo::c_api::fill_buffer(known.triangles(), out, length);
  });
}

tremolo_status tremolo_world_positions_float(const tremolo_world* world, uint32_t body, float* out,
                                             size_t length) {
  return positions(world, body, out, length);
}

tremolo_status tremolo_world_positions_double(const tremolo_world* world, uint32_t body,
                                              double* out, size_t length) {
  return positions(world, body, out, length);
}

tremolo_status tremolo_world_velocities(const tremolo_world* world, uint32_t body, double* out,
                                        size_t length) {
  return with_body(world, body, [&](const Known& known) -> Status {
    if (Status s = need_buffer(out, length, 3 * known.vertices()); !s) return s;
    if (!known.is_guest()) return surface_velocities(known.own(), std::span(out, length));
    place_guest(known, true, out);
    return Success{};
  });
}

tremolo_status tremolo_world_account(const tremolo_world* world, uint32_t body,
                                     tremolo_energy_account* account) {
  return with_body(world, body, [&](const Known& known) -> Status {
    if (Status s = need({{account, "the place for the account"}}); !s) return s;
    *account = known.is_guest() ? account_of_guest(known) : account_of_own(known);
    return Success{};
  });
}

tremolo_status tremolo_world_momentum(const tremolo_world* world, uint32_t body, double linear[3],
                                      double angular[3]) {
  return with_body(world, body, [&](const Known& known) -> Status {
    const tremolo::Momenta momenta = momenta_of(known);
    put(momenta.linear, linear);
    put(momenta.angular, angular);
    return Success{};
  });
}

tremolo_status tremolo_world_contact(const tremolo_world* world, uint32_t body, int64_t* contacts,
                                     double* penetration, double force[3], int32_t* points) {
  return with_body(world, body, [&](const Known& known) -> Status {
    const SceneWorld& all = known.world();
    const bool guest = known.is_guest();
    const tremolo::ContactAccount account =
        guest ? known.guests().account(known.guest()) : known.own().contact_account();
    double depth =
        guest ? known.guests().penetration_max(known.guest()) : all.penetration_max(known.number);
    if (!guest && known.own().contact() != nullptr)
      depth *= known.own().contact()->surface().points->extent;
    put(guest ? known.guests().contacts(known.guest()) : all.contacts(known.number), contacts);
    put(depth, penetration);
    put(Vector3d(account.impulse_vector / all.step_size()), force);
    put(account.active, points);
    return Success{};
  });
}

tremolo_status tremolo_world_look(const tremolo_world* world, uint32_t body, int32_t* asleep,
                                  int32_t* failed) {
  return with_body(world, body, [&](const Known& known) -> Status {
    const bool guest = known.is_guest();
    put(guest || !known.world().asleep(known.number) ? 0 : 1, asleep);
    const bool over =
        guest ? known.guests().failed(known.guest()) : known.world().failed(known.number);
    put(over ? 1 : 0, failed);
    return Success{};
  });
}

tremolo_status tremolo_world_pose(const tremolo_world* world, uint32_t body, double position[3],
                                  double quaternion[4]) {
  return with_body(world, body, [&](const Known& known) -> Status {
    if (Status s = need_own(known, "it has no frame"); !s) return s;
    const tremolo::Pose pose = known.own().pose();
    put(pose.position, position);
    const Eigen::Quaterniond& q = pose.rotation;
    put(Eigen::Vector4d(q.w(), q.x(), q.y(), q.z()), quaternion);
    return Success{};
  });
}

tremolo_status tremolo_world_grab(tremolo_world* world, uint32_t body, uint32_t vertex,
                                  double stiffness, double damping, uint64_t* hand) {
  return with_body(world, body, [&](const Known& known) -> Status {
    if (Status s = need({{hand, "the place for the hand"}}); !s) return s;
    if (vertex > static_cast<std::uint32_t>(std::numeric_limits<tremolo::VertexId>::max()))
      return tremolo::content_error("there is no vertex " + std::to_string(vertex));
    const auto id = static_cast<tremolo::VertexId>(vertex);
    const Result<std::size_t> made = known.is_guest()
                                         ? grab_guest(*world, known, id, stiffness, damping)
                                         : world->world.body(body).grab(id, stiffness, damping);
    if (!made) return made.error();
    *hand = *made;
    return Success{};
  });
}

tremolo_status tremolo_world_move_hand(tremolo_world* world, uint32_t body, uint64_t hand,
                                       const double place[3]) {
  return with_body(world, body, [&](const Known& known) -> Status {
    if (Status s = need({{place, "the place"}}); !s) return s;
    if (!known.is_guest()) return world->world.body(body).move_hand(hand, Vector3d(place));
    if (Status s = need_hand(known, hand); !s) return s;
    return world->made.guests->move_hand(hand, Vector3d(place));
  });
}

tremolo_status tremolo_world_hand_force(const tremolo_world* world, uint32_t body, uint64_t hand,
                                        double force[3]) {
  return with_body(world, body, [&](const Known& known) -> Status {
    if (Status s = need({{force, "the place for the force"}}); !s) return s;
    if (Status s = need_hand(known, hand); !s) return s;
    put(known.is_guest() ? known.guests().hand(hand)->force : known.own().hand_force(hand), force);
    return Success{};
  });
}

tremolo_status tremolo_world_let_go(tremolo_world* world, uint32_t body, uint64_t hand) {
  return with_body(world, body, [&](const Known& known) -> Status {
    if (!known.is_guest()) return world->world.body(body).release(hand);
    if (Status s = need_hand(known, hand); !s) return s;
    world->made.guests->let_go(hand);
    return Success{};
  });
}

tremolo_status tremolo_world_apply_force(tremolo_world* world, uint32_t body, uint32_t vertex,
                                         const double force[3], int32_t steps) {
  return with_body(world, body, [&](const Known& known) -> Status {
    if (Status s = need({{force, "the force"}}); !s) return s;
    if (Status s = need_own(known, "it takes no forces on vertices"); !s) return s;
    const Result<tremolo::VertexId> id = tremolo::c_api::to_vertex(vertex);
    if (!id) return id.error();
    return world->world.body(body).apply_force(*id, Vector3d(force), steps);
  });
}
