#include "runtime/bodies/tets/motion/tet_island.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace tremolo {
namespace {

// Number of times that a correction is shortened before it is given up.
constexpr int kMostHalvings = 12;
// Tolerance of a step of one correction: its error is an error of the momenta.
constexpr double kLinearStepTolerance = 1e-10;
// A step ends at a kink of the bodies' contacts after this many corrections of which none halved
// the residual, if it is below this fraction of the contact forces.
constexpr int kSlowCorrections = 3;
constexpr double kKinkShare = 1e-3;
// The same fraction after the last correction: a divided step is not solved better.
constexpr double kLastKinkShare = 1e-2;
// A checked body may gain this fraction of its largest energy, since it last lost as much.
constexpr double kMostGain = 0.02;
constexpr double kGuardRounding = 1e-12;
constexpr int kMostParts = 8;
// With kTakeContact a step in contact is solved to this tolerance (TetBodyOptions).
constexpr double kTryTolerance = 1e-3;
// The first corrections of a body alone, and all of several bodies, are solved to this linear
// tolerance. Forces between bodies jump, so that more corrections gain little: a step of several
// has at most `kTries`. It ends unsolved after `kSlowTries`, if the last did not halve the residual
// and that is below `kUnsolvedTolerance`.
constexpr double kTryLinearTolerance = 0.1;
constexpr int kQuickTries = 6;
constexpr int kTries = 12;
constexpr int kSlowTries = 2;
constexpr double kUnsolvedTolerance = 0.2;
// Otherwise it is taken again with at most this many corrections, none after the residual is below
// this tolerance. A step that is not solved may add this fraction of the energy.
constexpr int kContactCorrections = 2;
constexpr int kContactParts = 4;
constexpr double kContactTolerance = 0.01;
constexpr double kMostContactGain = 0.05;

double sum_of(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum;
}

SearchSizes sum_of(const std::vector<SearchSizes>& values) {
  SearchSizes sum;
  for (const SearchSizes& value : values) {
    sum.square += value.square;
    sum.product += value.product;
  }
  return sum;
}

}  // namespace

void TetIsland::reserve(std::size_t bodies, std::size_t touches) {
  couplings_.reserve(touches + bodies);  // one grab per body
  ends_.reserve(2 * touches + bodies);
  first_coupling_.reserve(bodies + 1);
  first_end_.reserve(bodies + 1);
  next_end_.reserve(bodies);
  curvatures_.reserve(bodies);
  squares_.reserve(bodies);
  stops_.reserve(bodies);
  sizes_.reserve(bodies);
}

template <class Body>
void TetIsland::for_each(std::size_t count, const Body& body) {
  if (pool_ != nullptr)
    pool_->run(count, [&body](std::size_t i, unsigned) { body(i); });
  else
    for (std::size_t i = 0; i < count; ++i) body(i);
}

// r| of all bodies at their trial displacements.
double TetIsland::find_residual() {
  for_each(members_.size(), [this](std::size_t i) {
    const auto& [body, contact] = members_[i];
    body->find_forces();
    if (contact != nullptr) contact->fit(body->s_);
  });
  for_each(members_.size(), [this](std::size_t i) {
    const auto& [body, contact] = members_[i];
    if (contact == nullptr) return;
    contact->find(body->s_, body->velocity_);
    contact->add_forces(body->force_);
  });
  // Pairs follow one after the other, always in the same order.
  for (const auto& [body, contact] : members_)
    if (contact != nullptr)
      for (std::uint32_t p = 0; p < contact->partners().size(); ++p)
        contact->add_partner_forces(p, members_[contact->partners()[p].member].body->force_);
  for_each(members_.size(),
           [this](std::size_t i) { squares_[i] = members_[i].body->close_residual(); });
  return std::sqrt(sum_of(squares_));
}

// least: of the tolerances.
void TetIsland::set_stops(double least) {
  for_each(members_.size(), [this, least](std::size_t i) {
    const TetBody& body = *members_[i].body;
    stops_[i] = body.stop_size(std::max(least, body.options_.tolerance));
  });
}

// The size of all forces to which tolerances are relative, N.
double TetIsland::size_of_forces() const {
  double squared = 0.0;
  for (const TetMember& member : members_) squared += std::pow(member.body->stop_size(1.0), 2);
  return std::sqrt(squared);
}

bool TetIsland::small_enough() const {
  for (std::size_t i = 0; i < members_.size(); ++i)
    if (!(squares_[i] <= stops_[i] * stops_[i])) return false;
  return true;
}

std::span<const TetTouch> TetIsland::touches_of(std::size_t member) const {
  const TetContact* contact = members_[member].contact;
  return contact != nullptr ? contact->touches() : std::span<const TetTouch>();
}

