#include "runtime/bodies/tets/motion/tet_island.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace tremolo {
namespace {

// Number of times that a correction is shortened before it is given up.
constexpr int kMostHalvings = 12;
// A step ends at a kink of the bodies' contacts after this many corrections of which none halved
// the residual, if it is below this fraction of the contact forces.
constexpr int kSlowCorrections = 3;
constexpr double kKinkShare = 1e-3;
// The same fraction after the last correction: a divided step is not solved better.
constexpr double kLastKinkShare = 1e-2;
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
    contact->find(body->s_, body->now_.x);
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
    coupling.block = touch.fall;
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

}  // namespace tremolo
