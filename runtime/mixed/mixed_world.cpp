#include "runtime/mixed/mixed_world.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/text.h"
#include "common/union_find.h"

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

Error named(const std::string& name, const std::string& what) {
  return usage_error("body '" + name + "': " + what);
}

std::string other_step(double step, double expected) {
  return "its step is " + number_text(step) + " s, but that of the world is " +
         number_text(expected) + " s";
}

}  // namespace

Result<std::size_t> MixedWorld::add(std::string name, ContactBody body) {
  if (body.step_size() != step_) return named(name, other_step(body.step_size(), step_));
  if (body.contact() == nullptr) return named(name, "it has no contact; call set_contact() first");
  Member& member = bodies_.emplace_back();
  member.name = std::move(name);
  member.reduced = std::make_unique<ContactBody>(std::move(body));
  member.reduced_step = std::make_unique<ReducedStep>(*member.reduced);
  return bodies_.size() - 1;
}

Result<std::size_t> MixedWorld::add(std::string name, TetBody body, const ContactOptions& contact) {
  if (body.options().step != step_) return named(name, other_step(body.options().step, step_));
  if (Status good = check(contact); !good) return named(name, good.error().message);
  if (body.hand()) return named(name, "a body of tetrahedra with a grab cannot be in this world");
  const TetModel* model = &body.model();
  auto known = std::find_if(points_.begin(), points_.end(),
                            [model](const auto& entry) { return entry.first == model; });
  if (known == points_.end()) known = points_.insert(known, {model, make_tet_points(*model)});
  Member& member = bodies_.emplace_back();
  member.name = std::move(name);
  member.tets = std::make_unique<TetBody>(std::move(body));
  member.tet_step = std::make_unique<TetStep>(*member.tets, known->second, contact);
  return bodies_.size() - 1;
}

ContactAccount MixedWorld::account(std::size_t i) const {
  const Member& member = bodies_[i];
  return member.tet_step ? member.tet_step->account() : member.reduced->contact_account();
}

BentContact& MixedWorld::next_bent() {
  if (bent_count_ == bent_.size()) bent_.emplace_back();
  return bent_[bent_count_];
}

ColliderContact& MixedWorld::next_collider() {
  if (collider_count_ == on_colliders_.size()) on_colliders_.emplace_back();
  return on_colliders_[collider_count_];
}

// The rate of two bodies, which the contact of either's points with the other has; a new one for a
// collider.
SharedRate* MixedWorld::rate_of(std::size_t a, std::size_t b) {
  for (const auto& [body, contact] : couplings_)
    if (body == b && contact->second == a) return contact->shared;
  if (rate_count_ == rates_.size()) rates_.emplace_back();
  return &rates_[rate_count_++];
}

// Finds all points that may be in contact in the step, and joins their bodies.
void MixedWorld::find_contacts() {
  bent_count_ = collider_count_ = rate_count_ = 0;
  couplings_.clear();
  touched_.assign(bodies_.size(), 0);
  parent_.resize(bodies_.size());
  std::iota(parent_.begin(), parent_.end(), std::size_t{0});
  for (std::size_t a = 0; a < bodies_.size(); ++a) {
    if (!bodies_[a].started) continue;
    StepBody& points = *bodies_[a].step();
    for (std::size_t c = 0; bodies_[a].tets && c < colliders_.size(); ++c) {
      ColliderContact& contact = next_collider();
      if (!contact.gather(points, colliders_[c], kFirstCollider + c, step_)) continue;
      ++collider_count_;
      contact.first = a;
      contact.second = PairForces::kNobody;
      contact.shared = rate_of(a, PairForces::kNobody);
      couplings_.emplace_back(a, &contact);
      touched_[a] = 1;
    }
    for (std::size_t b = 0; b < bodies_.size(); ++b) {
      if (a == b || !bodies_[b].started || !bodies_[b].reduced_step) continue;
      BentContact& contact = next_bent();
      if (!contact.gather(points, *bodies_[b].reduced_step, b)) continue;
      ++bent_count_;
      contact.first = a;
      contact.second = b;
      contact.shared = rate_of(a, b);
      couplings_.emplace_back(a, &contact);
      touched_[a] = touched_[b] = 1;
      join_sets(parent_, a, b);
    }
  }
}

// Steps the bodies whose root this is. False: they were not solved.
bool MixedWorld::step_island(std::size_t root) {
  island_.clear();
  island_couplings_.clear();
  member_.resize(bodies_.size());
  for (std::size_t i = root; i < bodies_.size(); ++i) {
    if (!bodies_[i].started || root_of(parent_, i) != root) continue;
    member_[i] = island_.size();
    island_.push_back(bodies_[i].step());
  }
  for (const auto& [body, coupling] : couplings_) {
    if (root_of(parent_, body) != root) continue;
    coupling->first = member_[coupling->first];
    if (coupling->second != PairForces::kNobody) coupling->second = member_[coupling->second];
    island_couplings_.push_back(coupling);
  }
  const MixedReport report = solver_.step(island_, island_couplings_);
  report_.iterations += report.iterations;
  report_.linear += report.linear;
  report_.residual = std::max(report_.residual, report.residual);
  report_.converged = report_.converged && report.converged;
  in_islands_ += island_.size();
  return report.converged;
}

Status MixedWorld::step() {
  report_ = {};
  in_islands_ = 0;
  std::string failed;
  const auto note = [&](const std::string& name) {
    failed += (failed.empty() ? "'" : ", '") + name + "'";
  };
  for (Member& member : bodies_) {
    member.started = true;
    if (member.tet_step)
      member.tet_step->start();
    else
      member.started = member.reduced_step->start(colliders_);
    if (!member.started) note(member.name);
  }
  find_contacts();
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    Member& member = bodies_[i];
    if (!member.started || root_of(parent_, i) != i) continue;
    if (touched_[i] != 0) {
      if (step_island(i)) continue;
      for (std::size_t k = i; k < bodies_.size(); ++k)
        if (bodies_[k].started && root_of(parent_, k) == i) note(bodies_[k].name);
      continue;
    }
    if (member.tet_step)
      member.tet_step->step_alone();
    else
      member.reduced_step->step_alone();
    const bool made = member.tet_step ? member.tet_step->report().converged
                                      : member.reduced_step->report().converged;
    if (!made) note(member.name);
  }
  ++steps_;
  if (failed.empty()) return Success{};
  return Error{ErrorKind::kSolver, "the step at " + number_text(time() - step_) +
                                       " s is not solved for the bodies " + failed +
                                       "; they are as before it. Take a shorter step"};
}

}  // namespace tremolo