// Indices of each body's first coupling and end, and the ends of each coupling: a body's own
// contacts and its grab are first, then the contacts of others with it, in their order.
void TetIsland::number_ends() {
  const std::size_t count = members_.size();
  first_coupling_.assign(count + 1, 0);
  first_end_.assign(count + 1, 0);
  const auto partner_of = [this](std::size_t i, const TetTouch& touch) {
    return members_[i].contact->partners()[touch.partner].member;
  };
  for (std::size_t i = 0; i < count; ++i) {
    const std::span<const TetTouch> touches = touches_of(i);
    const std::size_t own = touches.size() + (members_[i].body->hand_ ? 1 : 0);
    first_coupling_[i + 1] = static_cast<std::uint32_t>(own);
    first_end_[i + 1] += static_cast<std::uint32_t>(own);
    for (const TetTouch& touch : touches)
      if (touch.partner != kNoPartner) ++first_end_[partner_of(i, touch) + 1];
  }
  for (std::size_t i = 0; i < count; ++i) {
    first_coupling_[i + 1] += first_coupling_[i];
    first_end_[i + 1] += first_end_[i];
  }
  couplings_.resize(first_coupling_[count]);
  ends_.resize(first_end_[count]);
  next_end_.assign(first_end_.begin(), first_end_.end() - 1);
  for (std::size_t i = 0; i < count; ++i)
    for (std::uint32_t c = first_coupling_[i]; c < first_coupling_[i + 1]; ++c) {
      couplings_[c].own = next_end_[i]++;
      couplings_[c].other = kNoEnd;
    }
  for (std::size_t i = 0; i < count; ++i) {
    Coupling* coupling = couplings_.data() + first_coupling_[i];
    for (const TetTouch& touch : touches_of(i)) {
      if (touch.partner != kNoPartner) coupling->other = next_end_[partner_of(i, touch)]++;
      ++coupling;
    }
  }
}

// The spring and the damper of a body's grab, which act on this body alone.
void TetIsland::find_hand_end(std::uint32_t member) {
  TetBody& body = *members_[member].body;
  const TetHand& hand = *body.hand_;
  const std::uint32_t c = first_coupling_[member + 1] - 1;
  couplings_[c].block =
      (hand.stiffness + body.stage_.rate * hand.damping) * Eigen::Matrix3d::Identity();
  std::array<double, kMostNodes> shares = hand.shares;
  body.system_.fold_point(hand.nodes, shares);
  ends_[couplings_[c].own].coupling = c;
  ends_[couplings_[c].own].point = body.solve_.folded(hand.nodes, shares);
}

// The ends of a body's own contacts, on both sides, and of its grab.
void TetIsland::find_ends(std::uint32_t member) {
  const auto& [body, contact] = members_[member];
  if (body->hand_) find_hand_end(member);
  std::uint32_t c = first_coupling_[member];
  for (const TetTouch& touch : touches_of(member)) {
    Coupling& coupling = couplings_[c];
    coupling.block = touch.place + body->stage_.rate * touch.speed;
    const TetPoint& point = contact->hull().points[touch.point];
    std::array<double, kMostNodes> shares = point.shares;
    const std::span<const std::uint32_t> nodes(point.nodes.data(), point.count);
    body->system_.fold_point(nodes, std::span(shares.data(), point.count));
    ends_[coupling.own].coupling = c;
    ends_[coupling.own].point = body->solve_.folded(nodes, shares);
    const std::uint32_t number = c++;
    if (coupling.other == kNoEnd) continue;
    const TetBody& other = *members_[contact->partners()[touch.partner].member].body;
    shares = touch.values;
    other.system_.fold_point(touch.nodes, shares);
    ends_[coupling.other].coupling = number;
    ends_[coupling.other].point = other.solve_.folded(touch.nodes, shares);
  }
}

void TetIsland::find_couplings() {
  number_ends();
  for_each(members_.size(), [this](std::size_t i) { find_ends(static_cast<std::uint32_t>(i)); });
  for_each(members_.size(), [this](std::size_t i) {
    for (std::uint32_t e = first_end_[i]; e < first_end_[i + 1]; ++e)
      members_[i].body->solve_.add_diagonal(ends_[e].point, couplings_[ends_[e].coupling].block);
  });
}

