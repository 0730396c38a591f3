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

ContactIsland::Coupling& ContactIsland::add_coupling(std::size_t low, std::size_t high) {
  if (coupled_ == couplings_.size()) couplings_.emplace_back();
  Coupling& coupling = couplings_[coupled_++];
  coupling.a = low;
  coupling.b = high;
  coupling.first = coupling.count = coupling.first_joint = coupling.joints = 0;
  coupling.touches = coupling.looked = false;
  coupling.ab.resize(members_[low].contact->unknowns(), members_[high].contact->unknowns());
  coupling.ba.resize(coupling.ab.cols(), coupling.ab.rows());
  return coupling;
}

// Points and joints come pair by pair of members.
void ContactIsland::couple() {
  coupled_ = 0;
  Coupling* last = nullptr;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const auto [low, high] = std::minmax(points_[i].a, points_[i].b);
    if (last == nullptr || last->a != low || last->b != high) {
      last = &add_coupling(low, high);
      last->first = i;
    }
    ++last->count;
  }
  const std::size_t touching = coupled_;
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    const std::size_t low = std::min(joints_[i].a, joints_[i].b);
    const std::size_t high = std::max(joints_[i].a, joints_[i].b);
    const auto same = [low, high](const Coupling& coupling) {
      return coupling.a == low && coupling.b == high;
    };
    if (coupled_ > touching && same(couplings_[coupled_ - 1])) {
      ++couplings_[coupled_ - 1].joints;
      continue;
    }
    const auto end = couplings_.begin() + static_cast<std::ptrdiff_t>(touching);
    const auto found = std::find_if(couplings_.begin(), end, same);
    Coupling& coupling = found != end ? *found : add_coupling(low, high);
    if (coupling.joints == 0) coupling.first_joint = i;
    ++coupling.joints;
  }
  list_couplings();
}

void ContactIsland::list_couplings() {
  const std::span couplings = std::span(couplings_).first(coupled_);
  first_coupling_.assign(members_.size() + 1, 0);
  for (const Coupling& coupling : couplings) {
    ++first_coupling_[coupling.a + 1];
    ++first_coupling_[coupling.b + 1];
  }
  for (std::size_t i = 0; i < members_.size(); ++i) first_coupling_[i + 1] += first_coupling_[i];
  coupling_of_.resize(2 * coupled_);
  by_group_.assign(first_coupling_.begin(), first_coupling_.end() - 1);
  for (std::size_t k = 0; k < coupled_; ++k) {
    coupling_of_[by_group_[couplings[k].a]++] = k;
    coupling_of_[by_group_[couplings[k].b]++] = k;
  }
}

void ContactIsland::choose_none() {
  for (const std::size_t i : looked_at_) looked_[i] = 0;
  for (const std::size_t i : moving_) place_[i] = kStill;
  for (const std::size_t k : seen_) couplings_[k].looked = false;
  looked_at_.clear();
  seen_.clear();
  moving_.clear();
  diagonal_.clear();
  first_.assign(1, 0);
}

void ContactIsland::look(std::size_t member) {
  if (looked_[member] != 0) return;
  looked_[member] = 1;
  looked_at_.push_back(member);
}

void ContactIsland::look_at_couplings(std::size_t member) {
  for (const std::size_t k : couplings_of(member)) {
    if (couplings_[k].looked) continue;
    couplings_[k].looked = true;
    seen_.push_back(k);
  }
}

// Its unknowns come after those of the members that move so far.
void ContactIsland::move_with(std::size_t member) {
  place_[member] = moving_.size();
  moving_.push_back(member);
  const ContactStep& contact = *members_[member].contact;
  scale_.segment(first_.back(), contact.unknowns()) = contact.row_scale().head(contact.unknowns());
  diagonal_.push_back(&contact.jacobian());
  first_.push_back(first_.back() + contact.unknowns());
}

// All are looked at, and move.
void ContactIsland::choose_all() {
  looked_.assign(members_.size(), 0);
  place_.assign(members_.size(), kStill);
  looked_at_.clear();
  seen_.clear();
  moving_.clear();
  choose_none();
  for (std::size_t i = 0; i < members_.size(); ++i) {
    look(i);
    move_with(i);
  }
  for (std::size_t k = 0; k < coupled_; ++k) {
    couplings_[k].looked = true;
    seen_.push_back(k);
  }
}

// The members of a group move; what may feel that is looked at.
void ContactIsland::choose(std::span<const std::size_t> group) {
  choose_none();
  for (const std::size_t i : group) {
    move_with(i);
    look(i);
  }
  for (const std::size_t i : group)
    for (const std::size_t k : couplings_of(i)) {
      look(couplings_[k].a);
      look(couplings_[k].b);
    }
  for (const std::size_t i : looked_at_) look_at_couplings(i);
  // In their order, which that of sums follows.
  std::sort(seen_.begin(), seen_.end());
  std::sort(looked_at_.begin(), looked_at_.end());
}

