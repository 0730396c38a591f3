#include "runtime/contact/solve/pair_point.h"

#include <algorithm>
#include <cmath>

#include "runtime/contact/collider.h"
#include "runtime/contact/contact_memories.h"
#include "runtime/math/pose.h"

namespace tremolo {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kSameSlopes = 1e-3;

// Finds the motion of the point's surroundings with the second body, and the rows along its axes.
void find_site(PairPoint& pair, const ContactEquations& second) {
  constexpr double kLeastVolume = 0.05;  // of a slope that is inverted
  if (!pair.site || pair.site.use_count() > 1) pair.site = std::make_shared<BoneSite>();
  BoneSite& site = *pair.site;
  site.motion.h = second.motion.h;
  site.motion.modes = second.modes();
  site.motion.origin.setZero();
  site.motion.follow(second.bones->motion_at(pair.touch_a.x0));
  Eigen::Matrix3d slope;
  second.bones->into_rest(pair.touch_a.x0, false, slope);
  site.at_start = slope.transpose();
  if (!(slope.determinant() > kLeastVolume)) return;
  pair.rows = (pair.rows * (site.motion.R0.transpose() * slope.inverse()).transpose()).eval();
}

// The gradient of the distance by the point's end in the world, from that by the mesh's
// coordinates.
Vector3d gradient_at_end(const PairPoint& pair, const ContactEquations& second) {
  return second.bones ? Vector3d(pair.site->at_slope * pair.slope)
                      : second.motion.turn_out_at_end(pair.slope);
}

void find_start(PairPoint& pair, const ContactEquations& second, PairScratch& scratch) {
  const BentShape shape = second.shape_at_start(pair.side);
  bent_rows(shape, pair.place_at_start, scratch.bent, pair.rows);
  pair.gradient = bent_gradient(shape, pair.place_at_start);
  pair.fresh = false;
  if (second.bones) find_site(pair, second);
}

// The point's path is computed as if the second body did not deform.
bool passes(const PairPoint& pair, const Vector3d& place, const ContactEquations& second) {
  if (pair.now.released)
    return is_through(*second.surface.shape, pair.end_side,
                      bent_rest(second.shape_at_end(), place));
  if (pair.end_side.counts()) return false;
  const double way = (place - pair.place_at_start).norm();
  if (pair.distance <= 0.0 || way <= pair.distance) return false;
  const BentShape start = second.shape_at_start(), end = second.shape_at_end();
  return goes_through(
      *second.surface.shape,
      {pair.place_at_start, pair.distance, bent_gradient(start, pair.place_at_start)},
      {place, bent_distance(end, place), bent_gradient(end, place)});
}

// Fall of the pair's forces with the unknowns of its bodies, by d1, the path and the deformation,
// and its effect on the part that restitution takes from all points of the two.
// first_way: derivative of the point's end with respect to the first body's unknowns.
template <class Way>
void find_changes(PairPoint& pair, const Way& first_way, ContactEquations& second,
                  const ContactTime& time, bool follows, PairScratch& scratch) {
  const Index n = second.unknowns();
  const Index r = second.turns() ? n - 6 : n;
  // Slopes of a nearby position are accurate enough: they change over the distance between points.
  const double near = kSameSlopes * second.points().gap;
  if (!pair.sloped || (pair.place - pair.slope_place).squaredNorm() > near * near) {
    pair.slope =
        bent_change(second.shape_at_end(pair.end_side), pair.place, scratch.bent, pair.by_q);
    pair.slope_place = pair.place;
    pair.sloped = true;
    if (second.bones) {
      second.bones->into_rest(pair.touch_a.x1, true, pair.site->at_slope);
      pair.site->at_slope.transposeInPlace();
    }
  }
  pair.way.apart = near;
  const Vector3d gradient = gradient_at_end(pair, second);
  const Eigen::Matrix3Xd& way =
      second.lever.change_of_way(motion_at(pair, second), pair.touch_b, pair.rows);
  const auto find = [&](const ContactSlope& slope, Eigen::Matrix3Xd& by_a, Eigen::Matrix3Xd& by_b) {
    const Eigen::Matrix3d by_end = slope.by_distance * gradient.transpose() + slope.by_path;
    by_a.noalias() = by_end.lazyProduct(first_way);
    by_b.resize(3, n);
    by_b.leftCols(r).noalias() = slope.by_bend.lazyProduct(way.leftCols(r));
    by_b.leftCols(r).noalias() += slope.by_distance * pair.by_q.transpose();
    if (!second.turns()) return;
    by_b.rightCols<6>().noalias() = -slope.by_path * way.middleCols<6>(r);
    by_b.rightCols<6>().noalias() -=
        slope.by_distance * (gradient.transpose() * second.lever.way().rightCols<6>());
  };
  const ContactSlopes slopes =
      contact_slopes(pair.law, pair.gap, pair.way, time, pair.held, follows);
  find(slopes.point, scratch.change_a, scratch.change_b);
  find(slopes.bend, scratch.bend_change_a, scratch.bend_change_b);
  if (pair.law.radius > 0.0) {
    scratch.rub = slopes.rub;
    scratch.by_roll = slopes.by_roll;
    scratch.gradient = gradient;
  }
  scratch.link = slopes.point.by_taken;
  scratch.bend_link = slopes.bend.by_taken;
  const double growth = slopes.taken_by_distance;
  scratch.growth_a.noalias() = growth * (first_way.transpose() * gradient);
  scratch.growth_b.resize(n);
  scratch.growth_b.head(r) = growth * pair.by_q;
  if (second.turns())
    scratch.growth_b.tail<6>().noalias() =
        -growth * (second.lever.way().rightCols<6>().transpose() * gradient);
}

// The parts that a round point has in addition: the surface's path, and the opposite torques of
// friction on the two bodies, which are rigid.
void add_roll_slopes(const PairPoint& pair, const PairBodies& bodies, const PairScratch& scratch,
                     const PairSides& sides) {
  const auto& [first, second] = bodies;
  const Vector3d arm = surface_arm(pair.law, pair.held);
  const Eigen::Matrix3d lever = cross_matrix(arm);
  const Eigen::Matrix3d by_end =
      scratch.rub.by_path + scratch.rub.by_distance * scratch.gradient.transpose();
  const Eigen::Matrix3Xd turn_a = scratch.by_roll * first.roll_slopes(arm);
  const Eigen::Matrix3Xd turn_b = -scratch.by_roll * second.roll_slopes(arm);
  const Eigen::Matrix3Xd way_b = second.lever.change_of_way(second.motion, pair.touch_b, pair.rows)
                                     .leftCols(second.unknowns());
  const Eigen::Matrix3Xd rub_a = lever * (turn_a + by_end * first.lever.way());
  const Eigen::Matrix3Xd rub_b =
      lever * (turn_b - scratch.rub.by_path * way_b -
               scratch.rub.by_distance * (scratch.gradient.transpose() * second.lever.way()));
  first.lever.add_pushed(turn_a, turn_a, 1.0, first.own_block());
  first.lever.add_pushed(turn_b, turn_b, 1.0, sides.first_by_second);
  second.lever.add_pushed(turn_b, turn_b, -1.0, second.own_block());
  second.lever.add_pushed(turn_a, turn_a, -1.0, sides.second_by_first);
  first.add_turn_slopes(rub_a, first.own_block());
  first.add_turn_slopes(rub_b, sides.first_by_second);
  second.add_turn_slopes(-rub_b, second.own_block());
  second.add_turn_slopes(-rub_a, sides.second_by_first);
  first.add_turn_slopes(lever * scratch.rub.by_taken, sides.first_push);
  second.add_turn_slopes(-(lever * scratch.rub.by_taken), sides.second_push);
  const Vector3d torque = arm.cross(pair.now.rub);
  first.add_turn_geometry(torque);
  second.add_turn_geometry(-torque);
}

// entry_side.h: inward at y, in the second's mesh coordinates.
Vector3d inward_at(const Vector3d& y, const ContactStep& first, const ContactStep& second) {
  if (!first.surface().points->rigid() || !second.surface().points->rigid())
    return Vector3d::Zero();
  const Pose& pose = second.gathered().poses.start;
  const Vector3d middle = first.gathered().ball.centre - pose.position;
  return (pose.rotation.conjugate() * middle - y).normalized();
}

// Makes a point of the first body near the second, at y in the second's mesh coordinates and at
// that distance from it at the start.
void begin_point(PairPoint& pair, const ContactStep& first, const ContactStep& second,
                 const PairNames& names, std::size_t point, const Vector3d& y, double distance) {
  pair.law = law_between(first.surface(), point, second.surface(),
                         distance_rounding(first.surface(), first.gathered().ball) +
                             distance_rounding(second.surface(), second.gathered().ball));
  place_point(pair, names, point, first.pair_memories().find(names.obstacle, point), y, distance,
              inward_at(y, first, second), second.equations().shape_at_start());
}

}  // namespace

