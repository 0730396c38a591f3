#include "runtime/mixed/mixed_guests.h"

#include <algorithm>
#include <cmath>

#include "common/overflow.h"
#include "common/text.h"

namespace tremolo {
namespace {

Status check(const ContactOptions& options) {
  if (!(options.margin > 0.0) || !(options.stiffness > 0.0) || !std::isfinite(options.margin) ||
      !std::isfinite(options.stiffness))
    return usage_error("contact needs a margin and a stiffness above zero");
  if (options.modulus && !(*options.modulus > 0.0 && std::isfinite(*options.modulus)))
    return usage_error("contact needs a modulus above zero, in Pa");
  if (overflows(options.stiffness))
    return usage_error(overflow_text("its contact-stiffness", options.stiffness, ""));
  if (options.modulus && overflows(*options.modulus))
    return usage_error(overflow_text("its contact-modulus", *options.modulus, "Pa"));
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
  return keep(std::move(guest));
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
  return keep(std::move(guest));
}

// The number of a body that was removed before, or the next one.
std::size_t MixedGuests::keep(std::unique_ptr<Guest> guest) {
  const auto free = std::find_if(guests_.begin(), guests_.end(),
                                 [](const auto& one) { return one->removed && one->old; });
  const auto number = static_cast<std::size_t>(free - guests_.begin());
  if (free == guests_.end())
    guests_.push_back(std::move(guest));
  else
    *free = std::move(guest);
  return number;
}

void MixedGuests::remove(std::size_t i) {
  Guest& guest = *guests_[i];
  for (Hand& held : hands_)
    if (held.used && held.hand.guest == i) held.used = false;
  for (Link& link : joined_) {
    const GuestJoint& joint = link.joint;
    if (joint.guest == i || (joint.to_guest && joint.other == i)) link.used = false;
  }
  forget_loads(i);
  guest.removed = guest.failed = true;
  // Another model may get the address of one that nobody uses any more.
  if (guest.tets != nullptr) {
    const TetModel* model = &guest.tets->body().model();
    const bool used = std::any_of(guests_.begin(), guests_.end(), [&](const auto& one) {
      return one->tets != nullptr && one.get() != &guest && &one->tets->body().model() == model;
    });
    if (!used) std::erase_if(points_, [model](const auto& entry) { return entry.first == model; });
  }
  guest.step.reset();
  guest.tets = nullptr;
  guest.cloth = nullptr;
  guest.tet_body.reset();
  guest.cloth_body.reset();
}

void MixedGuests::take_back(std::size_t i, std::size_t count) {
  remove(i);
  // A number that was free before may be used again at once.
  if (i < count)
    guests_[i]->old = true;
  else
    guests_.pop_back();
}

void MixedGuests::replay_step() {
  for (const auto& guest : guests_) guest->old = guest->removed;
}

std::size_t MixedGuests::point_near(std::size_t i, const Eigen::Vector3d& place) const {
  const GuestStep& step = *guests_[i]->step;
  std::size_t nearest = 0;
  for (std::size_t k = 1; k < step.points(); ++k)
    if ((step.start_of(k) - place).squaredNorm() < (step.start_of(nearest) - place).squaredNorm())
      nearest = k;
  return nearest;
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

double MixedGuests::deepest_in(std::size_t i, const Collider& shape,
                               const PresentPlace& place) const {
  double deepest = 0.0;
  const GuestStep& step = *guests_[i]->step;
  for (std::size_t k = 0; k < step.points(); ++k)
    deepest = std::max(deepest, place.depth_in(shape, step.start_of(k)));
  return deepest;
}

void MixedGuests::set_gravity(const Eigen::Vector3d& gravity) {
  for (const auto& guest : guests_) {
    if (guest->tets != nullptr) guest->tets->body().set_gravity(gravity);
    if (guest->cloth != nullptr) guest->cloth->body().set_gravity(gravity);
  }
}

void MixedGuests::start(std::span<const PlacedCollider> colliders) {
  colliders_ = colliders;
  length_ = step_;
  from_ = 0.0;
  to_ = 1.0;
  report_ = {};
  in_islands_ = 0;
  for (std::size_t i = 0; i < guests_.size(); ++i) {
    Guest& guest = *guests_[i];
    guest.old = guest.removed;
    if (guest.failed) continue;
    // A guest that sleeps stays where it is.
    if (!guest.rest.asleep || !guest.started) start(i);
    if (guest.rest.asleep && has_to_wake(i)) wake(i);
  }
}

void MixedGuests::start(std::size_t i) {
  prepare_loads(i);
  guests_[i]->step->start();
  guests_[i]->started = true;
}

SharedRate* MixedGuests::next_rate() {
  if (counts_.rates == rates_.size()) rates_.emplace_back();
  return &rates_[counts_.rates++];
}

void MixedGuests::meet_colliders(std::size_t guest) {
  for (std::size_t c = 0; c < colliders_.size(); ++c) {
    if (counts_.colliders == on_colliders_.size()) on_colliders_.emplace_back();
    ColliderContact& contact = on_colliders_[counts_.colliders];
    if (!contact.gather(*guests_[guest]->step, colliders_[c], kFirstCollider + c, length_))
      continue;
    ++counts_.colliders;
    contact.shared = next_rate();
    met_.push_back({bodies_ + guest, PairForces::kNobody, &contact});
  }
}

// Points of a member, by its number in links(), on a guest. False: none is near, or the guest is a
// cloth, which has no inside.
bool MixedGuests::meet_hull(StepBody& points, std::size_t number, std::size_t guest,
                            SharedRate* shared) {
  if (guests_[guest]->tets == nullptr) return false;
  if (counts_.hulls == hulls_.size()) hulls_.emplace_back();
  HullContact& contact = hulls_[counts_.hulls];
  if (!contact.gather(points, *guests_[guest]->tets, kFirstGuest + guest, length_)) return false;
  ++counts_.hulls;
  contact.shared = shared;
  met_.push_back({number, bodies_ + guest, &contact});
  return true;
}

// Points of each of two bodies on the other have one rate.
void MixedGuests::meet_bodies(std::size_t guest, std::span<ContactStep* const> contacts) {
  for (std::size_t b = 0; b < contacts.size(); ++b) {
    if (contacts[b] == nullptr || (asleep(guest) && awake_[b] == 0)) continue;
    if (!may_touch(guest, false, b)) continue;
    if (counts_.bent == bent_.size()) bent_.emplace_back();
    BentContact& contact = bent_[counts_.bent];
    SharedRate* shared = next_rate();
    const bool on_body = contact.gather(*guests_[guest]->step, *contacts[b], b);
    if (on_body) {
      ++counts_.bent;
      contact.shared = shared;
      met_.push_back({bodies_ + guest, b, &contact});
    }
    reduced_[b].set({.contact = contacts[b]});
    const bool on_guest = meet_hull(reduced_[b], b, guest, shared);
    if (on_body || on_guest) links_.emplace_back(bodies_ + guest, b);
  }
}

void MixedGuests::meet_guests(std::size_t guest, std::span<const std::size_t> others) {
  for (const std::size_t other : others) {
    if ((asleep(guest) && asleep(other)) || !may_touch(guest, true, other)) continue;
    SharedRate* shared = next_rate();
    const bool here = meet_hull(*guests_[other]->step, bodies_ + other, guest, shared);
    const bool there = meet_hull(*guests_[guest]->step, bodies_ + guest, other, shared);
    if (here || there) links_.emplace_back(bodies_ + guest, bodies_ + other);
  }
}

// Finds the contacts of these guests with each other, with bodies and with colliders, their hands,
// loads and joints.
void MixedGuests::meet(std::span<const std::size_t> guests,
                       std::span<ContactStep* const> contacts) {
  for (std::size_t k = 0; k < guests.size(); ++k) {
    meet_joints(guests[k]);
    if (!asleep(guests[k])) {
      meet_hands(guests[k]);
      meet_loads(guests[k]);
      meet_colliders(guests[k]);
    }
    meet_bodies(guests[k], contacts);
    meet_guests(guests[k], guests.subspan(k + 1));
  }
}

// Forgets all contacts but the first ones.
void MixedGuests::forget_contacts(const Counts& known) {
  counts_ = known;
  met_.resize(known.met);
  links_.resize(known.links);
}

void MixedGuests::find_contacts(std::span<ContactStep* const> contacts,
                                std::span<const char> awake) {
  bodies_ = contacts.size();
  awake_ = awake;
  while (reduced_.size() < bodies_) reduced_.emplace_back();
  forget_contacts({});
  who_.clear();
  for (std::size_t guest = 0; guest < guests_.size(); ++guest)
    if (!guests_[guest]->failed) who_.push_back(guest);
  meet(who_, contacts);
}

// The guests of that root are those of the present island.
void MixedGuests::choose_guests(std::span<const std::size_t> roots, std::size_t root) {
  who_.clear();
  for (std::size_t guest = 0; guest < guests_.size(); ++guest)
    if (roots[guest] == root && !guests_[guest]->failed) who_.push_back(guest);
}

// The members of an island are bodies, then guests.
void MixedGuests::add_members(std::span<const IslandMember> members) {
  island_.clear();
  couplings_.clear();
  pair_count_ = 0;
  for (const IslandMember& member : members) {
    reduced_[member.number].set(member);
    island_.push_back(&reduced_[member.number]);
  }
  member_.assign(guests_.size(), PairForces::kNobody);
  for (const std::size_t guest : who_) {
    member_[guest] = island_.size();
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
    pair.set(members[low], members[high], length_);
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

// Adds the contacts of the island's guests, of those found from index `from` on.
void MixedGuests::couple(std::size_t from, std::span<const IslandMember> members) {
  const auto place = [&](std::size_t number) {
    if (number == PairForces::kNobody) return number;
    if (number >= bodies_) return member_[number - bodies_];
    const auto found =
        std::find_if(members.begin(), members.end(),
                     [number](const IslandMember& member) { return member.number == number; });
    return found != members.end() ? static_cast<std::size_t>(found - members.begin())
                                  : island_.size();
  };
  for (std::size_t k = from; k < met_.size(); ++k) {
    const Met& met = met_[k];
    const std::size_t guest = (met.first >= bodies_ ? met.first : met.second) - bodies_;
    if (member_[guest] == PairForces::kNobody) continue;
    met.forces->first = place(met.first);
    met.forces->second = place(met.second);
    // A body whose step could not begin is not a member.
    if (met.forces->first < island_.size() &&
        (met.forces->second < island_.size() || met.second == PairForces::kNobody))
      couplings_.push_back(met.forces);
  }
}

// Solves a step, or a part of one, with the contacts from index `from` on.
MixedReport MixedGuests::solve(const HostIsland& island, std::size_t from) {
  const std::span<const IslandMember> members = island.members;
  add_members(members);
  pair_bodies(members, std::span(island.points).first(island.count), island.joints);
  couple(from, members);
  const MixedReport report = solver_.step(island_, couplings_);
  island.count = 0;
  for (std::size_t c = 0; c < pair_count_; ++c)
    pairs_[c].give_back(pairs_[c].first, pairs_[c].second, island.points, island.count);
  for (std::size_t m = 0; m < members.size(); ++m) {
    StepReport& of_body = island.reports[m];
    of_body = report.converged ? reduced_[members[m].number].report() : StepReport{};
    of_body.converged = report.converged;
    of_body.iterations = report.iterations;
    if (!report.converged) of_body.residual = 0.5 * length_ * solver_.size_of(m);
  }
  return report;
}

void MixedGuests::add_report(const MixedReport& report) {
  report_.iterations += report.iterations;
  report_.linear += report.linear;
  report_.residual = std::max(report_.residual, report.residual);
  report_.converged = report_.converged && report.converged;
  report_.cut += report.cut;
  report_.parts += report.parts;
}

// Takes the whole step of the present island.
bool MixedGuests::solve_island(const HostIsland& island) {
  other_report_ = report_;
  part_report_ = solve(island, 0);
  add_report(part_report_);
  in_islands_ += island_.size();
  for (const std::size_t guest : who_) {
    guests_[guest]->failed = !part_report_.converged;
    if (part_report_.converged) book(guest);
  }
  return part_report_.converged;
}

void MixedGuests::step_island(std::span<const std::size_t> roots, const HostIsland& island) {
  choose_guests(roots, island.members[0].number);
  (void)solve_island(island);
}

void MixedGuests::start_parts() {
  whole_counts_ = counts_;
  whole_counts_.met = met_.size();
  whole_counts_.links = links_.size();
  whole_colliders_ = colliders_;
  part_report_.residual = 0.0;
  part_report_.cut = 1;
  for (const std::size_t guest : who_) {
    guests_[guest]->failed = false;
    guests_[guest]->step->start_parts();
  }
  for (Link& link : joined_) link.before = link.joint.joint;
}

bool MixedGuests::step_part(const GuestPart& part, const HostIsland& island) {
  forget_contacts(whole_counts_);
  colliders_ = part.colliders;
  from_ = part.from;
  to_ = part.to;
  length_ = step_ * (part.to - part.from);
  for (const std::size_t guest : who_) guests_[guest]->step->start_part(part.from, part.to);
  part_contacts_.assign(bodies_, nullptr);
  for (const IslandMember& member : island.members) part_contacts_[member.number] = member.contact;
  meet(who_, part_contacts_);
  const MixedReport report = solve(island, whole_counts_.met);
  part_report_.iterations += report.iterations;
  part_report_.linear += report.linear;
  part_report_.residual = std::max(part_report_.residual, report.residual);
  if (!report.converged) return false;
  ++part_report_.parts;
  for (const std::size_t guest : who_) guests_[guest]->step->end_part();
  return true;
}

void MixedGuests::end_parts(bool made) {
  forget_contacts(whole_counts_);
  colliders_ = whole_colliders_;
  length_ = step_;
  from_ = 0.0;
  to_ = 1.0;
  part_report_.converged = made;
  report_ = other_report_;
  add_report(part_report_);
  for (const std::size_t guest : who_) {
    guests_[guest]->step->end_parts(made);
    guests_[guest]->failed = !made;
    if (made) book(guest);
  }
  if (made) return;
  for (Link& link : joined_)
    if (member_[link.joint.guest] != PairForces::kNobody) link.joint.joint = link.before;
}

void MixedGuests::step_others(std::span<const std::size_t> roots) {
  std::vector<PairPoint> none;
  std::size_t count = 0;
  for (std::size_t root = 0; root < guests_.size(); ++root) {
    if (roots[root] != bodies_ + root || guests_[root]->failed) continue;
    if (asleep(root)) {
      guests_[root]->step->rest_a_step();
      continue;
    }
    choose_guests(roots, bodies_ + root);
    add_members({});
    couple(0, {});
    if (!couplings_.empty()) {
      if (!solve_island({{}, none, count, {}, {}}))
        (void)parts_.step({{}, colliders_, {}, {}, this}, step_, {}, PartReason::kFailure);
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
  of.sums.hand += account.hand_work;
  of.sums.joint += account.joint_work;
  of.load_work += account.load_work;
  of.deepest = std::max(of.deepest, account.penetration);
  of.slip = std::max(of.slip, account.slip);
  const bool touches = account.active > 0;
  if (touches && !of.touched) ++of.contacts;
  of.touched = touches;
  if (of.tets != nullptr) of.tets->add_sums();
  for (Hand& held : hands_) {
    if (!held.used || held.hand.guest != guest) continue;
    held.hand.force = held.pull.mean_force();
    held.hand.start = held.hand.end;
  }
  age_forces(guest);
}

// Everything else is of one step.
void MixedGuests::carry(StateStream& stream, std::size_t bodies) {
  for (const auto& guest : guests_)
    if (!guest->removed) carry_guest(stream, bodies, *guest);
  carry_links(stream);
  carry_loads(stream);
}

void MixedGuests::carry_guest(StateStream& stream, std::size_t bodies, Guest& guest) {
  stream(guest.sums, guest.contacts, guest.deepest, guest.slip, guest.load_work, guest.failed,
         guest.touched, guest.rest);
  guest.step->carry(stream);
  guest.started = false;
  for (const ContactedPoint& point : guest.step->contacted())
    stream.require(point.on_body
                       ? point.obstacle < bodies || (point.obstacle >= kFirstGuest &&
                                                     point.obstacle - kFirstGuest < size())
                       : point.obstacle >= kFirstCollider);
}

}  // namespace tremolo
