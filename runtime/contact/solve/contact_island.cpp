#include "runtime/contact/solve/contact_island.h"

#include <algorithm>
#include <cmath>

#include "runtime/contact/solve/line_search.h"

namespace tremolo {
namespace {

using Eigen::Index;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr int kMostIterations = 120;
// Of what is small: less of it counts as converged, as the last move of Newton's method makes it.
constexpr double kConverged = 0.1;
// In how many iterations members move by themselves first, and how often in each; one attempt at
// the step after the other.
struct Attempt {
  int relaxed, alone;
};
constexpr Attempt kAttempts[] = {{3, 3}, {8, 8}, {0, 0}, {30, 2}};

// The law of a point of `first` and the shape of `second`: stiffness in proportion to the reduced
// mass; friction and restitution are geometric means.
ContactLaw law_between(const ContactStep& first, const ContactStep& second) {
  ContactLaw law = first.law();
  if (second.can_move()) law.stiffness *= second.mass() / (first.mass() + second.mass());
  law.friction = std::sqrt(first.law().friction * second.law().friction);
  law.restitution = std::sqrt(first.law().restitution * second.law().restitution);
  return law;
}

}  // namespace

std::size_t add_pair_points(const ContactStep& first, const ContactStep& second, std::size_t a,
                            std::size_t b, std::vector<PairPoint>& points, std::size_t count) {
  const Collider* shape = second.shape();
  if (shape == nullptr) return count;
  const ContactPoints& on = first.points();
  const Pose from = first.poses().start, into = second.poses().start;
  const ContactLaw law = law_between(first, second);
  const double reach = law.margin + 2.0 * (first.ball().travel + second.ball().travel);
  const double bent = second.ball().deformed;
  const auto place = [&](const Vector3d& x) {
    return Vector3d(into.rotation.conjugate() * (x - into.position));
  };
  for (const PointGroup& group : on.groups) {
    const double far = group.radius + first.ball().deformed + bent + reach;
    if (signed_distance(*shape, place(from * group.centre)).distance > far) continue;
    for (std::size_t i = group.first; i < group.first + group.count; ++i) {
      const Vector3d y = place(from * on.place(i, first.q_start()));
      if (signed_distance(*shape, y).distance > reach + bent) continue;
      if (count == points.size()) points.emplace_back();
      PairPoint& pair = points[count];
      const double distance = bent_distance(second.shape_at_start(), y);
      if (distance > reach) continue;
      pair.place_at_start = y;
      pair.distance = distance;
      pair.energy = law.energy(distance);
      pair.a = a;
      pair.b = b;
      pair.point = i;
      pair.law = law;
      ++count;
    }
  }
  return count;
}

// Points come pair by pair of members.
void ContactIsland::couple() {
  coupled_ = 0;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const auto [low, high] = std::minmax(points_[i].a, points_[i].b);
    if (coupled_ == 0 || couplings_[coupled_ - 1].a != low || couplings_[coupled_ - 1].b != high) {
      if (coupled_ == couplings_.size()) couplings_.emplace_back();
      Coupling& coupling = couplings_[coupled_++];
      coupling.a = low;
      coupling.b = high;
      coupling.first = i;
      coupling.count = 0;
      coupling.touches = false;
      coupling.ab.resize(members_[low].contact->unknowns(), members_[high].contact->unknowns());
      coupling.ba.resize(coupling.ab.cols(), coupling.ab.rows());
    }
    ++couplings_[coupled_ - 1].count;
  }
}

// All are looked at, and move.
void ContactIsland::choose_all() {
  looked_.assign(members_.size(), 1);
  place_.assign(members_.size(), 0);
  arrange();
}

// The members of a group move; what may feel that is looked at.
void ContactIsland::choose(std::size_t root) {
  for (std::size_t i = 0; i < members_.size(); ++i) {
    place_[i] = group_[i] == root ? 0 : kStill;
    looked_[i] = moves(i) ? 1 : 0;
  }
  for (const Coupling& coupling : std::span(couplings_).first(coupled_)) {
    if (moves(coupling.a)) looked_[coupling.b] = 1;
    if (moves(coupling.b)) looked_[coupling.a] = 1;
  }
  arrange();
}

