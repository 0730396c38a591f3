#include "runtime/mixed/mixed_guests.h"

#include <algorithm>
#include <cmath>

#include "common/text.h"

namespace tremolo {
namespace {

// Memories know obstacles by one number: bodies by theirs, colliders from here on.
constexpr std::size_t kFirstCollider = std::size_t{1} << 40;

Status check(const ContactOptions& options) {
  if (!(options.margin > 0.0) || !(options.stiffness > 0.0) || !std::isfinite(options.margin) ||
      !std::isfinite(options.stiffness))
    return usage_error("contact needs a margin and a stiffness above zero");
  if (options.modulus && !(*options.modulus > 0.0 && std::isfinite(*options.modulus)))
    return usage_error("contact needs a modulus above zero, in Pa");
  if (!(options.friction >= 0.0) || !std::isfinite(options.friction))
    return usage_error("the friction is " + number_text(options.friction) +
                       ", must be finite and not negative");
  if (!(options.restitution >= 0.0 && options.restitution <= 1.0))
    return usage_error("the restitution is " + number_text(options.restitution) +
                       ", must be from 0 to 1");
  return Success{};
}

std::string other_step(double own, double world) {
  return "its step is " + number_text(own) + " s, but that of the world is " + number_text(world) +
         " s";
}

Error named(const std::string& name, const std::string& what) {
  return usage_error("body '" + name + "': " + what);
}

}  // namespace

Result<std::size_t> MixedGuests::add(std::string name, TetBody body, const ContactOptions& contact,
                                     TetHullPointer hull) {
  if (body.options().step != step_) return named(name, other_step(body.options().step, step_));
  if (Status good = check(contact); !good) return named(name, good.error().message);
  if (body.hand()) return named(name, "a body of tetrahedra with a grab cannot meet other bodies");
  const TetModel* model = &body.model();
  auto known = std::find_if(points_.begin(), points_.end(),
                            [model](const auto& entry) { return entry.first == model; });
  if (known == points_.end()) known = points_.insert(known, {model, make_tet_points(*model)});
  auto guest = std::make_unique<Guest>(Guest{.name = std::move(name)});
  guest->tet_body.emplace(std::move(body));
  auto step = std::make_unique<TetStep>(*guest->tet_body, known->second, contact, std::move(hull));
  guest->tets = step.get();
  guest->step = std::move(step);
  guests_.push_back(std::move(guest));
  return guests_.size() - 1;
}

Result<std::size_t> MixedGuests::add(ClothBody body, const ContactOptions& contact) {
  const SceneCloth& cloth = body.cloth();
  const std::string& name = cloth.name;
  if (body.options().step != step_) return named(name, other_step(body.options().step, step_));
  if (const std::string problem = cloth_method_problem(body.integrator()); !problem.empty())
    return named(name, problem);
  if (!(cloth.thickness > 0.0))
    return named(name,
                 "a cloth among other bodies needs a thickness above 0 m, which is the distance at "
                 "which its contact begins");
  if (Status good = check(contact); !good) return named(name, good.error().message);
  auto guest = std::make_unique<Guest>(Guest{.name = name});
  guest->cloth_body.emplace(std::move(body));
  auto step = std::make_unique<ClothStep>(*guest->cloth_body, contact);
  guest->cloth = step.get();
  guest->step = std::move(step);
  guests_.push_back(std::move(guest));
  return guests_.size() - 1;
}

double MixedGuests::deepest_in(std::size_t i, std::span<const PlacedCollider> colliders) const {
  double deepest = 0.0;
  const GuestStep& step = *guests_[i]->step;
  for (const PlacedCollider& collider : colliders)
    for (std::size_t k = 0; k < step.points(); ++k) {
      const Eigen::Vector3d local =
          collider.start.rotation.conjugate() * (step.start_of(k) - collider.start.position);
      deepest = std::max(deepest, -signed_distance(collider.shape, local).distance);
    }
  return deepest;
}

void MixedGuests::start(std::span<const PlacedCollider> colliders) {
  colliders_ = colliders;
  report_ = {};
  in_islands_ = 0;
  for (const auto& guest : guests_)
    if (!guest->failed) guest->step->start();
}

SharedRate* MixedGuests::next_rate() {
  if (rate_count_ == rates_.size()) rates_.emplace_back();
  return &rates_[rate_count_++];
}

void MixedGuests::meet_colliders(std::size_t guest) {
  for (std::size_t c = 0; c < colliders_.size(); ++c) {
    if (collider_count_ == on_colliders_.size()) on_colliders_.emplace_back();
    ColliderContact& contact = on_colliders_[collider_count_];
    if (!contact.gather(*guests_[guest]->step, colliders_[c], kFirstCollider + c, step_)) continue;
    ++collider_count_;
    contact.shared = next_rate();
    met_.push_back({bodies_ + guest, PairForces::kNobody, &contact});
  }
}

// Points of a member, by its number in links(), on a guest. False: none is near, or the guest is a
// cloth, which has no inside.
bool MixedGuests::meet_hull(StepBody& points, std::size_t number, std::size_t guest,
                            SharedRate* shared) {
  if (guests_[guest]->tets == nullptr) return false;
  if (hull_count_ == hulls_.size()) hulls_.emplace_back();
  HullContact& contact = hulls_[hull_count_];
  if (!contact.gather(points, *guests_[guest]->tets, bodies_ + guest, step_)) return false;
  ++hull_count_;
  contact.shared = shared;
  met_.push_back({number, bodies_ + guest, &contact});
  return true;
}

// Points of each of two bodies on the other have one rate.
void MixedGuests::meet_bodies(std::size_t guest, std::span<ContactStep* const> contacts) {
  for (std::size_t b = 0; b < contacts.size(); ++b) {
    if (contacts[b] == nullptr) continue;
    if (bent_count_ == bent_.size()) bent_.emplace_back();
    BentContact& contact = bent_[bent_count_];
    SharedRate* shared = next_rate();
    const bool on_body = contact.gather(*guests_[guest]->step, *contacts[b], b);
    if (on_body) {
      ++bent_count_;
      contact.shared = shared;
      met_.push_back({bodies_ + guest, b, &contact});
    }
    reduced_[b].set({.contact = contacts[b]});
    const bool on_guest = meet_hull(reduced_[b], b, guest, shared);
    if (on_body || on_guest) links_.emplace_back(bodies_ + guest, b);
  }
}

void MixedGuests::meet_guests(std::size_t guest) {
  for (std::size_t other = guest + 1; other < guests_.size(); ++other) {
    if (guests_[other]->failed) continue;
    SharedRate* shared = next_rate();
    const bool here = meet_hull(*guests_[other]->step, bodies_ + other, guest, shared);
    const bool there = meet_hull(*guests_[guest]->step, bodies_ + guest, other, shared);
    if (here || there) links_.emplace_back(bodies_ + guest, bodies_ + other);
  }
}

void MixedGuests::find_contacts(std::span<ContactStep* const> contacts) {
  bodies_ = contacts.size();
  while (reduced_.size() < bodies_) reduced_.emplace_back();
  bent_count_ = hull_count_ = collider_count_ = rate_count_ = 0;
  met_.clear();
  links_.clear();
  for (std::size_t guest = 0; guest < guests_.size(); ++guest) {
    if (guests_[guest]->failed) continue;
    meet_colliders(guest);
    meet_bodies(guest, contacts);
    meet_guests(guest);
  }
}

void MixedGuests::begin_island() {
  who_.clear();
  island_.clear();
  couplings_.clear();
  pair_count_ = 0;
  member_.resize(guests_.size());
}

// The guests of that root follow the members so far.
void MixedGuests::add_guests(std::span<const std::size_t> roots, std::size_t root) {
  for (std::size_t guest = 0; guest < guests_.size(); ++guest) {
    if (roots[guest] != root || guests_[guest]->failed) continue;
    member_[guest] = island_.size();
    who_.push_back(guest);
    island_.push_back(guests_[guest]->step.get());
  }
}

// Couples the reduced bodies of an island with each other.
void MixedGuests::pair_bodies(std::span<const IslandMember> members, std::span<PairPoint> points,
                              std::span<IslandJoint> joints) {
  const std::size_t before = couplings_.size();
  const auto pair_of = [&](std::size_t i, std::size_t k) -> ReducedPair& {
    const auto [low, high] = std::minmax(i, k);
    for (std::size_t c = before; c < couplings_.size(); ++c)
      if (couplings_[c]->first == low && couplings_[c]->second == high) return pairs_[c - before];
    if (pair_count_ == pairs_.size()) pairs_.emplace_back();
    ReducedPair& pair = pairs_[pair_count_++];
    pair.set(members[low], members[high], step_);
    pair.first = low;
    pair.second = high;
    pair.shared = next_rate();
    couplings_.push_back(&pair);
    return pair;
  };
  for (PairPoint& point : points) {
    const bool on_first = point.a < point.b;
    pair_of(point.a, point.b).take(point, on_first);
  }
  for (const IslandJoint& joint : joints) pair_of(joint.a, joint.b).take(joint, joint.a < joint.b);
}

// Adds the contacts of the guests of that root, once all members are in the island.
void MixedGuests::couple(std::span<const std::size_t> roots, std::size_t root,
                         std::span<const IslandMember> members) {
  const auto place = [&](std::size_t number) {
    if (number == PairForces::kNobody) return number;
    if (number >= bodies_) return member_[number - bodies_];
    const auto found =
        std::find_if(members.begin(), members.end(),
                     [number](const IslandMember& member) { return member.number == number; });
    return found != members.end() ? static_cast<std::size_t>(found - members.begin())
                                  : island_.size();
  };
  for (const Met& met : met_) {
    const std::size_t guest = (met.first >= bodies_ ? met.first : met.second) - bodies_;
    if (roots[guest] != root) continue;
    met.forces->first = place(met.first);
    met.forces->second = place(met.second);
    // A body whose step could not begin is not a member.
    if (met.forces->first < island_.size() &&
        (met.forces->second < island_.size() || met.second == PairForces::kNobody))
      couplings_.push_back(met.forces);
  }
}

void MixedGuests::step_island(std::span<const std::size_t> roots,
                              std::span<const IslandMember> members, std::vector<PairPoint>& points,
                              std::size_t& count, std::span<IslandJoint> joints,
                              std::span<StepReport> reports) {
  begin_island();
  for (const IslandMember& member : members) {
    reduced_[member.number].set(member);
    island_.push_back(&reduced_[member.number]);
  }
  pair_bodies(members, std::span(points).first(count), joints);
  add_guests(roots, members[0].number);
  couple(roots, members[0].number, members);
  const MixedReport report = solve_island();
  count = 0;
  for (std::size_t c = 0; c < pair_count_; ++c)
    pairs_[c].give_back(pairs_[c].first, pairs_[c].second, points, count);
  for (std::size_t m = 0; m < members.size(); ++m) {
    reports[m] = report.converged ? reduced_[members[m].number].report() : StepReport{};
    reports[m].converged = report.converged;
    reports[m].iterations = report.iterations;
  }
}

MixedReport MixedGuests::solve_island() {
  const MixedReport report = solver_.step(island_, couplings_);
  report_.iterations += report.iterations;
  report_.linear += report.linear;
  report_.residual = std::max(report_.residual, report.residual);
  report_.converged = report_.converged && report.converged;
  in_islands_ += island_.size();
  for (const std::size_t guest : who_) {
    guests_[guest]->failed = !report.converged;
    if (report.converged) book(guest);
  }
  return report;
}

void MixedGuests::step_others(std::span<const std::size_t> roots) {
  for (std::size_t root = 0; root < guests_.size(); ++root) {
    if (roots[root] != bodies_ + root || guests_[root]->failed) continue;
    begin_island();
    add_guests(roots, bodies_ + root);
    couple(roots, bodies_ + root, {});
    if (!couplings_.empty()) {
      solve_island();
      continue;
    }
    guests_[root]->failed = !guests_[root]->step->step_alone();
    if (!guests_[root]->failed) book(root);
  }
}

// Adds the contact of the step to the body's sums.
void MixedGuests::book(std::size_t guest) {
  Guest& of = *guests_[guest];
  const ContactAccount& account = of.step->account();
  of.sums.work += account.work;
  of.sums.lost += account.lost;
  of.sums.friction_loss += account.friction_loss;
  of.sums.given += account.given;
  of.sums.error += account.surplus;
  of.deepest = std::max(of.deepest, account.penetration);
  of.slip = std::max(of.slip, account.slip);
  const bool touches = account.active > 0;
  if (touches && !of.touched) ++of.contacts;
  of.touched = touches;
}

}  // namespace tremolo
