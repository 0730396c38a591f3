#include "runtime/contact/islands/contact_island.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "runtime/math/line_search.h"

namespace tremolo {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr int kMostIterations = 60;
// After the iterations in which all members move by themselves, in these those do whose residual is
// above a share of the largest.
constexpr int kFarRelaxed = 15;
constexpr double kFarShare = 0.1;
// In groups this large, whole moves are not tried in the first iterations: a search along the move
// nearly always follows, until it is known which contacts act.
constexpr std::size_t kHeap = 16;
constexpr int kSearched = 4;
constexpr int kHeldFrom = 20;  // iteration from which a last resort keeps limits
// A step that may be subdivided is given up if the residual is kFarOff times the small size after
// kHopeless iterations.
constexpr int kHopeless = 25;
constexpr double kFarOff = 1e6;
// Tolerance of a move from there, whose length is searched anyway.
constexpr double kFarTolerance = 1e-3;
// With a residual this large other attempts are skipped and the step is subdivided.
constexpr double kBeyond = 1e8;

bool renews_limits_alone(const ContactRenewal& renewal) {
  return !renewal.normals && renewal.limits == 1.0;
}

}  // namespace

// The attempts at the step, in their order.
const ContactIsland::Attempt ContactIsland::kAttempts[] = {
    {1, 2, false}, {8, 8, false}, {30, 2, false}, {3, 3, true}, {0, 0, true}};

// Applies the forces of a pair or a joint to those of its members that are evaluated.
void ContactIsland::push(const PairPoint& pair) {
  if (!pair.now.acts) return;
  if (looked_[pair.a] != 0)
    body(pair.a).equations().push_point(pair.now.force, pair.touch_a, pair.point);
  if (looked_[pair.b] != 0) push_second(pair, body(pair.b).equations());
  if (!(pair.law.radius > 0.0)) return;
  const Eigen::Vector3d torque = surface_arm(pair.law, pair.held).cross(pair.now.rub);
  if (looked_[pair.a] != 0) body(pair.a).equations().push_turn(torque);
  if (looked_[pair.b] != 0) body(pair.b).equations().push_turn(-torque);
}

void ContactIsland::push(const IslandJoint& link) {
  if (looked_[link.a] != 0) push_first(link, body(link.a).equations());
  if (looked_[link.b] != 0) push_second(link, body(link.b).equations());
}

// Computes the residuals of the evaluated members at their z. Returns the size of those that move
// in units of the small size.
double ContactIsland::evaluate(const ContactRenewal& renewal) {
  const bool follows = renews_limits_alone(renewal);
  for (const std::size_t i : looked_at_) {
    body(i).evaluate(renewal);
    ways_[i] = body(i).way_in_step();
    followed_[i] = follows ? 1 : 0;
  }
  for (const std::size_t k : seen_) {
    Coupling& coupling = couplings_[k];
    coupling.touches = coupling.joints != 0;
    coupling.rate = {};
    const std::span points = points_.subspan(coupling.first, coupling.count);
    for (PairPoint& pair : points)
      approach_pair(pair, {body(pair.a).equations(), body(pair.b).equations()},
                    ways_between(ways_[pair.a], ways_[pair.b]), coupling.rate);
    for (PairPoint& pair : points) {
      press_pair(pair, {body(pair.a).equations(), body(pair.b).equations()}, {h_, coupling.rate},
                 renewal, scratch_);
      push(pair);
      coupling.touches = coupling.touches || pair.now.acts;
    }
    for (IslandJoint& link : joints_.subspan(coupling.first_joint, coupling.joints)) {
      evaluate_joint(link, body(link.a).equations(), body(link.b).equations(), h_);
      push(link);
    }
  }
  double square = 0.0;
  for (const std::size_t i : looked_at_) {
    sizes_[i] = body(i).close();
    const double share = sizes_[i] / enough_[i];
    if (moves(i)) square += share * share;
  }
  return std::sqrt(square);
}

// True if evaluate() would change nothing: all evaluated members were left like that.
bool ContactIsland::is_renewed(const ContactRenewal& renewal) const {
  return renews_limits_alone(renewal) &&
         std::all_of(looked_at_.begin(), looked_at_.end(),
                     [this](std::size_t i) { return followed_[i] != 0; });
}