// Adds the terms of the contacts and the grab of a body to the image of the direction. Each body of
// a contact computes it for itself.
void TetIsland::add_images(std::uint32_t member) {
  ActiveSolve& solve = members_[member].body->solve_;
  for (std::uint32_t e = first_end_[member]; e < first_end_[member + 1]; ++e) {
    const Coupling& c = couplings_[ends_[e].coupling];
    Eigen::Vector3d way = ends_[c.own].part;
    if (c.other != kNoEnd) way -= ends_[c.other].part;
    const Eigen::Vector3d answer = c.block * way;
    solve.add_image(ends_[e].point, e == c.own ? answer : Eigen::Vector3d(-answer));
    if (e == c.own) curvatures_[member] += way.dot(answer);
  }
}

// Conjugate gradients over all bodies; false if the matrix is not positive.
bool TetIsland::search(double tolerance) {
  std::size_t most = 0;
  for (const TetMember& member : members_)
    most += static_cast<std::size_t>(member.body->residual_.size());
  for_each(members_.size(), [&](std::size_t i) {
    TetBody& body = *members_[i].body;
    sizes_[i] = body.solve_.start(body.matrix_, body.residual_, tolerance >= kSingleTolerance);
  });
  SearchSizes now = sum_of(sizes_);
  const double stop = tolerance * tolerance * now.square;
  double share = 0.0;
  for (std::size_t n = 0; now.square > stop && n < most; ++n) {
    for_each(members_.size(), [&](std::size_t i) {
      ActiveSolve& solve = members_[i].body->solve_;
      if (n > 0) solve.turn(share);
      curvatures_[i] = solve.multiply(members_[i].body->matrix_);
      for (std::uint32_t e = first_end_[i]; e < first_end_[i + 1]; ++e)
        ends_[e].part = solve.direction_at(ends_[e].point);
    });
    if (!couplings_.empty())
      for_each(members_.size(),
               [this](std::size_t i) { add_images(static_cast<std::uint32_t>(i)); });
    const double along = sum_of(curvatures_);
    if (!(along > 0.0)) return false;
    const double before = now.product;
    for_each(members_.size(),
             [&](std::size_t i) { sizes_[i] = members_[i].body->solve_.advance(before / along); });
    now = sum_of(sizes_);
    share = now.product / before;
    ++report_.linear;
  }
  return true;
}

// Newton's correction of each body. exact: uses each body's own tangent while that is positive.
// tolerance: of the linear system. The matrices of the previous correction cannot be used: R K R^T
// of another R has stiffness against rotations, which nothing in the residual bounds.
void TetIsland::find_correction(bool exact, double tolerance) {
  for_each(members_.size(),
           [this](std::size_t i) { members_[i].body->residual_ = -members_[i].body->residual_; });
  const bool single = tolerance >= kSingleTolerance;
  const bool pressed = touching();
  // The factor is that of the body's own matrix, without coupling to others or to a grab.
  TetBody* alone =
      members_.size() == 1 && !pressed && !members_[0].body->hand_ ? members_[0].body : nullptr;
  bool by_factor = false;
  for (const bool own : {true, false}) {
    if (own && !exact) continue;
    by_factor = alone != nullptr && alone->factor_pays();
    for_each(members_.size(), [&](std::size_t i) {
      TetBody& body = *members_[i].body;
      body.assemble(own ? body.options_.tangent : TangentKind::kFrozen, single && !by_factor);
      if (!by_factor) body.take_preconditioner(single);
    });
    if (by_factor && alone->solve_by_factor()) break;
    if (by_factor) continue;
    find_couplings();
    const int before = report_.linear;
    const bool positive = search(tolerance);
    if (alone != nullptr) alone->note_search(report_.linear - before);
    if (positive) break;
  }
  for_each(members_.size(), [&](std::size_t i) {
    TetBody& body = *members_[i].body;
    if (!by_factor) body.solve_.finish(body.correction_);
    body.system_.follow_ends(body.correction_);
    // Contacts constrain a body in contact, not its inertia.
    if (!pressed && !body.hand_) body.free_rigid_correction();
  });
}

bool TetIsland::touching() const {
  return std::any_of(members_.begin(), members_.end(), [](const TetMember& member) {
    return member.contact != nullptr && !member.contact->touches().empty();
  });
}

// Follows the correction until the residual no longer points back. size: |r| at the end.
bool TetIsland::take_correction(double& size) {
  double slope = 0.0;
  for (const TetMember& member : members_) {
    TetBody& body = *member.body;
    body.start_ = body.way_;
    body.direction_ = body.correction_;
    slope += body.residual_.dot(body.correction_);  // residual_ is -r here
  }
  const double before = size;
  double share = 1.0;
  for (int halving = 0; halving < kMostHalvings; ++halving) {
    for (const TetMember& member : members_)
      member.body->way_ = member.body->start_ + share * member.body->direction_;
    size = find_residual();
    double now = 0.0;
    for (const TetMember& member : members_)
      now -= member.body->residual_.dot(member.body->direction_);
    if (std::isfinite(size) && (size <= before || now >= -0.5 * std::abs(slope))) return true;
    share *= std::isfinite(now) ? std::clamp(slope / (slope - now), 0.1, 0.7) : 0.1;
  }
  return false;
}