// One member moves, and it alone is looked at.
void ContactIsland::choose_one(std::size_t member) {
  std::fill(looked_.begin(), looked_.end(), char{0});
  std::fill(place_.begin(), place_.end(), kStill);
  looked_[member] = 1;
  place_[member] = 0;
  arrange();
}

std::size_t ContactIsland::root(std::size_t i) {
  while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
  return i;
}

bool ContactIsland::is_converged(std::size_t i) const {
  return sizes_[i] <= kConverged * enough_[i];
}

// Who is not converged makes groups with what it touches: group_ is the lowest member of a group,
// or kStill. False: all are converged.
bool ContactIsland::find_groups() {
  parent_.resize(members_.size());
  group_.assign(members_.size(), kStill);
  bool any = false;
  for (std::size_t i = 0; i < members_.size(); ++i) {
    parent_[i] = i;
    if (is_converged(i)) continue;
    group_[i] = i;
    any = true;
  }
  for (const Coupling& coupling : std::span(couplings_).first(coupled_)) {
    const auto [x, y] = std::pair{coupling.a, coupling.b};
    if (!coupling.touches || (is_converged(x) && is_converged(y))) continue;
    group_[x] = group_[y] = 0;
    const std::size_t first = root(x), second = root(y);
    parent_[std::max(first, second)] = std::min(first, second);
  }
  for (std::size_t i = 0; i < members_.size(); ++i)
    if (group_[i] != kStill) group_[i] = root(i);
  return any;
}

// The unknowns of those that move.
void ContactIsland::arrange() {
  moving_.clear();
  diagonal_.clear();
  first_.assign(1, 0);
  for (std::size_t i = 0; i < members_.size(); ++i) {
    if (!moves(i)) continue;
    place_[i] = moving_.size();
    moving_.push_back(i);
    const ContactStep& contact = *members_[i].contact;
    scale_.segment(first_.back(), contact.unknowns()) =
        contact.row_scale().head(contact.unknowns());
    diagonal_.push_back(&contact.jacobian());
    first_.push_back(first_.back() + contact.unknowns());
  }
}

// What is needed of the start of the step where the pair acts.
void ContactIsland::find_start(PairPoint& pair) {
  const BentShape shape = members_[pair.b].contact->shape_at_start();
  bent_rows(shape, pair.place_at_start, scratch_, pair.rows);
  pair.gradient = bent_gradient(shape, pair.place_at_start);
  pair.fresh = false;
}

// What the pair feels at the members' z, for those that are looked at.
void ContactIsland::evaluate(PairPoint& pair, double renew) {
  ContactStep& first = *members_[pair.a].contact;
  ContactStep& second = *members_[pair.b].contact;
  const Vector3d x1 = first.end_of_point(pair.point);
  pair.place = second.into_rest(x1, true);
  const bool acts = pair.distance < pair.law.margin || pair.held.grinding != 0.0;
  // Too far for d1 to be within the margin, if its gradient is shorter than 2.
  const double nearer = 2.0 * ((pair.place - pair.place_at_start).norm() + bends_[pair.b]);
  if (!acts && pair.distance - nearer > pair.law.margin) return pair.now.clear(pair.distance);
  const BentShape shape = second.shape_at_end();
  const double distance = bent_distance(shape, pair.place);
  if (!acts && distance >= pair.law.margin) return pair.now.clear(distance);
  pair.touch_a = first.touch_at_point(pair.point);
  const bool fresh = pair.fresh;
  if (fresh) find_start(pair);
  pair.touch_b = second.touch_by_other(x1, first.middle_of(pair.touch_a));
  pair.way.path = x1 - pair.touch_a.x0 - second.way_under(pair.touch_b);
  pair.way.bend = second.bend_under(pair.rows);
  if (renew > 0.0 || fresh)
    pair.held.normal = second.turn_out(0.5 * (pair.gradient + bent_gradient(shape, pair.place)));
  const auto force = [&] {
    return contact_force(pair.law, pair.distance, pair.energy, distance, pair.way, h_, pair.held);
  };
  pair.now = force();
  if (renew > 0.0) {
    pair.held.grinding += renew * (pair.now.grinding - pair.held.grinding);
    pair.now = force();
  }
  if (!pair.now.acts) return;
  if (looked_[pair.a] != 0) first.push_point(pair.now.force, pair.touch_a, pair.point);
  if (looked_[pair.b] != 0)
    second.push_rows(-pair.now.force, -pair.now.bend_force, pair.touch_b, pair.rows);
}