// One member moves, and it alone is looked at.
void ContactIsland::choose_one(std::size_t member) {
  choose_none();
  move_with(member);
  look(member);
  look_at_couplings(member);
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
  by_group_.clear();
  for (std::size_t i = 0; i < members_.size(); ++i) {
    if (group_[i] == kStill) continue;
    group_[i] = root(i);
    by_group_.push_back(i);
  }
  std::sort(by_group_.begin(), by_group_.end(), [this](std::size_t x, std::size_t y) {
    return group_[x] < group_[y] || (group_[x] == group_[y] && x < y);
  });
  return any;
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
  pair.place = second.motion().into_rest(x1, true);
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
  pair.touch_b = second.motion().touch_by_other(x1, first.motion().middle_of(pair.touch_a));
  pair.way.path = x1 - pair.touch_a.x0 - second.motion().way_under(pair.touch_b);
  pair.way.bend = second.bend_under(pair.rows);
  if (renew > 0.0 || fresh)
    pair.held.normal =
        second.motion().turn_out(0.5 * (pair.gradient + bent_gradient(shape, pair.place)));
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
    second.push(-pair.now.force, -pair.now.bend_force, pair.touch_b, pair.rows);
}

// Forces and arms along the straight means of the places, for which both momenta stay.
void ContactIsland::evaluate(IslandJoint& link) {
  ContactStep& first = *members_[link.a].contact;
  ContactStep& second = *members_[link.b].contact;
  const StepMotion &one = first.motion(), &two = second.motion();
  link.touch_a = first.straight_touch_at(link.joint->first);
  link.touch_b = second.straight_touch_at(link.joint->second);
  const Vector3d s0 = link.touch_a.x0 - link.touch_b.x0, s1 = link.touch_a.x1 - link.touch_b.x1;
  const Vector3d turn = 0.5 * (one.R0 * one.phi + two.R0 * two.phi);
  link.now = joint_force(*link.joint, s0, s1, turn, h_);
  const Vector3d force = link.now.force;
  if (looked_[link.a] != 0) {
    first.push(force, one.straight_bend(force), link.touch_a, place_rows(link.joint->first));
    first.push_turn(link.now.torque);
  }
  if (looked_[link.b] != 0) {
    second.push(-force, -two.straight_bend(force), link.touch_b, place_rows(link.joint->second));
    second.push_turn(link.now.torque);
  }
}