void place_point(PairPoint& pair, const PairNames& names, std::size_t point,
                 const ContactMemory* memory, const Vector3d& y, double distance,
                 const Vector3d& inward, const BentShape& shape) {
  pair.a = names.a;
  pair.b = names.b;
  pair.point = point;
  pair.place_at_start = y;
  pair.distance = distance;
  pair.memory = memory != nullptr ? *memory : ContactMemory{};
  if (memory == nullptr) pair.memory.begins = kNoLevel;
  pair.memory.obstacle = names.obstacle;
  pair.memory.point = point;
  pair.side = {};
  pair.inward = inward;
  pair.from.reset();
  if (memory == nullptr && is_at_surface(*shape.shape, distance)) {
    const Vector3d rest = bent_rest(shape, y);
    pair.side = side_on_edge(*shape.shape, rest, signed_distance(*shape.shape, rest), inward);
  } else if (pair.memory.side.counts()) {
    const Vector3d rest = bent_rest(shape, y);
    if (is_behind(*shape.shape, pair.memory.side, rest)) {
      pair.side = pair.memory.side;
      pair.distance = pair.side.at(rest) - pair.law.radius;
    }
  }
}

void set_levels(std::span<PairPoint> points, std::size_t from) {
  if (from == points.size()) return;
  const PairPoint& any = points[from];
  ContactLevel level;
  for (const PairPoint& pair : points)
    if (pair.a == any.a && pair.b == any.b)
      level.add(pair.memory.begins, pair.distance, pair.law.margin);
  for (PairPoint& pair : points.subspan(from)) {
    pair.memory.begins = level.of(pair.memory.begins, pair.distance, pair.law.margin);
    pair.law.begins = pair.memory.begins;
    pair.energy = pair.law.energy(pair.distance);
  }
}