// Derivatives of the members' residuals with respect to their own unknowns and to each other's.
void ContactIsland::make_links(Coupling& coupling, bool follows) {
  ContactEquations &low = body(coupling.a).equations(), &high = body(coupling.b).equations();
  PairBlocks& of = coupling.blocks;
  of.clear(low.unknowns(), high.unknowns());
  const PairSides up{of.by_other, of.other_by, of.push, of.growth, of.other_push, of.other_growth};
  const PairSides down{of.other_by,     of.by_other, of.other_push,
                       of.other_growth, of.push,     of.growth};
  for (PairPoint& pair : points_.subspan(coupling.first, coupling.count))
    if (pair.now.acts)
      add_pair_slopes(pair, {body(pair.a).equations(), body(pair.b).equations()},
                      {h_, coupling.rate}, follows, scratch_, pair.a < pair.b ? up : down);
  if (coupling.rate.force > 0.0) {
    low.own_block().noalias() += of.push.lazyProduct(of.growth.transpose());
    high.own_block().noalias() += of.other_push.lazyProduct(of.other_growth.transpose());
    of.by_other.noalias() += of.push.lazyProduct(of.other_growth.transpose());
    of.other_by.noalias() += of.other_push.lazyProduct(of.growth.transpose());
  }
  for (const IslandJoint& link : joints_.subspan(coupling.first_joint, coupling.joints)) {
    const PairSides& sides = link.a < link.b ? up : down;
    add_joint_slopes(link, body(link.a).equations(), body(link.b).equations(),
                     sides.first_by_second, sides.second_by_first);
  }
}

void ContactIsland::make_jacobian(double heavier, bool follows) {
  for (const std::size_t i : moving_) body(i).make_jacobian(heavier, follows);
  links_.clear();
  for (const std::size_t k : seen_) {
    Coupling& coupling = couplings_[k];
    if (!coupling.touches || !(moves(coupling.a) || moves(coupling.b))) continue;
    make_links(coupling, follows);
    if (moves(coupling.a) && moves(coupling.b))
      links_.push_back({place_[coupling.a], place_[coupling.b], &coupling.blocks.by_other,
                        &coupling.blocks.other_by});
  }
  for (std::size_t k = 0; k < moving_.size(); ++k)
    residual_.segment(first_[k], first_[k + 1] - first_[k]) =
        body(moving_[k]).equations().residual.head(first_[k + 1] - first_[k]);
}

// size: of the residual, in units of the small size.
bool ContactIsland::solve_for_move(double size) {
  const double tolerance = size > kFarOff ? kFarTolerance : BlockSolver::kTolerance;
  const BlockSystem system{first_, diagonal_, links_, &scale_};
  return solver_.solve(system, residual_, move_, tolerance);
}

// Updates the small sizes; returns the size of the residuals that move in these units.
double ContactIsland::measure() {
  double square = 0.0;
  for (const std::size_t i : looked_at_) {
    enough_[i] = body(i).enough();
    const double share = sizes_[i] / enough_[i];
    if (moves(i)) square += share * share;
  }
  return std::sqrt(square);
}

// Same as ContactStep::try_following(), starting from z_before_.
bool ContactIsland::try_following(int iteration, double size) {
  const auto go = [this](double length) {
    for (std::size_t k = 0; k < moving_.size(); ++k) {
      const Index first = first_[k], count = first_[k + 1] - first;
      body(moving_[k]).equations().z.head(count) =
          z_before_.segment(first, count) - length * move_.segment(first, count);
    }
    return evaluate({.normals = false, .limits = 1.0});
  };
  make_jacobian(0.0, true);
  if (!solve_for_move(size)) return false;
  for (double length = 1.0; length >= shortest_following(iteration); length *= 0.5)
    if (go(length) <= following_bound(length) * size) return true;
  go(0.0);
  return false;
}

// The first attempt with all moving members: one whole move with limits that follow. False: the
// move does not lower the residual enough, or is not needed.
bool ContactIsland::move_whole(int iteration) {
  if (hold_ && iteration >= kHeldFrom) return false;
  const ContactRenewal renewed = renewal(iteration, measure(), hold_);
  if (!is_renewed(renewed)) evaluate(renewed);
  const double size = measure();
  if (!std::isfinite(size) || size <= kConverged) return false;
  keep_unknowns();
  return try_following(iteration, size);
}

void ContactIsland::keep_unknowns() {
  for (std::size_t k = 0; k < moving_.size(); ++k)
    z_before_.segment(first_[k], first_[k + 1] - first_[k]) =
        body(moving_[k]).equations().z.head(first_[k + 1] - first_[k]);
}