// The residuals of those that are looked at at the members' z; returns the size of those that move
// in units of what is small.
double ContactIsland::evaluate(double renew) {
  bends_.resize(members_.size());
  for (std::size_t i = 0; i < members_.size(); ++i) {
    if (looked_[i] == 0) continue;
    members_[i].contact->evaluate(renew);
    bends_[i] = members_[i].contact->bend_in_step();
  }
  for (Coupling& coupling : std::span(couplings_).first(coupled_)) {
    if (!looks_at(coupling)) continue;
    coupling.touches = false;
    for (PairPoint& pair : points_.subspan(coupling.first, coupling.count)) {
      evaluate(pair, renew);
      coupling.touches = coupling.touches || pair.now.acts;
    }
  }
  double square = 0.0;
  for (std::size_t i = 0; i < members_.size(); ++i) {
    if (looked_[i] == 0) continue;
    sizes_[i] = members_[i].contact->close();
    const double share = sizes_[i] / enough_[i];
    if (moves(i)) square += share * share;
  }
  return std::sqrt(square);
}

// How the pair's forces fall with the unknowns of its bodies, by d1, the path and the bending.
void ContactIsland::find_changes(const PairPoint& pair) {
  ContactStep& first = *members_[pair.a].contact;
  ContactStep& second = *members_[pair.b].contact;
  const Index n = second.unknowns();
  const Index r = second.turns() ? n - 6 : n;
  const Vector3d gradient =
      second.turn_out_at_end(bent_change(second.shape_at_end(), pair.place, scratch_, by_q_));
  const Eigen::Matrix3Xd& way = second.change_of_way(pair.touch_b, pair.rows);
  const auto find = [&](const ContactSlope& slope, Eigen::Matrix3Xd& by_a, Eigen::Matrix3Xd& by_b) {
    const Eigen::Matrix3d by_end = slope.by_distance * gradient.transpose() + slope.by_path;
    by_a.noalias() = by_end * first.lever_way();
    by_b.resize(3, n);
    by_b.leftCols(r).noalias() = slope.by_bend * way.leftCols(r);
    by_b.leftCols(r).noalias() += slope.by_distance * by_q_.transpose();
    if (!second.turns()) return;
    by_b.rightCols<6>().noalias() = -slope.by_path * way.middleCols<6>(r);
    by_b.rightCols<6>().noalias() -=
        slope.by_distance * (gradient.transpose() * second.lever_way().rightCols<6>());
  };
  find(pair.now.slope, change_a_, change_b_);
  find(pair.now.bend_slope, bend_change_a_, bend_change_b_);
}

void ContactIsland::add_pair(const PairPoint& pair, Coupling& coupling) {
  ContactStep& first = *members_[pair.a].contact;
  ContactStep& second = *members_[pair.b].contact;
  first.lever_at_point(pair.touch_a, pair.point);
  second.lever_at_rows(pair.touch_b, pair.rows);
  find_changes(pair);
  const bool forward = pair.a < pair.b;
  first.add_pushed(change_a_, change_a_, 1.0, first.own_block());
  first.add_pushed(change_b_, change_b_, 1.0, forward ? coupling.ab : coupling.ba);
  second.add_pushed(change_b_, bend_change_b_, -1.0, second.own_block());
  second.add_pushed(change_a_, bend_change_a_, -1.0, forward ? coupling.ba : coupling.ab);
  first.add_geometry(pair.now.force, pair.touch_a, pair.point);
  second.add_geometry_of_other(-pair.now.force, -pair.now.bend_force, pair.touch_b, pair.rows);
  // The torque on the second acts where the first's point is.
  if (!second.turns()) return;
  const Index turn = second.unknowns() - 6;
  (forward ? coupling.ba : coupling.ab).middleRows<3>(turn).noalias() +=
      second.turn_of_arm(-pair.now.force) * second.rotation_at_start().transpose() *
      first.path_of_middle().leftCols(first.unknowns());
}