std::size_t add_pair_points(const ContactStep& first, const ContactStep& second,
                            const PairNames& names, std::vector<PairPoint>& points,
                            std::size_t count) {
  const Collider* shape = second.surface().shape_or_null();
  const ContactPoints& on = *first.surface().points;
  if (shape == nullptr || on.yield_to(*second.surface().points, first.surface().shape.has_value()))
    return count;
  const bool rigid = second.surface().points->rigid();
  const double margin = first.surface().law.margin;
  const double reach = margin +
                       2.0 * (first.gathered().ball.travel + second.gathered().ball.travel) +
                       first.pair_memories().reach_of_sides(names.obstacle);
  const double bent = second.gathered().ball.deformed;
  // The place of a group is known in one frame only, and on bones only near the surface.
  const bool frames = !first.on_bones() && !second.on_bones();
  const Pose from = first.gathered().poses.start, into = second.gathered().poses.start;
  const Matrix3d back = into.rotation.toRotationMatrix().transpose();
  const Matrix3d turn = back * from.rotation.toRotationMatrix();
  const Vector3d shift = back * (from.position - into.position);
  const std::size_t known = count;
  for (const PointGroup& group : on.groups) {
    const double far = group.radius + first.gathered().ball.deformed + bent + reach;
    if (frames && signed_distance(*shape, turn * group.centre + shift).distance > far) continue;
    for (std::size_t i = group.first; i < group.first + group.count; ++i) {
      if (!on.meets(i, rigid)) continue;
      const Vector3d x = frames ? Vector3d::Zero() : first.start_of_point(i);
      if (second.on_bones() && !second.may_reach(x, reach + on.radius_of(i))) continue;
      const Vector3d y = frames ? Vector3d(turn * on.place(i, first.equations().q0) + shift)
                                : second.into_rest_at_start(x);
      const double round = on.radius_of(i);
      if (signed_distance(*shape, y).distance - round > reach + bent) continue;
      if (count == points.size()) points.emplace_back();
      PairPoint& pair = points[count];
      const double distance = bent_distance(second.equations().shape_at_start(), y) - round;
      if (distance > reach || !second.agrees(x, y)) continue;
      begin_point(pair, first, second, names, i, y, distance);
      ++count;
    }
  }
  // The points before these are of other pairs.
  set_levels(std::span(points).subspan(known, count - known), 0);
  return count;
}

