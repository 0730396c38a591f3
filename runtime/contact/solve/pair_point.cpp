#include "runtime/contact/solve/pair_point.h"

#include <algorithm>
#include <cmath>

#include "runtime/contact/passage.h"

namespace tremolo {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

// The law of a point of `first` and the shape of `second`: stiffness in proportion to the reduced
// mass; friction and restitution are geometric means.
ContactLaw law_between(const ContactStep& first, const ContactStep& second) {
  ContactLaw law = first.law();
  if (second.can_move()) law.stiffness *= second.mass() / (first.mass() + second.mass());
  law.friction = std::sqrt(first.law().friction * second.law().friction);
  law.restitution = std::sqrt(first.law().restitution * second.law().restitution);
  return law;
}

void find_start(PairPoint& pair, const ContactStep& second, PairScratch& scratch) {
  const BentShape shape = second.shape_at_start();
  bent_rows(shape, pair.place_at_start, scratch.bent, pair.rows);
  pair.gradient = bent_gradient(shape, pair.place_at_start);
  pair.fresh = false;
}

// The point's way is taken as if what bends did not.
bool passes(const PairPoint& pair, const ContactStep& second, double way) {
  if (pair.distance <= 0.0 || way <= pair.distance) return false;
  const BentShape start = second.shape_at_start(), end = second.shape_at_end();
  return goes_through(
      *second.shape(),
      {pair.place_at_start, pair.distance, bent_gradient(start, pair.place_at_start)},
      {pair.place, bent_distance(end, pair.place), bent_gradient(end, pair.place)});
}

// How the pair's forces fall with the unknowns of its bodies, by d1, the path and the bending.
void find_changes(const PairPoint& pair, const PairBodies& bodies, double h, PairScratch& scratch) {
  const auto& [first, second] = bodies;
  const Index n = second.unknowns();
  const Index r = second.turns() ? n - 6 : n;
  const Vector3d gradient = second.motion().turn_out_at_end(
      bent_change(second.shape_at_end(), pair.place, scratch.bent, scratch.by_q));
  const Eigen::Matrix3Xd& way =
      second.lever().change_of_way(second.motion(), pair.touch_b, pair.rows);
  const auto find = [&](const ContactSlope& slope, Eigen::Matrix3Xd& by_a, Eigen::Matrix3Xd& by_b) {
    const Eigen::Matrix3d by_end = slope.by_distance * gradient.transpose() + slope.by_path;
    by_a.noalias() = by_end * bodies.first.lever().way();
    by_b.resize(3, n);
    by_b.leftCols(r).noalias() = slope.by_bend * way.leftCols(r);
    by_b.leftCols(r).noalias() += slope.by_distance * scratch.by_q.transpose();
    if (!bodies.second.turns()) return;
    by_b.rightCols<6>().noalias() = -slope.by_path * way.middleCols<6>(r);
    by_b.rightCols<6>().noalias() -=
        slope.by_distance * (gradient.transpose() * bodies.second.lever().way().rightCols<6>());
  };
  const ContactSlopes slopes = contact_slopes(pair.law, pair.gap(), pair.way, h, pair.held);
  find(slopes.point, scratch.change_a, scratch.change_b);
  find(slopes.bend, scratch.bend_change_a, scratch.bend_change_b);
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

void begin_pair(PairPoint& pair) {
  pair.now = {};
  pair.held = {};
  pair.fresh = true;
}

void evaluate_pair(PairPoint& pair, const PairBodies& bodies, double bend, double h, double renew,
                   PairScratch& scratch) {
  const auto& [first, second] = bodies;
  const Vector3d x1 = first.end_of_point(pair.point);
  pair.place = second.motion().into_rest(x1, true);
  const bool acts = pair.distance < pair.law.margin || pair.held.grinding != 0.0;
  // Too far for d1 to be within the margin, if its gradient is shorter than 2.
  const double nearer = 2.0 * ((pair.place - pair.place_at_start).norm() + bend);
  if (!acts && pair.distance - nearer > pair.law.margin) return pair.now.clear(pair.distance);
  const BentShape shape = second.shape_at_end();
  const double distance = bent_distance(shape, pair.place);
  if (!acts && distance >= pair.law.margin) return pair.now.clear(distance);
  pair.touch_a = first.touch_at_point(pair.point);
  const bool fresh = pair.fresh;
  if (fresh) find_start(pair, second, scratch);
  pair.touch_b = second.motion().touch_by_other(x1, first.motion().middle_of(pair.touch_a));
  pair.way.path = x1 - pair.touch_a.x0 - second.motion().way_under(pair.touch_b);
  pair.way.bend = second.bend_under(pair.rows);
  if (renew > 0.0 || fresh)
    pair.held.normal =
        second.motion().turn_out(0.5 * (pair.gradient + bent_gradient(shape, pair.place)));
  const ContactGap gap{pair.distance, pair.energy, distance};
  pair.now = contact_force(pair.law, gap, pair.way, h, renew, pair.held);
}

void add_pair_slopes(const PairPoint& pair, const PairBodies& bodies, double h,
                     PairScratch& scratch, Eigen::MatrixXd& first_by_second,
                     Eigen::MatrixXd& second_by_first) {
  const auto& [first, second] = bodies;
  first.lever().make(first.motion(), pair.touch_a, first.point_rows(pair.point));
  second.lever().make(second.motion(), pair.touch_b, pair.rows);
  find_changes(pair, bodies, h, scratch);
  first.lever().add_pushed(scratch.change_a, scratch.change_a, 1.0, first.own_block());
  first.lever().add_pushed(scratch.change_b, scratch.change_b, 1.0, first_by_second);
  second.lever().add_pushed(scratch.change_b, scratch.bend_change_b, -1.0, second.own_block());
  second.lever().add_pushed(scratch.change_a, scratch.bend_change_a, -1.0, second_by_first);
  first.add_geometry_at_point(pair.now.force, pair.touch_a, pair.point);
  second.add_geometry_of_other(-pair.now.force, -pair.now.bend_force, pair.touch_b, pair.rows);
  // The torque on the second acts where the first's point is.
  if (!second.turns()) return;
  const Index turn = second.unknowns() - 6;
  second_by_first.middleRows<3>(turn).noalias() +=
      second.motion().turn_of_arm(-pair.now.force) * second.motion().R0.transpose() *
      first.lever().path_of_middle(first.motion()).leftCols(first.unknowns());
}

void settle_pair(const PairPoint& pair, const ContactStep& second, double h, ContactAccount& a,
                 ContactAccount& b) {
  const double way = (pair.place - pair.place_at_start).norm();
  a.way = std::max(a.way, way);
  if (passes(pair, second, way)) ++a.passed;
  a.energy += pair.now.energy;
  a.lost += pair.now.lost;
  a.rubbed += pair.now.rubbed;
  a.penetration = std::max(a.penetration, -pair.now.distance);
  if (!pair.now.acts) return;
  a.work += pair.now.force.dot(pair.touch_a.x1 - pair.touch_a.x0);
  b.work -= pair.now.force.dot(pair.touch_a.x1 - pair.touch_a.x0 - pair.way.path) +
            pair.now.bend_force.dot(pair.way.bend);
  const double impulse = h * pair.now.force.norm();
  a.impulse += impulse;
  b.impulse += impulse;
  ++a.active;
  ++b.active;
}

}  // namespace tremolo