// The residuals of those that are looked at at the members' z; returns the size of those that move
// in units of what is small.
double ContactIsland::evaluate(double renew) {
  bends_.resize(members_.size());
  for (const std::size_t i : looked_at_) {
    members_[i].contact->evaluate(renew);
    bends_[i] = members_[i].contact->bend_in_step();
  }
  for (const std::size_t k : seen_) {
    Coupling& coupling = couplings_[k];
    coupling.touches = coupling.joints != 0;
    for (PairPoint& pair : points_.subspan(coupling.first, coupling.count)) {
      evaluate(pair, renew);
      coupling.touches = coupling.touches || pair.now.acts;
    }
    for (IslandJoint& link : joints_.subspan(coupling.first_joint, coupling.joints)) evaluate(link);
  }
  double square = 0.0;
  for (const std::size_t i : looked_at_) {
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
  const Vector3d gradient = second.motion().turn_out_at_end(
      bent_change(second.shape_at_end(), pair.place, scratch_, by_q_));
  const Eigen::Matrix3Xd& way =
      second.lever().change_of_way(second.motion(), pair.touch_b, pair.rows);
  const auto find = [&](const ContactSlope& slope, Eigen::Matrix3Xd& by_a, Eigen::Matrix3Xd& by_b) {
    const Eigen::Matrix3d by_end = slope.by_distance * gradient.transpose() + slope.by_path;
    by_a.noalias() = by_end * first.lever().way();
    by_b.resize(3, n);
    by_b.leftCols(r).noalias() = slope.by_bend * way.leftCols(r);
    by_b.leftCols(r).noalias() += slope.by_distance * by_q_.transpose();
    if (!second.turns()) return;
    by_b.rightCols<6>().noalias() = -slope.by_path * way.middleCols<6>(r);
    by_b.rightCols<6>().noalias() -=
        slope.by_distance * (gradient.transpose() * second.lever().way().rightCols<6>());
  };
  find(pair.now.slope, change_a_, change_b_);
  find(pair.now.bend_slope, bend_change_a_, bend_change_b_);
}

void ContactIsland::add_pair(const PairPoint& pair, Coupling& coupling) {
  ContactStep& first = *members_[pair.a].contact;
  ContactStep& second = *members_[pair.b].contact;
  first.lever().make(first.motion(), pair.touch_a, first.point_rows(pair.point));
  second.lever().make(second.motion(), pair.touch_b, pair.rows);
  find_changes(pair);
  const bool forward = pair.a < pair.b;
  first.lever().add_pushed(change_a_, change_a_, 1.0, first.own_block());
  first.lever().add_pushed(change_b_, change_b_, 1.0, forward ? coupling.ab : coupling.ba);
  second.lever().add_pushed(change_b_, bend_change_b_, -1.0, second.own_block());
  second.lever().add_pushed(change_a_, bend_change_a_, -1.0, forward ? coupling.ba : coupling.ab);
  first.add_geometry_at_point(pair.now.force, pair.touch_a, pair.point);
  second.add_geometry_of_other(-pair.now.force, -pair.now.bend_force, pair.touch_b, pair.rows);
  // The torque on the second acts where the first's point is.
  if (!second.turns()) return;
  const Index turn = second.unknowns() - 6;
  (forward ? coupling.ba : coupling.ab).middleRows<3>(turn).noalias() +=
      second.motion().turn_of_arm(-pair.now.force) * second.motion().R0.transpose() *
      first.lever().path_of_middle(first.motion()).leftCols(first.unknowns());
}

// Without what turns the damper's force.
void ContactIsland::add_joint(const IslandJoint& link, Coupling& coupling) {
  const double signs[] = {1.0, -1.0};
  ContactStep* const bodies[] = {members_[link.a].contact, members_[link.b].contact};
  const VertexRows* const places[] = {&link.joint->first, &link.joint->second};
  const ContactTouch* const touches[] = {&link.touch_a, &link.touch_b};
  for (int k = 0; k < 2; ++k) {
    ContactStep& body = *bodies[k];
    const PlaceRows rows = place_rows(*places[k]);
    const Vector3d force = signs[k] * link.now.force;
    PlaceLever& lever = body.lever();
    lever.make(body.motion(), *touches[k], rows);
    lever.add_tangent(link.now.slope, body.whole_block());
    lever.make_straight_swing(body.motion());
    body.add_geometry(force, body.motion().straight_bend(force), *touches[k], rows);
  }
  PlaceLever &one = bodies[0]->lever(), &two = bodies[1]->lever();
  const bool forward = link.a < link.b;
  (forward ? coupling.ab : coupling.ba).noalias() -= one.push() * link.now.slope * two.way();
  (forward ? coupling.ba : coupling.ab).noalias() -= two.push() * link.now.slope * one.way();
}

void ContactIsland::make_jacobian(double heavier) {
  for (const std::size_t i : moving_) members_[i].contact->make_jacobian(heavier);
  links_.clear();
  for (const std::size_t k : seen_) {
    Coupling& coupling = couplings_[k];
    if (!coupling.touches || !(moves(coupling.a) || moves(coupling.b))) continue;
    coupling.ab.setZero();
    coupling.ba.setZero();
    for (const PairPoint& pair : points_.subspan(coupling.first, coupling.count))
      if (pair.now.acts) add_pair(pair, coupling);
    for (const IslandJoint& link : joints_.subspan(coupling.first_joint, coupling.joints))
      add_joint(link, coupling);
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
  for (const std::size_t i : looked_at_) {
    enough_[i] = members_[i].contact->enough();
    const double share = sizes_[i] / enough_[i];
    if (moves(i)) square += share * share;
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
void ContactIsland::relax(std::span<const std::size_t> group, int iteration, int times) {
  for (const std::size_t i : group) {
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
    for (std::size_t first = 0, last = 0; first < by_group_.size(); first = last) {
      const std::size_t root = group_[by_group_[first]];
      while (last < by_group_.size() && group_[by_group_[last]] == root) ++last;
      const std::span group = std::span(by_group_).subspan(first, last - first);
      const bool relaxes = iterations < relaxed && group.size() > 1;
      if (relaxes) relax(group, iterations, alone);
      choose(group);
      if (relaxes) evaluate(0.0);
      const Outcome outcome = move(iterations, heavier_[root]);
      if (outcome == Outcome::kFailed) return false;
      moved = moved || outcome == Outcome::kMoved;
    }
    if (!moved) return true;
  }
  return false;
}

// Books what each joint did to its bodies, to a driven one relative to its frame.
void ContactIsland::settle_joints() {
  for (IslandJoint& link : joints_) {
    link.joint->force = link.now.force;
    link.joint->energy = link.now.energy;
    link.joint->damped += link.now.damped;
    const auto work = [&](std::size_t member, const ContactTouch& touch, const VertexRows& place,
                          const Vector3d& force) {
      const ContactStep& body = *members_[member].contact;
      const StepMotion& motion = body.motion();
      const Vector3d bend = body.bend_under(place_rows(place));
      if (!body.turns()) return motion.straight_bend(force).dot(bend);
      return force.dot(touch.x1 - touch.x0) + link.now.torque.dot(motion.R0 * motion.phi);
    };
    accounts_[link.a].joint_work += work(link.a, link.touch_a, link.joint->first, link.now.force);
    accounts_[link.b].joint_work += work(link.b, link.touch_b, link.joint->second, -link.now.force);
  }
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
  settle_joints();
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
  for (const IslandJoint& link : joints_) {
    const Joint& joint = *link.joint;
    members_[link.a].contact->hold_at(joint.first, joint.stiffness + 2.0 * joint.damping / h_);
    members_[link.b].contact->hold_at(joint.second, joint.stiffness + 2.0 * joint.damping / h_);
  }
}

void ContactIsland::step(std::span<const IslandMember> members, std::span<PairPoint> points,
                         std::span<IslandJoint> joints, double h, std::span<StepReport> reports) {
  members_ = members;
  points_ = points;
  joints_ = joints;
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