// One move of Newton's method for the moving members. kDone: they are converged, or at rounding.
ContactIsland::Outcome ContactIsland::move(int iteration, bool follow, double& heavier) {
  evaluate(renewal(iteration, measure(), hold_));
  double size = measure();
  if (!std::isfinite(size)) return Outcome::kFailed;
  if (size <= kConverged) return Outcome::kDone;
  const auto of = [this](VectorXd& all, std::size_t k) {
    return all.segment(first_[k], first_[k + 1] - first_[k]);
  };
  keep_unknowns();
  if (follow && limits_follow(iteration, size, hold_) && try_following(iteration, size))
    return Outcome::kMoved;
  const auto slope = [&] {
    double work = 0.0;
    for (std::size_t k = 0; k < moving_.size(); ++k)
      work += body(moving_[k]).equations().work_along(of(move_, k));
    return -work;
  };
  const auto go = [&](double length) {
    for (std::size_t k = 0; k < moving_.size(); ++k)
      body(moving_[k]).equations().z.head(first_[k + 1] - first_[k]) =
          of(z_before_, k) - length * of(move_, k);
    const double next = evaluate({});
    return LineTrial{next, slope()};
  };
  const auto find_move = [&](double added) {
    make_jacobian(added, false);
    return solve_for_move(size) ? slope() : 0.0;
  };
  LineTrial reached;
  const bool near = size <= near_rounding(hold_);
  if (!newton_move(find_move, go, size, near, heavier, reached))
    return near ? Outcome::kDone : Outcome::kFailed;
  // At rounding level no move lowers the residual.
  if (!(reached.size < 0.9 * size) && near) {
    if (reached.size > size) go(0.0);
    return Outcome::kDone;
  }
  return Outcome::kMoved;
}

// Moves each member by itself. This finds for most contacts whether they act; a common length along
// one move of many members would stop at the first contact that begins.
void ContactIsland::relax(std::span<const std::size_t> group, int iteration, int times) {
  for (const std::size_t i : group) {
    choose_one(i);
    evaluate({});
    double heavier = 0.0;
    for (int k = 0; k < times && measure() > 1.0; ++k)
      if (move(iteration, true, heavier) != Outcome::kMoved) break;
  }
}

// Moves those members by themselves whose residual is not small beside the largest: few of them
// keep the length of all members' common move short.
void ContactIsland::relax_farthest(std::span<const std::size_t> group, int iteration, int times) {
  const auto size_of = [this](std::size_t i) { return sizes_[i] / enough_[i]; };
  double most = 0.0;
  for (const std::size_t i : group) most = std::max(most, size_of(i));
  farthest_.clear();
  for (const std::size_t i : group)
    if (size_of(i) > kFarShare * most) farthest_.push_back(i);
  relax(farthest_, iteration, times);
}

// The largest residual in units of the small size.
double ContactIsland::farthest() const {
  double most = 0.0;
  for (std::size_t i = 0; i < members_.size(); ++i) most = std::max(most, sizes_[i] / enough_[i]);
  return most;
}