void begin_pair(PairPoint& pair) {
  pair.now = {};
  pair.held = {};
  pair.held.limit = pair.memory.limit;
  pair.fresh = true;
  pair.sloped = false;
  pair.end_side = pair.side;
}

PairWays ways_between(const StepWay& first, const StepWay& second) {
  return {second.bend, first.path + second.path, second.turn};
}

Vector3d place_at_end(const PairPoint& pair, const PairBodies& bodies) {
  return bodies.second.into_rest_at_end(bodies.first.end_of_point(pair.point));
}

namespace {

bool may_act(const PairPoint& pair) {
  return pair.distance < pair.law.begins || pair.held.limit != 0.0;
}

double stored_by_friction(const PairPoint& pair) {
  return 0.5 * pair.law.shear * pair.memory.slip.squaredNorm();
}

// True if the pair's distance cannot have come within the margin by a change of place of `way`:
// that would need a gradient of 2 or more.
bool stays_away(const PairPoint& pair, double way, double bend) {
  return pair.distance - 2.0 * (way + bend) > pair.law.margin;
}

// The distance of the centre of the point at the end, by the side that counts there.
double distance_at_end(PairPoint& pair, const ContactEquations& second) {
  const BentShape end = second.shape_at_end();
  const Vector3d rest = bent_rest(end, pair.place);
  const CollisionDistance found = signed_distance(*end.shape, rest);
  if (!pair.from) {
    const Vector3d start = bent_rest(second.shape_at_start(), pair.place_at_start);
    pair.from = {start, pair.distance + pair.law.radius,
                 distance_by(*end.shape, pair.side, start).normal};
  }
  const EntrySide side = side_at(*end.shape, pair.side, *pair.from, rest, found, pair.inward,
                                 pair.law.begins + pair.law.radius);
  if (side.counts() != pair.end_side.counts()) pair.sloped = false;
  pair.end_side = side;
  return side.counts() ? side.at(rest) : found.distance;
}

// Computes the distance at the pair's place.
void measure_distance(PairPoint& pair, const ContactEquations& second, double bend,
                      PairRate& rate) {
  const bool acts = may_act(pair);
  pair.near = false;
  if (!acts && stays_away(pair, (pair.place - pair.place_at_start).norm(), bend))
    return pair.now.clear(pair.distance, stored_by_friction(pair));
  const double distance = distance_at_end(pair, second) - pair.law.radius;
  pair.now.clear(distance, stored_by_friction(pair));
  if (!acts && distance >= pair.law.begins) return;
  pair.near = true;
  pair.gap = make_gap(pair.law, pair.distance, pair.energy, distance);
  rate.add(pair.gap.pressure, distance - pair.distance);
}

}  // namespace

void approach_pair(PairPoint& pair, const PairBodies& bodies, const PairWays& ways,
                   PairRate& rate) {
  // The distance from a bent shape may be half the true one.
  const double far = 2.0 * std::max(pair.distance, 0.0) + pair.law.radius;
  if (!may_act(pair) && stays_away(pair, ways.way + ways.turn * far, ways.bend)) {
    pair.near = false;
    return pair.now.clear(pair.distance, stored_by_friction(pair));
  }
  pair.touch_a.x1 = bodies.first.end_of_point(pair.point);
  approach_shape(pair, bodies.second, ways.bend, rate);
}