void ContactIsland::make_jacobian(double heavier) {
  for (const std::size_t i : moving_) members_[i].contact->make_jacobian(heavier);
  links_.clear();
  for (Coupling& coupling : std::span(couplings_).first(coupled_)) {
    if (!coupling.touches || !(moves(coupling.a) || moves(coupling.b))) continue;
    coupling.ab.setZero();
    coupling.ba.setZero();
    for (const PairPoint& pair : points_.subspan(coupling.first, coupling.count))
      if (pair.now.acts) add_pair(pair, coupling);
    if (moves(coupling.a) && moves(coupling.b))
      links_.push_back({place_[coupling.a], place_[coupling.b], &coupling.ab, &coupling.ba});
  }
  for (std::size_t k = 0; k < moving_.size(); ++k)
    residual_.segment(first_[k], first_[k + 1] - first_[k]) =
        members_[moving_[k]].contact->residual().head(first_[k + 1] - first_[k]);
}

bool ContactIsland::solve_for_move() {
  const BlockSystem system{first_, diagonal_, links_, &scale_};
  return solver_.solve(system, residual_, move_);
}

// Finds anew what is small; the size of the residuals that move in its units.
double ContactIsland::measure() {
  double square = 0.0;
  for (std::size_t i = 0; i < members_.size(); ++i) {
    if (looked_[i] == 0) continue;
    enough_[i] = members_[i].contact->enough();
    if (moves(i)) square += sizes_[i] * sizes_[i] / (enough_[i] * enough_[i]);
  }
  return std::sqrt(square);
}

// A move of Newton's method of those that move. kDone: they are converged, or at rounding.
ContactIsland::Outcome ContactIsland::move(int iteration, double& heavier) {
  double size = measure();
  if (const double renew = renewal(iteration, size); renew > 0.0) {
    evaluate(renew);
    size = measure();
  }
  if (!std::isfinite(size)) return Outcome::kFailed;
  const auto of = [this](VectorXd& all, std::size_t k) {
    return all.segment(first_[k], first_[k + 1] - first_[k]);
  };
  for (std::size_t k = 0; k < moving_.size(); ++k)
    of(z_before_, k) = members_[moving_[k]].contact->z().head(first_[k + 1] - first_[k]);
  const auto slope = [&] {
    double work = 0.0;
    for (std::size_t k = 0; k < moving_.size(); ++k)
      work += members_[moving_[k]].contact->work_along(of(move_, k));
    return -work;
  };
  const auto go = [&](double length) {
    for (std::size_t k = 0; k < moving_.size(); ++k)
      members_[moving_[k]].contact->z().head(first_[k + 1] - first_[k]) =
          of(z_before_, k) - length * of(move_, k);
    const double next = evaluate(0.0);
    return LineTrial{next, slope()};
  };
  const auto find_move = [&](double added) {
    make_jacobian(added);
    return solve_for_move() ? slope() : 0.0;
  };
  LineTrial reached;
  const bool near = size <= 1e3;
  if (!newton_move(find_move, go, size, near, heavier, reached))
    return near ? Outcome::kDone : Outcome::kFailed;
  // At rounding no move helps.
  if (!(reached.size < 0.9 * size) && near) {
    if (reached.size > size) go(0.0);
    return Outcome::kDone;
  }
  return Outcome::kMoved;
}