bool ContactIsland::solve(const Attempt& attempt, bool whole, int& iterations) {
  choose_all();
  evaluate({});
  measure();
  heavier_.assign(members_.size(), 0.0);
  for (iterations = 0; iterations < kMostIterations; ++iterations) {
    if (!find_groups()) {
      // Friction limits that were kept along the last moves may have to follow.
      if (hold_ && iterations >= kHeldFrom) return true;
      choose_all();
      evaluate({.normals = false, .limits = 1.0});
      if (!find_groups()) return true;
    }
    if (!whole && iterations >= kHopeless && farthest() > kFarOff) return false;
    bool moved = false;
    for (std::size_t first = 0, last = 0; first < by_group_.size(); first = last) {
      const std::size_t root = group_[by_group_[first]];
      while (last < by_group_.size() && group_[by_group_[last]] == root) ++last;
      const std::span group = std::span(by_group_).subspan(first, last - first);
      choose(group);
      const bool searched = group.size() > kHeap && iterations < kSearched;
      if (!searched && move_whole(iterations)) {
        moved = true;
        continue;
      }
      if (iterations < attempt.relaxed + kFarRelaxed && group.size() > 1 && attempt.relaxed != 0) {
        if (iterations < attempt.relaxed)
          relax(group, iterations, attempt.alone);
        else
          relax_farthest(group, iterations, attempt.alone);
        choose(group);
        evaluate({});
      }
      const Outcome outcome = move(iterations, false, heavier_[root]);
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
    starts_[pair.a] += pair.energy + 0.5 * pair.law.shear * pair.memory.slip.squaredNorm();
    const PairBodies bodies{body(pair.a).equations(), body(pair.b).equations()};
    settle_pair(pair, pair.near ? pair.place : place_at_end(pair, bodies), bodies.second, h_,
                accounts_[pair.a], accounts_[pair.b]);
  }
  for (const IslandJoint& link : joints_)
    settle_joint(link, body(link.a).equations(), body(link.b).equations(), accounts_[link.a],
                 accounts_[link.b]);
}

// Starts the step from the motion without forces, with no kept values.
void ContactIsland::begin() {
  for (const IslandMember& member : members_)
    member.contact->begin(*member.state, *member.load, member.free);
  for (PairPoint& pair : points_) begin_pair(pair);
  for (IslandJoint& link : joints_) {
    const Joint& joint = *link.joint;
    const ContactEquations &one = body(link.a).equations(), &two = body(link.b).equations();
    begin_joint(link, one, two);
    const double stiffness = joint.stiffness + 2.0 * joint.damping / h_;
    const auto far = [](const ContactEquations& of, const JointPlace& place) {
      return of.motion.c0.norm() + place.rest.norm();
    };
    members_[link.a].contact->hold_at(joint.first, stiffness, far(two, joint.second));
    members_[link.b].contact->hold_at(joint.second, stiffness, far(one, joint.first));
  }
}

// Adds points of its pairs and of colliders that came within the margin without prediction. True if
// there are any.
bool ContactIsland::add_missed(std::vector<PairPoint>& points, std::size_t& count) {
  bool any = false;
  for (const IslandMember& member : members_) any = member.contact->add_missed() || any;
  const std::size_t known = count;
  for (std::size_t k = 0; k < coupled_; ++k) {
    const Coupling& coupling = couplings_[k];
    if (coupling.count == 0) continue;
    const std::size_t a = coupling.a, b = coupling.b;
    count = add_missed_points(body(a), body(b), {a, b, members_[b].number}, points, count);
    count = add_missed_points(body(b), body(a), {b, a, members_[a].number}, points, count);
  }
  if (count == known) return any;
  const auto order = [](const PairPoint& pair) {
    return std::tuple(std::min(pair.a, pair.b), std::max(pair.a, pair.b), pair.a, pair.point);
  };
  std::sort(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(count),
            [&](const PairPoint& x, const PairPoint& y) { return order(x) < order(y); });
  points_ = std::span(points).first(count);
  couple();
  return true;
}

void ContactIsland::remember() {
  for (const PairPoint& pair : points_)
    remember_pair(pair, body(pair.a), members_[pair.b].number, h_);
  for (const IslandMember& member : members_) member.contact->pair_memories().sort();
}

void ContactIsland::step(std::span<const IslandMember> members, std::vector<PairPoint>& points,
                         std::size_t& count, std::span<IslandJoint> joints, double h, bool whole,
                         std::span<StepReport> reports) {
  members_ = members;
  points_ = std::span(points).first(count);
  joints_ = joints;
  h_ = h;
  begin();
  Index all = 0;
  for (const IslandMember& member : members) all += member.contact->equations().unknowns();
  if (residual_.size() < all) {
    residual_.resize(all);
    move_.resize(all);
    z_before_.resize(all);
    scale_.resize(all);
  }
  enough_.assign(members.size(), 1.0);
  sizes_.assign(members.size(), 0.0);
  ways_.assign(members.size(), {});
  followed_.assign(members.size(), 0);
  accounts_.resize(members.size());
  starts_.resize(members.size());
  couple();
  int iterations = 0;
  bool converged = false;
  for (const Attempt& attempt :
       std::span(kAttempts).first(whole ? std::size(kAttempts) : kFirstAttempts)) {
    if (iterations != 0) begin();
    do {
      int more = 0;
      hold_ = attempt.hold;
      converged = solve(attempt, whole, more);
      iterations += more;
    } while (converged && add_missed(points, count));
    if (converged || (!whole && !(farthest() < kBeyond))) break;
  }
  if (converged) settle();
  for (std::size_t i = 0; i < members.size(); ++i) {
    StepReport& report = reports[i];
    report = {};
    report.converged = converged;
    report.iterations = iterations;
    report.residual = 0.5 * h * sizes_[i];
    if (!converged) continue;
    members[i].contact->finish(*members[i].state, report, accounts_[i], starts_[i]);
  }
  if (!converged) return;
  remember();
  if (hold_)
    for (const IslandMember& member : members_) ++member.contact->record().held_steps;
}

}  // namespace tremolo