// Takes the whole correction: a shorter one of all bodies would stop those in the air where one
// meets another.
void TetIsland::take_whole(double& size) {
  for_each(members_.size(),
           [this](std::size_t i) { members_[i].body->way_ += members_[i].body->correction_; });
  size = find_residual();
}

// True if |r| is within the jumps of the forces between bodies. A contact force on the other body
// is along F^-T grad phi, which jumps where its position crosses from one element or cell of the
// distances to the next. A body may come to rest where the residual has no zero, only a change of
// sign.
bool TetIsland::at_kink(double size, double share) const {
  double squared = 0.0;
  for (const TetMember& member : members_)
    if (member.contact != nullptr)
      for (const TetTouch& touch : member.contact->touches())
        if (touch.partner != kNoPartner) squared += touch.force.squaredNorm();
  return size <= share * std::sqrt(squared);
}

bool TetIsland::solve_stage() {
  bounded_ = std::all_of(members_.begin(), members_.end(), [](const TetMember& member) {
    return member.body->options_.unsolved == UnsolvedStep::kTake;
  });
  for_each(members_.size(), [this](std::size_t i) { members_[i].body->guess(bounded_); });
  double size = find_residual();
  set_stops(0.0);
  int most = 0;
  for (const TetMember& member : members_)
    most = std::max(most, member.body->options_.max_iterations);
  const bool together = members_.size() > 1;
  int slow = 0, tries = 0;
  bool kink = false, pressed = false;
  for (int iteration = 0; iteration < most && !kink; ++iteration) {
    if (!std::isfinite(size)) return false;
    if (small_enough()) break;
    if (watch_contact_ && touching()) {
      if (!pressed) set_stops(kTryTolerance);
      pressed = met_contact_ = true;
      if (small_enough()) break;
      if (together && (tries == kTries || (tries >= kSlowTries && slow > 0))) break;
      ++tries;
    }
    ++report_.iterations;
    const double before = size;
    double tolerance = 1.0;
    for (const TetMember& member : members_)
      tolerance = std::min(tolerance, member.body->options_.linear_tolerance);
    const bool quick = pressed && (together || tries <= kQuickTries);
    if (quick) tolerance = std::max(tolerance, kTryLinearTolerance);
    find_correction(!quick, tolerance);
    if (bounded_) {
      take_whole(size);
      continue;
    }
    const bool taken = take_correction(size);
    slow = size > 0.5 * before ? slow + 1 : 0;
    kink = (!taken && at_kink(size, kLastKinkShare)) ||
           (slow >= kSlowCorrections && at_kink(size, kKinkShare));
    if (!taken && quick && together) break;
    if (!taken && !kink) return false;
  }
  if (!std::isfinite(size)) return false;
  if (pressed && together && !small_enough()) {
    if (!(size <= kUnsolvedTolerance * size_of_forces())) return false;
    start_energy_ = island_energy() - contact_energy() + start_contact_energy_;
    took_unsolved_ = kink = true;
  }
  if (!small_enough() && !bounded_ && !kink && !at_kink(size, kLastKinkShare)) return false;
  report_.unsolved = report_.unsolved || !small_enough();
  // Moving a body changes its contact forces; only bodies without contact can be balanced.
  if (members_.size() == 1 &&
      (members_[0].contact == nullptr || members_[0].contact->touches().empty()))
    members_[0].body->balance_momenta();
  return true;
}

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
  for_each(members_.size(), [this](std::size_t i) { members_[i].body->end(); });
  return true;
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
  bool finite = true;
  for (const TetMember& member : members_) {
    TetBody& body = *member.body;
    body.way_ = body.correction_;
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
  for (const bool halves : {true, false}) {
    body.rewind_part();
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
  for (const TetMember& member : members_) member.body->end();
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
  for (const TetMember& member : members_) member.body->rewind();
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
      made = make_watched_step(members_.size() > 1 ? method : common_method(), h);
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
  for_each(members.size(), [this](std::size_t i) { members_[i].body->keep_state(); });
  report_.converged = make_any_step();
  std::fill(reports.begin(), reports.end(), report_);
  for_each(members.size(), [&](std::size_t i) {
    TetBody& body = *members[i].body;
    if (!report_.converged) return body.restore_state();
    body.skip_step();
    body.choose_degrees(reports[i]);
  });
}

}  // namespace tremolo