// Moves of each member by itself, which find out for most contacts whether they hold: one length
// along a move of many would stop at the first that does.
void ContactIsland::relax(std::size_t root, int iteration, int times) {
  for (std::size_t i = 0; i < members_.size(); ++i) {
    if (group_[i] != root) continue;
    choose_one(i);
    evaluate(0.0);
    double heavier = 0.0;
    for (int k = 0; k < times && measure() > 1.0; ++k)
      if (move(iteration, heavier) != Outcome::kMoved) break;
  }
}

bool ContactIsland::solve(int relaxed, int alone, int& iterations) {
  choose_all();
  evaluate(0.0);
  measure();
  heavier_.assign(members_.size(), 0.0);
  for (iterations = 0; iterations < kMostIterations; ++iterations) {
    if (!find_groups()) return true;
    bool moved = false;
    for (std::size_t root = 0; root < members_.size(); ++root) {
      if (group_[root] != root) continue;
      const bool relaxes =
          iterations < relaxed && std::count(group_.begin(), group_.end(), root) > 1;
      if (relaxes) relax(root, iterations, alone);
      choose(root);
      if (relaxes) evaluate(0.0);
      const Outcome outcome = move(iterations, heavier_[root]);
      if (outcome == Outcome::kFailed) return false;
      moved = moved || outcome == Outcome::kMoved;
    }
    if (!moved) return true;
  }
  return false;
}

void ContactIsland::settle() {
  std::fill(accounts_.begin(), accounts_.end(), ContactAccount{});
  std::fill(starts_.begin(), starts_.end(), 0.0);
  for (const PairPoint& pair : points_) {
    ContactAccount& a = accounts_[pair.a];
    ContactAccount& b = accounts_[pair.b];
    starts_[pair.a] += pair.energy;
    a.energy += pair.now.energy;
    a.lost += pair.now.lost;
    a.rubbed += pair.now.rubbed;
    a.penetration = std::max(a.penetration, -pair.now.distance);
    if (!pair.now.acts) continue;
    a.work += pair.now.force.dot(pair.touch_a.x1 - pair.touch_a.x0);
    b.work -= pair.now.force.dot(pair.touch_a.x1 - pair.touch_a.x0 - pair.way.path) +
              pair.now.bend_force.dot(pair.way.bend);
    const double impulse = h_ * pair.now.force.norm();
    a.impulse += impulse;
    b.impulse += impulse;
    ++a.active;
    ++b.active;
  }
}

// Where the bodies would go without forces, with nothing held.
void ContactIsland::begin() {
  for (const IslandMember& member : members_)
    member.contact->begin(*member.state, *member.load, member.free);
  for (PairPoint& pair : points_) {
    pair.now = {};
    pair.held = {};
    pair.fresh = true;
  }
}

void ContactIsland::step(std::span<const IslandMember> members, std::span<PairPoint> points,
                         double h, std::span<StepReport> reports) {
  members_ = members;
  points_ = points;
  h_ = h;
  begin();
  Index all = 0;
  for (const IslandMember& member : members) all += member.contact->unknowns();
  if (residual_.size() < all) {
    residual_.resize(all);
    move_.resize(all);
    z_before_.resize(all);
    scale_.resize(all);
  }
  enough_.assign(members.size(), 1.0);
  sizes_.assign(members.size(), 0.0);
  accounts_.resize(members.size());
  starts_.resize(members.size());
  couple();
  int iterations = 0;
  bool converged = false;
  for (const Attempt& attempt : kAttempts) {
    if (iterations != 0) begin();
    int more = 0;
    converged = solve(attempt.relaxed, attempt.alone, more);
    iterations += more;
    if (converged) break;
  }
  if (converged) settle();
  for (std::size_t i = 0; i < members.size(); ++i) {
    StepReport& report = reports[i];
    report = {};
    report.converged = converged;
    report.iterations = iterations;
    report.residual = 0.5 * h * sizes_[i];
    if (!converged) continue;
    members[i].contact->settle_pairs(accounts_[i], starts_[i]);
    members[i].contact->finish(*members[i].state, report);
  }
}

}  // namespace tremolo