void approach_shape(PairPoint& pair, const ContactEquations& second, double bend, PairRate& rate) {
  pair.place = second.into_rest_at_end(pair.touch_a.x1);
  measure_distance(pair, second, bend, rate);
}

void press_pair(PairPoint& pair, const PairBodies& bodies, const ContactTime& time,
                const ContactRenewal& renewal, PairScratch& scratch) {
  if (!pair.near) return;
  const Vector3d x1 = pair.touch_a.x1;
  pair.touch_a = bodies.first.touch_at_point(pair.point);
  const Vector3d middle = bodies.first.motion_of(pair.point).middle_of(pair.touch_a);
  const Vector3d turn =
      pair.law.radius > 0.0 ? bodies.first.motion.turn_in_step() : Vector3d(Vector3d::Zero());
  press_shape(pair, bodies.second, {x1, middle, turn}, time, renewal, scratch);
}

namespace {

// The mean gradient of the mesh's coordinates as one of the world, in the middle of the step.
Vector3d normal_in_middle(PairPoint& pair, const ContactEquations& second, const Vector3d& mean) {
  if (!second.bones) return second.motion.turn_out(mean);
  BoneSite& site = *pair.site;
  second.bones->into_rest(pair.touch_a.x1, true, site.at_end);
  site.at_end.transposeInPlace();
  return 0.5 * (site.at_start + site.at_end) * mean;
}

}  // namespace

void push_second(const PairPoint& pair, ContactEquations& second) {
  second.push(motion_at(pair, second), -pair.now.force, -pair.now.bend_force, pair.touch_b,
              pair.rows);
}

void press_shape(PairPoint& pair, const ContactEquations& second, const PairSite& site,
                 const ContactTime& time, const ContactRenewal& renewal, PairScratch& scratch) {
  if (!pair.near) return;
  const Vector3d& x1 = site.end;
  const bool fresh = pair.fresh;
  if (fresh) find_start(pair, second, scratch);
  const StepMotion& at = motion_at(pair, second);
  pair.touch_b = at.touch_by_other(x1, site.middle);
  pair.way.path = x1 - pair.touch_a.x0 - at.way_under(pair.touch_b);
  pair.way.bend = second.bend_under(at, pair.rows);
  if (renewal.normals || fresh) {
    pair.frame = at.halfway();
    ContactMemory memory = pair.memory;
    memory.slip = pair.frame * memory.slip;
    memory.normal = pair.frame * memory.normal;
    const Vector3d end = bent_gradient(second.shape_at_end(pair.end_side), pair.place);
    // Around a thin edge the gradients of both ends may be opposite.
    const bool turned = pair.gradient.dot(end) < 0.0;
    const Vector3d mean = turned ? pair.gradient : Vector3d(0.5 * (pair.gradient + end));
    hold_normal(normal_in_middle(pair, second, mean), memory, pair.held);
  }
  if (pair.law.radius > 0.0) pair.way.turn = site.turn - second.motion.turn_in_step();
  pair.now = contact_force(pair.law, pair.gap, pair.way, time, renewal.limits, pair.held);
  if (!pair.end_side.counts()) return;
  const BentShape shape = second.shape_at_end();
  if (!is_behind(*shape.shape, pair.end_side, bent_rest(shape, pair.place))) pair.now.release();
}

