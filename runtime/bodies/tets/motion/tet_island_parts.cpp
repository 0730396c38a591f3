// TetIsland: the step by a method, whole or in parts.
#include <algorithm>
#include <cmath>

#include "runtime/bodies/tets/motion/tet_island.h"

namespace tremolo {
namespace {

// Tolerance of a step of one correction: its error is an error of the momenta.
constexpr double kLinearStepTolerance = 1e-10;
// A checked body may gain this fraction of its largest energy, since it last lost as much.
constexpr double kMostGain = 0.02;
constexpr double kGuardRounding = 1e-12;
constexpr int kMostParts = 8;
// A step in contact that is taken again has at most this many corrections, none after the residual
// is below this tolerance. A step that is not solved may add this fraction of the energy.
constexpr int kContactCorrections = 2;
constexpr int kContactParts = 4;
constexpr double kContactTolerance = 0.01;
constexpr double kMostContactGain = 0.05;

}  // namespace

TetMethod TetIsland::common_method() const {
  const TetMethod method = members_.front().body->options_.method;
  bool alike = true, before = true;
  for (const TetMember& member : members_) {
    alike = alike && member.body->options_.method == method;
    before = before && member.body->has_before_;
  }
  if (members_.size() > 1 && (!alike || (method == TetMethod::kBdf2 && !before)))
    return TetMethod::kImplicitEuler;
  return method;
}

bool TetIsland::make_step(TetMethod method, double h) {
  for_each(members_.size(), [&](std::size_t i) { members_[i].body->begin(method, h); });
  if (!solve_stage()) return false;
  end_step();
  return true;
}

// Ends the step at the last evaluation of the forces.
void TetIsland::end_step() {
  for_each(members_.size(), [this](std::size_t i) {
    const auto& [body, contact] = members_[i];
    if (contact != nullptr)
      contact->end_step(body->stage_.method == TetMethod::kMidpoint ? 2.0 : 1.0);
    body->end();
  });
}

// One correction with R K R^T, which is positive, from the start of the step (linearised
// implicit-euler). It does not need a solution nearby.
bool TetIsland::make_linear_step(double h) {
  for (const TetMember& member : members_) {
    begin_stage(TetMethod::kImplicitEuler, h, member.body->now_, nullptr, member.body->stage_);
    member.body->way_.setZero();
  }
  find_residual();
  find_correction(false, kLinearStepTolerance);
  for (const TetMember& member : members_) member.body->way_ = member.body->correction_;
  find_residual();  // for friction's memory
  bool finite = true;
  for (const TetMember& member : members_) {
    TetBody& body = *member.body;
    if (member.contact != nullptr) member.contact->end_step(1.0);
    end_stage(body.stage_, body.way_, body.now_, body.before_);
    finite = finite && body.now_.x.allFinite() && body.now_.v.allFinite();
  }
  return finite;
}

// The body whose energy is checked: it has no partners, its method may add energy, and it has no
// grab, which would do work.
TetBody* TetIsland::watched(TetMethod method) const {
  if (members_.size() > 1) return nullptr;
  TetBody* body = members_.front().body;
  const bool may = method == TetMethod::kMidpoint || method == TetMethod::kNewmark;
  return may && body->options_.guard && !body->hand_ ? body : nullptr;
}

// True if the present energy of the checked body is allowed; it is then stored.
bool TetIsland::energy_is_good(TetBody& body) {
  TetGuard& guard = body.guard_;
  const double now = body.guarded_energy(members_.front().contact);
  const double gain = now - guard.energy;
  // At rest the largest energy is that of nothing, and gravity's is large and rounded.
  const double size =
      body.kinetic_energy() + body.elastic_energy() + std::abs(body.gravity_energy());
  if (gain > kGuardRounding * size && guard.gained + gain > kMostGain * guard.largest) return false;
  guard.gained = std::max(0.0, guard.gained + gain);
  guard.energy = now;
  guard.largest = std::max(guard.largest, body.kinetic_energy() + body.elastic_energy());
  return true;
}

// Repeats a step by a method that damps motion too fast for the step: half by midpoint and half by
// bdf2, or else by implicit-euler. The momenta that a free body without contact loses are restored.
// Remaining excess energy is taken from the velocities relative to the nearest rigid motion.
bool TetIsland::make_damped_step(TetBody& body, double h) {
  ++report_.guarded;
  TetContact* contact = members_.front().contact;
  for (const bool halves : {true, false}) {
    body.rewind_part();
    if (contact != nullptr) contact->rewind_part();
    bool made =
        make_step(halves ? TetMethod::kMidpoint : TetMethod::kImplicitEuler, halves ? 0.5 * h : h);
    bool touched = touching();
    if (halves && made) {
      made = make_step(TetMethod::kBdf2, 0.5 * h);
      touched = touched || touching();
    }
    body.has_before_ = body.has_acceleration_ = false;
    if (!made) continue;
    if (!touched) body.restore_momenta(body.part_, h);
    if (energy_is_good(body)) return true;
    if (halves) continue;
    TetGuard& guard = body.guard_;
    const double now = body.guarded_energy(members_.front().contact);
    const double most = guard.energy + kMostGain * guard.largest - guard.gained;
    guard.energy = now - body.take_internal_energy(now - most);
    guard.gained = kMostGain * guard.largest;
    return guard.energy <= most + kGuardRounding * guard.largest;
  }
  return false;
}

// A step, or a part of one, whose energy is checked.
bool TetIsland::make_watched_step(TetMethod method, double h) {
  TetBody* body = watched(method);
  if (body == nullptr) {
    for (const TetMember& member : members_) member.body->guard_.known = false;
    return make_step(method, h);
  }
  if (!body->guard_.known) {
    body->guard_.energy = body->guarded_energy(members_.front().contact);
    body->guard_.largest =
        std::max(body->guard_.largest, body->kinetic_energy() + body->elastic_energy());
    body->guard_.known = true;
  }
  body->keep_part();
  if (members_.front().contact != nullptr) members_.front().contact->keep_part();
  if (!make_step(method, h)) return false;
  return energy_is_good(*body) || make_damped_step(*body, h);
}

// True if steps in contact are a few corrections.
bool TetIsland::contact_is_taken() const {
  return std::all_of(members_.begin(), members_.end(), [](const TetMember& member) {
    const TetBodyOptions& options = member.body->options_;
    return options.unsolved == UnsolvedStep::kTakeContact &&
           (options.method == TetMethod::kImplicitEuler || options.method == TetMethod::kBdf2);
  });
}

double TetIsland::contact_energy() const {
  double sum = 0.0;
  for (const TetMember& member : members_)
    if (member.contact != nullptr) sum += member.contact->look().energy;
  return sum;
}

// Energy of the bodies at their trial positions, at which contacts were found, J.
double TetIsland::island_energy() const {
  double sum = contact_energy();
  for (const TetMember& member : members_)
    sum += member.body->kinetic_energy() + member.body->elastic_energy() +
           member.body->gravity_energy();
  return sum;
}

// False if a step adds too much to the energy, which is not checked where a grab acts.
bool TetIsland::adds_little(double before) const {
  const double after = island_energy();
  double moving = after;
  for (const TetMember& member : members_) {
    if (member.body->hand_) return true;
    moving -= member.body->gravity_energy();
  }
  return after - before <= kMostContactGain * moving;
}

// One step of implicit-euler in contact: a few corrections from the present positions. last: it is
// accepted whatever energy it adds. The energy is not checked where a grab acts.
bool TetIsland::make_contact_step(double h, bool last) {
  for (const TetMember& member : members_) {
    member.body->begin(TetMethod::kImplicitEuler, h);
    member.body->guess(true);
  }
  double size = find_residual();
  set_stops(kContactTolerance);
  const double before = island_energy();
  for (int n = 0; n < kContactCorrections && std::isfinite(size) && !small_enough(); ++n) {
    ++report_.iterations;
    find_correction(false, kTryLinearTolerance);
    take_whole(size);
  }
  if (!std::isfinite(size)) return false;
  report_.unsolved = report_.unsolved || !small_enough();
  if (members_.size() == 1 && !touching()) members_.front().body->balance_momenta();
  end_step();
  return adds_little(before) || last;
}

// After a step of several bodies by implicit-euler. They pass momentum on to each other, of which
// each step of bdf2 keeps a part for the next ones.
void TetIsland::begin_bdf2_again() {
  if (members_.size() == 1) return;
  for (const TetMember& member : members_) {
    TetBody& body = *member.body;
    body.begin_bdf2_again(body.saved_, body.had_before_ ? &body.saved_before_ : nullptr);
  }
}

// If a part fails, the bodies' states are undefined.
bool TetIsland::make_parts(int parts, PartKind kind) {
  const bool linear = kind == PartKind::kLinear;
  report_.parts = parts;
  report_.linearised = linear;
  for (const TetMember& member : members_) {
    member.body->rewind();
    if (member.contact != nullptr) member.contact->restore_memory();
  }
  const double step = members_.front().body->options_.step, h = step / parts;
  TetMethod method = common_method();
  if (members_.size() > 1 && method == TetMethod::kBdf2) method = TetMethod::kImplicitEuler;
  bool made = true, touched = false;
  for (int part = 0; part < parts && made; ++part) {
    if (linear)
      made = make_linear_step(h);
    else if (kind == PartKind::kContact)
      made = make_contact_step(h, parts == kContactParts);
    else
      made = make_watched_step(method, h);
    touched = touched || touching();
  }
  // The previous step, which bdf2 needs, is this whole step; a linearised step cannot serve as one.
  for (const TetMember& member : members_) {
    TetBody& body = *member.body;
    body.has_acceleration_ = false;
    body.before_.x = body.saved_.x;
    body.before_.v = body.saved_.v;
    body.has_before_ = made && !linear;
  }
  if (made && !linear) begin_bdf2_again();
  if (made && linear && members_.size() == 1 && !touched)
    members_.front().body->restore_momenta(members_.front().body->saved_, step);
  return made;
}

// The step, whole or in parts.
bool TetIsland::make_any_step() {
  watch_contact_ = contact_is_taken();
  met_contact_ = took_unsolved_ = false;
  start_contact_energy_ = contact_energy();
  const TetMethod method = common_method();
  if (make_watched_step(method, members_.front().body->options_.step) &&
      (!took_unsolved_ || adds_little(start_energy_))) {
    if (method == TetMethod::kImplicitEuler) begin_bdf2_again();
    return true;
  }
  met_contact_ = met_contact_ || (watch_contact_ && touching());
  watch_contact_ = false;
  if (met_contact_ && (make_parts(1, PartKind::kContact) || make_parts(2, PartKind::kContact) ||
                       make_parts(kContactParts, PartKind::kContact)))
    return true;
  return make_parts(2, PartKind::kMethod) || make_parts(kMostParts, PartKind::kMethod) ||
         make_parts(kMostParts, PartKind::kLinear);
}

void TetIsland::step(std::span<const TetMember> members, std::span<TetStepReport> reports) {
  members_ = members;
  report_ = {};
  squares_.assign(members.size(), 0.0);
  stops_.assign(members.size(), 0.0);
  curvatures_.assign(members.size(), 0.0);
  sizes_.assign(members.size(), {});
  for_each(members.size(), [this](std::size_t i) {
    members_[i].body->keep_state();
    if (members_[i].contact != nullptr) members_[i].contact->keep_memory();
  });
  report_.converged = make_any_step();
  std::fill(reports.begin(), reports.end(), report_);
  for_each(members.size(), [&](std::size_t i) {
    TetBody& body = *members[i].body;
    if (!report_.converged && members[i].contact != nullptr) members[i].contact->restore_memory();
    if (!report_.converged) return body.restore_state();
    body.skip_step();
    body.choose_degrees(reports[i]);
  });
}

}  // namespace tremolo
