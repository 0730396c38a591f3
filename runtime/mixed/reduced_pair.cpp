#include "runtime/mixed/reduced_pair.h"

#include <algorithm>
#include <utility>

namespace tremolo {

void ReducedPair::set(const IslandMember& a, const IslandMember& b, double h) {
  sides_[0] = a;
  sides_[1] = b;
  h_ = h;
  count_ = 0;
  joints_.clear();
}

void ReducedPair::take(PairPoint& pair, bool on_first) {
  if (count_ == points_.size()) points_.emplace_back();
  std::swap(points_[count_], pair);
  points_[count_].a = on_first ? 0 : 1;
  points_[count_].b = on_first ? 1 : 0;
  ++count_;
}

void ReducedPair::take(const IslandJoint& joint, bool on_first) {
  joints_.push_back(joint);
  joints_.back().a = on_first ? 0 : 1;
  joints_.back().b = on_first ? 1 : 0;
}

void ReducedPair::give_back(std::size_t a, std::size_t b, std::vector<PairPoint>& points,
                            std::size_t& count) {
  for (PairPoint& pair : used()) {
    if (count == points.size()) points.emplace_back();
    std::swap(points[count], pair);
    const bool on_first = points[count].a == 0;
    points[count].a = on_first ? a : b;
    points[count].b = on_first ? b : a;
    ++count;
  }
}

void ReducedPair::begin() {
  for (PairPoint& pair : used()) begin_pair(pair);
  for (IslandJoint& link : joints_) {
    const Joint& joint = *link.joint;
    begin_joint(link, equations(link.a), equations(link.b));
    const double stiffness = joint.stiffness + 2.0 * joint.damping / h_;
    sides_[link.a].contact->hold_at(joint.first, stiffness);
    sides_[link.b].contact->hold_at(joint.second, stiffness);
  }
}

void ReducedPair::approach(const ContactRenewal& renewal) {
  (void)renewal;
  rate_ = {};
  const StepWay ways[] = {sides_[0].contact->way_in_step(), sides_[1].contact->way_in_step()};
  for (PairPoint& pair : used())
    approach_pair(pair, bodies_of(pair), ways_between(ways[pair.a], ways[pair.b]), rate_);
}

void ReducedPair::press(const ContactRenewal& renewal) {
  for (PairPoint& pair : used()) {
    press_pair(pair, bodies_of(pair), {h_, rate_}, renewal, scratch_);
    if (!pair.now.acts) continue;
    equations(pair.a).push_point(pair.now.force, pair.touch_a, pair.point);
    push_second(pair, equations(pair.b));
    if (!(pair.law.radius > 0.0)) continue;
    const Eigen::Vector3d torque = surface_arm(pair.law, pair.held).cross(pair.now.rub);
    equations(pair.a).push_turn(torque);
    equations(pair.b).push_turn(-torque);
  }
  for (IslandJoint& link : joints_) {
    evaluate_joint(link, equations(link.a), equations(link.b), h_);
    push_first(link, equations(link.a));
    push_second(link, equations(link.b));
  }
}

void ReducedPair::make_slopes(bool follows) {
  PairBlocks& of = blocks_;
  of.clear(equations(0).unknowns(), equations(1).unknowns());
  const PairSides up{of.by_other, of.other_by, of.push, of.growth, of.other_push, of.other_growth};
  const PairSides down{of.other_by,     of.by_other, of.other_push,
                       of.other_growth, of.push,     of.growth};
  for (PairPoint& pair : used())
    if (pair.now.acts)
      add_pair_slopes(pair, bodies_of(pair), {h_, rate_}, follows, scratch_,
                      pair.a == 0 ? up : down);
  if (rate_.force > 0.0) {
    equations(0).own_block().noalias() += of.push.lazyProduct(of.growth.transpose());
    equations(1).own_block().noalias() += of.other_push.lazyProduct(of.other_growth.transpose());
    of.by_other.noalias() += of.push.lazyProduct(of.other_growth.transpose());
    of.other_by.noalias() += of.other_push.lazyProduct(of.growth.transpose());
  }
  for (const IslandJoint& link : joints_) {
    const PairSides& sides = link.a == 0 ? up : down;
    add_joint_slopes(link, equations(link.a), equations(link.b), sides.first_by_second,
                     sides.second_by_first);
  }
}

void ReducedPair::add_growth(StepBody::In first_x, StepBody::In second_x) {
  (void)first_x;
  (void)second_x;  // the rate is in the blocks
}

void ReducedPair::multiply(StepBody::In first_x, StepBody::In second_x, StepBody::Out first_rows,
                           StepBody::Out second_rows) const {
  rows_[0].noalias() = blocks_.by_other * second_x;
  rows_[1].noalias() = blocks_.other_by * first_x;
  first_rows += equations(0).row_scale.head(first_x.size()).cwiseProduct(rows_[0]);
  second_rows += equations(1).row_scale.head(second_x.size()).cwiseProduct(rows_[1]);
}

bool ReducedPair::add_missed() {
  const std::size_t known = count_;
  if (known == 0) return false;
  ContactStep &a = *sides_[0].contact, &b = *sides_[1].contact;
  count_ = add_missed_points(a, b, {0, 1, sides_[1].number}, points_, count_);
  count_ = add_missed_points(b, a, {1, 0, sides_[0].number}, points_, count_);
  return count_ != known;
}

void ReducedPair::settle(ContactAccount& first_account, ContactAccount& second_account,
                         double& first_start, double& second_start) const {
  ContactAccount* const accounts[] = {&first_account, &second_account};
  double* const starts[] = {&first_start, &second_start};
  for (const PairPoint& pair : used()) {
    *starts[pair.a] += pair.energy + 0.5 * pair.law.shear * pair.memory.slip.squaredNorm();
    const Eigen::Vector3d place = pair.near ? pair.place : place_at_end(pair, bodies_of(pair));
    settle_pair(pair, place, equations(pair.b), h_, *accounts[pair.a], *accounts[pair.b]);
  }
  for (const IslandJoint& link : joints_)
    settle_joint(link, equations(link.a), equations(link.b), *accounts[link.a], *accounts[link.b]);
}

void ReducedPair::remember() {
  for (const PairPoint& pair : used())
    remember_pair(pair, *sides_[pair.a].contact, sides_[pair.b].number, h_);
}

std::size_t ReducedPair::acting() const {
  return static_cast<std::size_t>(std::count_if(
      used().begin(), used().end(), [](const PairPoint& pair) { return pair.now.acts; }));
}

}  // namespace tremolo