std::size_t add_missed_points(const ContactStep& first, const ContactStep& second,
                              const PairNames& names, std::vector<PairPoint>& points,
                              std::size_t count) {
  const Collider* shape = second.surface().shape_or_null();
  const ContactPoints& on = *first.surface().points;
  if (shape == nullptr || !(first.went_far() || second.went_far()) ||
      on.yield_to(*second.surface().points, first.surface().shape.has_value()))
    return count;
  const bool rigid = second.surface().points->rigid();
  const double margin = first.surface().law.margin, bent = second.gathered().ball.deformed;
  const std::size_t known = count;
  const auto listed = [&](std::size_t point) {
    return std::any_of(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(known),
                       [&](const PairPoint& pair) {
                         return pair.a == names.a && pair.b == names.b && pair.point == point;
                       });
  };
  for (std::size_t i = 0; i < on.size(); ++i) {
    if (!on.meets(i, rigid)) continue;
    const double round = on.radius_of(i);
    const Vector3d end = second.equations().into_rest_at_end(first.equations().end_of_point(i));
    if (signed_distance(*shape, end).distance - round > margin + 2.0 * bent) continue;
    if (bent_distance(second.equations().shape_at_end(), end) - round >= margin || listed(i))
      continue;
    if (count == points.size()) points.emplace_back();
    const Vector3d y = second.into_rest_at_start(first.start_of_point(i));
    PairPoint& pair = points[count++];
    begin_point(pair, first, second, names, i, y,
                bent_distance(second.equations().shape_at_start(), y) - round);
  }
  set_levels(std::span(points).first(count), known);
  for (std::size_t k = known; k < count; ++k) begin_pair(points[k]);
  return count;
}

bool memory_of(const PairPoint& pair, ContactMemory& memory) {
  if (!(pair.now.distance < pair.law.margin) || pair.now.released) return false;
  memory = pair.memory;
  memory.side = pair.end_side;
  memory.depth = pair.end_side.counts() ? pair.now.distance : 0.0;
  memory.begins = pair.law.begins;
  memory.limit = pair.now.limit;
  memory.slip.setZero();
  const double length = pair.held.normal.norm();
  if (!pair.now.acts || !(length > 0.0)) return true;
  memory.slip = pair.frame.transpose() * pair.now.slip;
  memory.normal = pair.frame.transpose() * pair.held.normal / length;
  return true;
}

void PairBlocks::clear(Index first, Index second) {
  by_other.setZero(first, second);
  other_by.setZero(second, first);
  push.setZero(first);
  growth.setZero(first);
  other_push.setZero(second);
  other_growth.setZero(second);
}

void remember_pair(const PairPoint& pair, ContactStep& first, std::size_t obstacle, double h) {
  if (ContactMemory memory; memory_of(pair, memory)) first.pair_memories().add(memory);
  if (!pair.now.acts || pair.now.pressure == 0.0) return;
  first.record().contacted.push_back(
      {.vertex = first.surface().points->ids[pair.point],
       .on_body = true,
       .obstacle = obstacle,
       .position = pair.law.radius > 0.0
                       ? Vector3d(pair.touch_a.x1 + surface_arm(pair.law, pair.held))
                       : pair.touch_a.x1,
       .normal = pair.held.normal.normalized(),
       .impulse = h * pair.now.force});
}

void add_pair_slopes(PairPoint& pair, const PairBodies& bodies, const ContactTime& time,
                     bool follows, PairScratch& scratch, const PairSides& sides) {
  const auto& [first, second] = bodies;
  first.lever.make(first.motion_of(pair.point), pair.touch_a, first.point_rows(pair.point));
  second.lever.make(motion_at(pair, second), pair.touch_b, pair.rows);
  find_changes(pair, first.lever.way(), second, time, follows, scratch);
  first.lever.add_pushed(scratch.change_a, scratch.change_a, 1.0, first.own_block());
  first.lever.add_pushed(scratch.change_b, scratch.change_b, 1.0, sides.first_by_second);
  second.lever.add_pushed(scratch.change_b, scratch.bend_change_b, -1.0, second.own_block());
  second.lever.add_pushed(scratch.change_a, scratch.bend_change_a, -1.0, sides.second_by_first);
  first.lever.add_pushed(scratch.link, scratch.link, 1.0, sides.first_push);
  second.lever.add_pushed(scratch.link, scratch.bend_link, -1.0, sides.second_push);
  sides.first_growth += scratch.growth_a;
  sides.second_growth += scratch.growth_b;
  if (pair.law.radius > 0.0) add_roll_slopes(pair, bodies, scratch, sides);
  first.add_geometry_at_point(pair.now.force, pair.touch_a, pair.point);
  second.add_geometry_of_other(-pair.now.force, -pair.now.bend_force, pair.touch_b, pair.rows);
  // The torque on the second body acts at the first's point.
  if (!second.turns()) return;
  const Index turn = second.unknowns() - 6;
  sides.second_by_first.middleRows<3>(turn).noalias() +=
      second.motion.turn_of_arm(-pair.now.force) * second.motion.R0.transpose() *
      first.lever.path_of_middle(first.motion).leftCols(first.unknowns());
}

