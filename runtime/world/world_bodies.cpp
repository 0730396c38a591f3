// World: its bodies, their surfaces, balances and hands.
#include <algorithm>
#include <cmath>

#include "common/overflow.h"
#include "common/text.h"
#include "runtime/bodies/reduced/surface_velocity.h"
#include "runtime/contact/solve/contact_step.h"
#include "runtime/world/guest_loads.h"
#include "runtime/world/world.h"

namespace tremolo {

using Eigen::Vector3d;

Status World::check(WorldBody body) const {
  if (body.slot < slots_.size() && slots_[body.slot].used &&
      slots_[body.slot].generation == body.generation)
    return Success{};
  const bool was = body.slot < slots_.size() && body.generation > 0 &&
                   body.generation <= slots_[body.slot].generation;
  return usage_error("body " + std::to_string(body.slot) + " of generation " +
                     std::to_string(body.generation) +
                     (was ? " has been removed" : " does not exist"));
}

std::vector<WorldBody> World::bodies() const {
  std::vector<WorldBody> all;
  for (std::size_t k = 0; k < slots_.size(); ++k)
    if (slots_[k].used) all.push_back({static_cast<std::uint32_t>(k), slots_[k].generation});
  return all;
}

std::size_t World::size() const {
  return slots_.size() - free_.size();
}

std::optional<WorldBody> World::find(const std::string& name) const {
  for (const WorldBody body : bodies())
    if (this->name(body) == name) return body;
  return std::nullopt;
}

const ClothBody* World::cloth(WorldBody body) const {
  const ClothStep* step = is_guest(body) ? guests()->cloth(index(body)) : nullptr;
  return step != nullptr ? &step->body() : nullptr;
}

const TetStep* World::tets(WorldBody body) const {
  return is_guest(body) ? guests()->tets(index(body)) : nullptr;
}

const ContactBody* World::reduced(WorldBody body) const {
  return is_guest(body) ? nullptr : &own_.body(index(body));
}

const std::string& World::name(WorldBody body) const {
  return is_guest(body) ? guests()->name(index(body)) : own_.name(index(body));
}

WorldBodyKind World::kind(WorldBody body) const {
  if (tets(body) != nullptr) return WorldBodyKind::kTets;
  if (cloth(body) != nullptr) return WorldBodyKind::kCloth;
  return own_.scene().bodies[index(body)].rigid ? WorldBodyKind::kRigid : WorldBodyKind::kReduced;
}

bool World::asleep(WorldBody body) const {
  return is_guest(body) ? guests()->asleep(index(body)) : own_.asleep(index(body));
}

bool World::failed(WorldBody body) const {
  return is_guest(body) ? guests()->failed(index(body)) : own_.failed(index(body));
}

std::size_t World::vertices(WorldBody body) const {
  if (tets(body) != nullptr) return guest(body).kind->surface->vertices();
  if (cloth(body) != nullptr) return guest(body).particles.size();
  return reduced(body)->model().drawn().rest.size();
}

std::span<const Triangle> World::triangles(WorldBody body) const {
  if (tets(body) != nullptr) return guest(body).kind->surface->rest().triangles;
  if (cloth(body) == nullptr) return reduced(body)->model().drawn().triangles;
  const ClothParts& parts = cloth(body)->model().parts();
  return parts.drawn ? parts.drawn->triangles : parts.triangles;
}

// Positions or velocities of a guest at its drawn vertices.
template <class Real>
void World::place_guest(WorldBody body, bool velocities, Real* out) const {
  if (const TetStep* step = tets(body)) {
    const TetBody& of = step->body();
    vertices_.resize(vertices(body));
    normals_.resize(vertices(body));
    // Velocities of the surface are sums of those of control points with the same weights.
    guest(body).kind->surface->place(velocities ? of.velocities() : of.positions(), vertices_,
                                     normals_);
    for (const Vector3d& one : vertices_)
      for (const double value : one) *out++ = static_cast<Real>(value);
    return;
  }
  const NodalState& state = cloth(body)->state();
  const Eigen::VectorXd& values = velocities ? state.v : state.x;
  for (const Eigen::Index particle : guest(body).particles)
    for (Eigen::Index k = 0; k < 3; ++k) *out++ = static_cast<Real>(values[3 * particle + k]);
}

Status World::positions(WorldBody body, std::span<float> out) const {
  if (!is_guest(body)) return reduced(body)->surface(out);
  place_guest(body, false, out.data());
  return Success{};
}

Status World::positions(WorldBody body, std::span<double> out) const {
  if (!is_guest(body)) return reduced(body)->surface_positions(out);
  place_guest(body, false, out.data());
  return Success{};
}

Status World::velocities(WorldBody body, std::span<double> out) const {
  if (!is_guest(body)) return surface_velocities(*reduced(body), out);
  place_guest(body, true, out.data());
  return Success{};
}

WorldAccount World::account(WorldBody body) const {
  WorldAccount all;
  EnergyAccount& a = all.sums;
  if (!is_guest(body)) {
    a = own_.account(index(body));
    all.remainder = a.remainder();
    return all;
  }
  const GuestEnergy now = energy_of(*guests(), index(body));
  const GuestEnergy& start = guest(body).at_start;
  const ContactSums& sums = guests()->sums(index(body));
  a.kinetic = now.kinetic;
  a.potential = now.elastic;
  a.contact = guests()->account(index(body)).energy;
  a.at_start = start.kinetic + start.elastic;
  a.contact_given = sums.given;
  a.restitution = 0.0 - sums.lost;
  a.friction = 0.0 - sums.friction_loss;
  a.hand = sums.hand;
  a.joint = sums.joint;
  a.load = guests()->load_work(index(body));
  if (cloth(body) != nullptr) {
    account_of_cloth(body, all);
  } else {
    a.gravity = start.gravity - now.gravity;
    all.method = a.total() - a.at_start - a.given();
  }
  return all;
}

void World::account_of_cloth(WorldBody body, WorldAccount& all) const {
  EnergyAccount& a = all.sums;
  const ClothWork& work = cloth(body)->work();
  a.gravity = work.gravity;
  a.support = work.pins;
  a.damping = 0.0 - work.damped;
  all.wind = work.wind;
  all.method = work.numerical;
  all.remainder = a.total() - a.at_start - (a.given() + all.wind + all.method);
}

Momenta World::momenta(WorldBody body) const {
  if (const TetStep* step = tets(body))
    return {step->body().momentum(), step->body().angular_momentum()};
  if (cloth(body) != nullptr) return cloth(body)->momenta();
  return own_.momenta(index(body));
}

WorldContact World::contact(WorldBody body) const {
  WorldContact all;
  ContactAccount last;
  if (is_guest(body)) {
    last = guests()->account(index(body));
    all.contacts = guests()->contacts(index(body));
    all.penetration = guests()->penetration_max(index(body));
  } else {
    last = reduced(body)->contact_account();
    all.contacts = own_.contacts(index(body));
    if (const ContactStep* contact = reduced(body)->contact())
      all.penetration = own_.penetration_max(index(body)) * contact->surface().points->extent;
  }
  all.force = last.impulse_vector / own_.step_size();
  all.points = last.active;
  return all;
}

Status World::need_own(WorldBody body, const char* what) const {
  if (!is_guest(body)) return Success{};
  return usage_error("body '" + name(body) + "' is of kind \"" +
                     (tets(body) != nullptr ? "tets" : "cloth") + "\": " + what);
}

Status World::move(WorldBody body, const Pose& next) {
  if (Status s = need_own(body, "it has no frame"); !s) return s;
  return own_.move_body(index(body), next);
}

Status World::apply_force(WorldBody body, VertexId vertex, const Vector3d& force, int steps) {
  if (Status s = check_force(body, force); !s) return s;
  if (!is_guest(body)) return own_.body(index(body)).apply_force(vertex, force, steps);
  MixedGuests& all = all_guests();
  const Result<std::size_t> point = all.point_of_vertex(index(body), vertex);
  if (!point) return content_error("body '" + name(body) + "': " + point.error().message);
  return all.apply_force(index(body), *point, force, steps);
}

// A rigid body has no coordinates that overflow, but an energy.
Status World::check_force(WorldBody body, const Vector3d& force) const {
  if (!force.allFinite()) return usage_error("body '" + name(body) + "': the force is not finite");
  if (std::isfinite(force.squaredNorm())) return Success{};
  return usage_error("body '" + name(body) + "': the force of " +
                     number_text(force.lpNorm<Eigen::Infinity>()) +
                     " N is so large that numbers overflow: make it smaller");
}

Status World::add_load(WorldBody body, const SceneLoad& load) {
  if (Status s = check_force(body, load.scale * load.force); !s) return s;
  if (const Status s = check_signal_size(load.signal); !s)
    return usage_error("body '" + name(body) + "': " + s.error().message);
  if (!is_guest(body)) return own_.add_load(index(body), load);
  const Status added = add_guest_loads(all_guests(), index(body), std::span(&load, 1));
  if (!added) return added.error();
  own_.note_guest_load(name(body), load);
  return Success{};
}

Status World::check_spring(WorldBody body, double stiffness, double damping) const {
  for (const double value : {stiffness, damping})
    if (!(value >= 0.0) || !std::isfinite(value))
      return usage_error("body '" + name(body) +
                         "': the stiffness and the damping of a hand must be finite and not "
                         "negative");
  return Success{};
}

Result<std::size_t> World::grab(WorldBody body, VertexId vertex, double stiffness, double damping) {
  if (Status s = check_spring(body, stiffness, damping); !s) return s.error();
  if (!is_guest(body))
    return own_.hold_body(index(body),
                          [&](ContactBody& own) { return own.grab(vertex, stiffness, damping); });
  MixedGuests& all = all_guests();
  const Result<std::size_t> point = all.point_of_vertex(index(body), vertex);
  if (!point) return point.error();
  if (std::isfinite(all.mass_at(index(body), *point)))
    limit_spring(all.stiffest_hand(index(body), *point), step_size(), stiffness, damping);
  return all.hold(index(body), *point, {stiffness, damping});
}

Result<std::size_t> World::grab(const WorldSite& site, double stiffness, double damping) {
  if (Status s = check_spring(site.body, stiffness, damping); !s) return s.error();
  const std::span<const Triangle> all = triangles(site.body);
  if (site.triangle >= all.size())
    return usage_error("body '" + name(site.body) + "' has no triangle " +
                       std::to_string(site.triangle));
  if (!is_guest(site.body))
    return own_.hold_body(index(site.body), [&](ContactBody& own) {
      return own.grab(SurfacePlace{SurfaceKind::kDrawn, site.triangle, site.weights}, stiffness,
                      damping);
    });
  Eigen::Index corner = 0;
  site.weights.maxCoeff(&corner);
  const auto drawn = static_cast<std::size_t>(all[site.triangle][static_cast<std::size_t>(corner)]);
  // Points of contact are known by vertices of the mesh or file.
  std::vector<double> places(3 * vertices(site.body));
  if (Status s = positions(site.body, std::span(places)); !s) return s.error();
  MixedGuests& guests = all_guests();
  const std::size_t point =
      guests.point_near(index(site.body), Vector3d(places.data() + 3 * drawn));
  if (std::isfinite(guests.mass_at(index(site.body), point)))
    limit_spring(guests.stiffest_hand(index(site.body), point), step_size(), stiffness, damping);
  return guests.hold(index(site.body), point, {stiffness, damping});
}

Status World::check_hand(WorldBody body, std::size_t hand) const {
  bool exists = false;
  if (is_guest(body)) {
    const GuestHand* held = guests()->hand(hand);
    exists = held != nullptr && held->guest == index(body);
  } else {
    exists = reduced(body)->has_hand(hand);
  }
  return exists ? Status(Success{})
                : usage_error("body '" + name(body) + "' has no hand " + std::to_string(hand));
}

Status World::move_hand(WorldBody body, std::size_t hand, const Vector3d& place) {
  if (Status s = check_hand(body, hand); !s) return s;
  if (const double far = place.lpNorm<Eigen::Infinity>(); overflows(far) && std::isfinite(far))
    return usage_error("body '" + name(body) + "': " + overflow_text("the hand's place", far, "m"));
  if (is_guest(body)) return all_guests().move_hand(hand, place);
  return own_.body(index(body)).move_hand(hand, place);
}

Result<Vector3d> World::hand_force(WorldBody body, std::size_t hand) const {
  if (Status s = check_hand(body, hand); !s) return s.error();
  return is_guest(body) ? guests()->hand(hand)->force : reduced(body)->hand_force(hand);
}

Result<HandSpring> World::hand_spring(WorldBody body, std::size_t hand) const {
  if (Status s = check_hand(body, hand); !s) return s.error();
  if (!is_guest(body)) return reduced(body)->hand_spring(hand);
  const GuestHand& held = *guests()->hand(hand);
  return HandSpring{held.stiffness, held.damping};
}

Status World::let_go(WorldBody body, std::size_t hand) {
  if (Status s = check_hand(body, hand); !s) return s;
  if (!is_guest(body)) return own_.body(index(body)).release(hand);
  all_guests().let_go(hand);
  return Success{};
}

Status World::where(const WorldSite& site, Vector3d* position, Vector3d* velocity) const {
  const std::span<const Triangle> all = triangles(site.body);
  if (site.triangle >= all.size())
    return usage_error("body '" + name(site.body) + "' has no triangle " +
                       std::to_string(site.triangle));
  std::vector<double> values(3 * vertices(site.body));
  const auto mean = [&] {
    Vector3d sum = Vector3d::Zero();
    for (std::size_t c = 0; c < 3; ++c)
      sum += site.weights[static_cast<Eigen::Index>(c)] *
             Vector3d(values.data() + 3 * static_cast<std::size_t>(all[site.triangle][c]));
    return sum;
  };
  if (velocity != nullptr) {
    if (Status s = velocities(site.body, values); !s) return s;
    *velocity = mean();
  }
  if (position != nullptr) {
    if (Status s = positions(site.body, std::span(values)); !s) return s;
    *position = mean();
  }
  return Success{};
}

namespace {

// The first hit of the ray x + t d with a triangle, from either side, by its weights and t;
// nullopt: it misses.
struct RayHit {
  Vector3d weights;
  double t = 0.0;
};

std::optional<RayHit> hit_triangle(const Vector3d& x, const Vector3d& d, const Vector3d& a,
                                   const Vector3d& b, const Vector3d& c) {
  const Vector3d p = b - a, q = c - a, n = d.cross(q);
  const double volume = p.dot(n);
  if (std::abs(volume) < 1e-300) return std::nullopt;
  const Vector3d from = x - a, m = from.cross(p);
  const double u = from.dot(n) / volume, v = d.dot(m) / volume, t = q.dot(m) / volume;
  // A ray through an edge or a corner hits one of the triangles there.
  constexpr double kEdge = 1e-9;
  if (u < -kEdge || v < -kEdge || u + v > 1.0 + kEdge || t < 0.0) return std::nullopt;
  return RayHit{{1.0 - u - v, u, v}, t};
}

}  // namespace

Result<std::optional<WorldHit>> World::pick(const Vector3d& origin,
                                            const Vector3d& direction) const {
  const auto found = own_.pick(origin, direction);
  if (!found) return found.error();
  const double length = direction.norm();
  if (!origin.allFinite() || !std::isfinite(length) || length == 0.0)
    return usage_error("a ray needs a finite origin and a direction that is not zero");
  WorldHit nearest;
  bool hits = found->has_value();
  if (hits) {
    const SurfaceHit& hit = (*found)->hit;
    nearest = WorldHit{{body_of((*found)->body), hit.place.triangle, hit.place.weights},
                       hit.distance,
                       hit.point,
                       hit.vertex};
  }
  std::vector<double> places;
  for (const WorldBody body : bodies()) {
    if (!is_guest(body)) continue;
    places.resize(3 * vertices(body));
    place_guest(body, false, places.data());
    const std::span<const Triangle> all = triangles(body);
    const auto corner = [&](std::size_t k, std::size_t c) {
      return Vector3d(places.data() + 3 * static_cast<std::size_t>(all[k][c]));
    };
    for (std::size_t k = 0; k < all.size(); ++k) {
      const auto hit =
          hit_triangle(origin, direction / length, corner(k, 0), corner(k, 1), corner(k, 2));
      if (hit && (!hits || hit->t < nearest.distance)) {
        hits = true;
        nearest = WorldHit{{body, k, hit->weights}, hit->t, origin + hit->t / length * direction};
      }
    }
  }
  return hits ? std::optional(nearest) : std::nullopt;
}

}  // namespace tremolo