void SiteSlopes::clear(Index unknowns) {
  by_end.setZero();
  by_shape.setZero(3, unknowns);
  shape_by.setZero(unknowns, 3);
  link.setZero();
  growth.setZero();
  shape_link.setZero(unknowns);
  shape_growth.setZero(unknowns);
}

void add_site_slopes(PairPoint& pair, ContactEquations& second, const ContactTime& time,
                     bool follows, PairScratch& scratch, SiteSlopes& slopes) {
  const Index n = second.unknowns();
  slopes.clear(n);
  second.lever.make(motion_at(pair, second), pair.touch_b, pair.rows);
  find_changes(pair, Eigen::Matrix3d(Eigen::Matrix3d::Identity()), second, time, follows, scratch);
  slopes.by_end = scratch.change_a;
  slopes.by_shape = scratch.change_b;
  slopes.link = scratch.link;
  slopes.growth = scratch.growth_a;
  slopes.shape_growth = scratch.growth_b;
  second.lever.add_pushed(scratch.change_b, scratch.bend_change_b, -1.0, second.own_block());
  second.lever.add_pushed(scratch.change_a, scratch.bend_change_a, -1.0, slopes.shape_by);
  second.lever.add_pushed(scratch.link, scratch.bend_link, -1.0, slopes.shape_link);
  second.add_geometry_of_other(-pair.now.force, -pair.now.bend_force, pair.touch_b, pair.rows);
  if (second.turns())
    slopes.shape_by.middleRows<3>(n - 6) +=
        0.5 * second.motion.turn_of_arm(-pair.now.force) * second.motion.R0.transpose();
}

ImpactPoint impact_point(const PairPoint& pair, const ContactStep& second) {
  const Pose& pose = second.gathered().poses.start;
  const Vector3d normal =
      distance_by(*second.surface().shape, pair.side, pair.place_at_start).normal;
  return {.a = pair.a,
          .b = pair.b,
          .law = pair.law,
          .distance = pair.distance,
          .energy = pair.energy,
          .place = pose * pair.place_at_start,
          .normal = (pose.rotation * normal).normalized()};
}

void settle_pair(const PairPoint& pair, const Vector3d& place, const ContactEquations& second,
                 double h, ContactAccount& a, ContactAccount& b) {
  a.way = std::max(a.way, (place - pair.place_at_start).norm());
  if (passes(pair, place, second)) ++a.passed;
  a.energy += pair.now.energy;
  a.lost += pair.now.lost;
  a.friction_loss += pair.now.friction_loss;
  a.penetration = std::max(a.penetration, -pair.now.distance);
  if (!pair.now.acts) return;
  a.work += pair.now.force.dot(pair.touch_a.x1 - pair.touch_a.x0);
  if (pair.law.radius > 0.0) {
    const Vector3d torque = surface_arm(pair.law, pair.held).cross(pair.now.rub);
    const Vector3d turn_b = second.motion.turn_in_step();
    a.work += torque.dot(pair.way.turn + turn_b);
    b.work -= torque.dot(turn_b);
  }
  b.work -= pair.now.force.dot(pair.touch_a.x1 - pair.touch_a.x0 - pair.way.path) +
            pair.now.bend_force.dot(pair.way.bend);
  const double impulse = h * pair.now.force.norm();
  for (ContactAccount* account : {&a, &b})
    account->slip = std::max(account->slip, held_slip(pair.law, pair.now));
  a.impulse_vector += h * pair.now.force;
  b.impulse_vector -= h * pair.now.force;
  a.impulse += impulse;
  b.impulse += impulse;
  ++a.active;
  ++b.active;
}

}  // namespace tremolo
