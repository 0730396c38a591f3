// ContactStep: finds points that may be in contact in a step, and points that were missed.
#include <algorithm>
#include <cmath>

#include "runtime/contact/solve/contact_step.h"

namespace tremolo {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

// Bound of the displacement in the world of a ball's points about `place` between the poses, m.
// radius: m.
double reach_of(const StepPoses& poses, const Vector3d& place, double radius) {
  const double angle = turn_of(poses.start.rotation.conjugate() * poses.end.rotation).norm();
  return (poses.end * place - poses.start * place).norm() + angle * radius;
}

}  // namespace

// Bound of the displacement of any point in the step by forces, beyond its velocity, m: by applied
// forces and by the coordinates' own forces, which reverse within a period.
double ContactStep::acceleration_reach(const VectorXd& q, const StepPush& push) const {
  const double half = 0.5 * options_.step * options_.step;
  const VectorXd& lambda = model_->lambda();
  double way = half * push.acceleration.norm();
  for (Index k = 0; k < q.size(); ++k) {
    const double own = std::abs(q[k]) * std::min(half * lambda[k], 2.0);
    way += eq_.points().reach[k] * (own + half * std::abs((*push.force)[k]));
  }
  return way;
}

// Bound of the displacement by the frame in the step of the points, which are within `radius` of
// the centre, m. A point on several bones goes no farther than with one of them.
double ContactStep::frame_reach(const StepPoses& poses, double radius) const {
  if (!on_bones()) return reach_of(poses, eq_.points().centre, radius);
  double most = 0.0;
  for (const StepPoses& bone : eq_.bones->poses())
    most = std::max(most, reach_of(bone, eq_.points().centre, radius));
  return most;
}

// Position of a contact point at an end of the step, m, world. pose: of the one frame there.
Vector3d ContactStep::place_of(std::size_t point, const Pose& pose, bool at_end,
                               const VectorXd& q) const {
  const Vector3d y = eq_.points().place(point, q);
  if (!on_bones()) return pose * y;
  const BoneMap& map = at_end ? eq_.bones->maps(point).end : eq_.bones->maps(point).start;
  return map.leftCols<3>() * y + map.col(3);
}

Vector3d ContactStep::start_of_point(std::size_t point) const {
  return place_of(point, gathered_.poses.start, false, eq_.q0);
}

Vector3d ContactStep::into_rest_at_start(const Vector3d& x) const {
  const Pose& pose = gathered_.poses.start;
  return on_bones() ? eq_.bones->into_rest(x, false)
                    : Vector3d(pose.rotation.conjugate() * (x - pose.position));
}

void ContactStep::attach(std::shared_ptr<BonePoints> points) {
  eq_.bones = std::move(points);
  eq_.point_motions.resize(eq_.points().size());
}

void ContactStep::place(const DrivenFrame& frame) {
  eq_.bones->place(frame);
}

bool ContactStep::gather(const ContactNear& near, const StepPoses& poses, const VectorXd& q,
                         const VectorXd& v, const StepPush& push) {
  std::span<const PlacedCollider> colliders;
  if (kHasColliders && surface().feels) colliders = near.colliders;
  const ContactPoints& points = eq_.points();
  ContactBall& ball = gathered_.ball;
  grips_ = near.grips;
  grip_maps_ = near.grip_maps;
  gathered_.colliders = colliders;
  gathered_.poses = poses;
  gathered_.acceleration = push.acceleration;
  candidates_.clear();
  candidates_.reserve(points.size() * colliders.size());
  memories_.reserve(points.size() * colliders.size());
  impacts_.reserve(points.rigid() ? points.size() * colliders.size() : 0);
  listed_.resize(points.size());
  record_.reserve(points.size(), colliders.size());
  rates_.resize(colliders.size());
  turns_.resize(colliders.size());
  taken_push_.resize(model_->modes() + 6, static_cast<Index>(colliders.size()));
  taken_growth_.resize(taken_push_.rows(), taken_push_.cols());
  eq_.q0 = q;
  if (eq_.surface.shape) points.displacement(q, eq_.u0);
  // Displacements by the coordinates: so far, and in the step.
  ball.centre = poses.start * points.centre;
  ball.radius = points.radius;
  // The blend of several positions of a ball is nowhere farther than they are.
  if (on_bones())
    for (const StepPoses& bone : eq_.bones->poses())
      ball.radius =
          std::max(ball.radius, points.radius + (bone.start * points.centre - ball.centre).norm());
  ball.deformed = q.cwiseAbs().dot(points.reach);
  ball.travel = options_.step * v.cwiseAbs().dot(points.reach) +
                frame_reach(poses, ball.radius + ball.deformed) + acceleration_reach(q, push);
  for (std::size_t c = 0; c < colliders.size(); ++c) {
    const PlacedCollider& collider = colliders[c];
    const Vector3d centre = ball.centre;
    const double radius = ball.radius + ball.deformed;
    // The collider's own motion near the body.
    const StepPoses its{collider.start, collider.end};
    const Vector3d local = collider.start.rotation.conjugate() * (centre - collider.start.position);
    // Twice, because contact may accelerate a point.
    const double reach = surface().law.margin + 2.0 * (ball.travel + reach_of(its, local, radius)) +
                         memories_.reach_of_sides(c);
    const double far = signed_distance(collider.shape, local).distance - radius;
    if (far > reach) continue;
    turns_[c] = turns_of(collider);
    add_candidates(collider, c, q, reach);
  }
  held_.resize(grips_.size());
  if (on_bones()) grip_motions_.resize(grips_.size());
  return !touching().empty() || !grips_.empty();
}

// x: position of the point at the start, world, m.
ContactStep::Candidate ContactStep::make_candidate(std::size_t point, std::size_t index,
                                                   const Vector3d& x) const {
  const PlacedCollider& collider = gathered_.colliders[index];
  Candidate candidate{.point = point,
                      .collider = index,
                      .law = law_of(surface(), point, collider.friction, collider.restitution,
                                    distance_rounding(surface(), gathered_.ball))};
  const ContactMemory* memory = memories_.find(index, point);
  candidate.start = contact_start(candidate.law, collider, x,
                                  surface().points->rigid() ? gathered_.ball.centre : x, memory);
  if (memory != nullptr)
    candidate.memory = *memory;
  else
    candidate.memory.begins = kNoLevel;
  return candidate;
}

// Sets B and the energies of the candidates of the collider from number `from` on.
void ContactStep::set_levels(std::size_t collider, std::size_t from) {
  const double margin = surface().law.margin;
  ContactLevel level;
  for (const Candidate& known : candidates_)
    if (known.collider == collider) level.add(known.memory.begins, known.start.distance, margin);
  for (std::size_t k = from; k < candidates_.size(); ++k) {
    Candidate& candidate = candidates_[k];
    if (candidate.collider != collider) continue;
    const double distance = candidate.start.distance;
    candidate.memory.begins = level.of(candidate.memory.begins, distance, margin);
    candidate.law.begins = candidate.memory.begins;
    candidate.start.energy = candidate.law.energy(distance);
  }
}

void ContactStep::add_candidates(const PlacedCollider& collider, std::size_t index,
                                 const VectorXd& q, double reach) {
  const std::size_t known = candidates_.size();
  const double deformed = q.cwiseAbs().dot(eq_.points().reach);
  const Pose& own = gathered_.poses.start;
  const Matrix3d turn = own.rotation.toRotationMatrix();
  const Matrix3d back = collider.start.rotation.toRotationMatrix().transpose();
  const auto into_world = [&](const Vector3d& place) {
    return Vector3d(turn * place + own.position);
  };
  const auto distance = [&](const Vector3d& x) {
    return signed_distance(collider.shape, back * (x - collider.start.position)).distance;
  };
  for (const PointGroup& group : eq_.points().groups) {
    // Groups have balls in one frame.
    if (!on_bones() && distance(into_world(group.centre)) > group.radius + deformed + reach)
      continue;
    for (std::size_t i = group.first; i < group.first + group.count; ++i) {
      if (!eq_.points().meets(i, true)) continue;
      const Vector3d x =
          on_bones() ? place_of(i, own, false, q) : into_world(eq_.points().place(i, q));
      if (distance(x) - eq_.points().radius_of(i) <= reach)
        candidates_.push_back(make_candidate(i, index, x));
    }
  }
  set_levels(index, known);
}

ImpactBody ContactStep::impact_body(const RigidState& rigid) const {
  return {.centre = rigid.centre,
          .velocity = rigid.velocity,
          .spin = rigid.rotation * rigid.spin,
          .acceleration = gathered_.acceleration,
          .mass = surface().mass};
}

void ContactStep::add_impacts(std::size_t number, std::vector<ImpactPoint>& points) const {
  for (const Candidate& candidate : candidates_) {
    const PlacedCollider& collider = gathered_.colliders[candidate.collider];
    const Vector3d x = collider.start * candidate.start.place;
    points.push_back({.a = number,
                      .law = candidate.law,
                      .distance = candidate.start.distance,
                      .energy = candidate.start.energy,
                      .place = x,
                      .normal = collider.start.rotation * candidate.start.normal,
                      .collider = (collider.end * candidate.start.place - x) / options_.step});
  }
}

bool ContactStep::hits_hard(const RigidState& rigid) {
  ImpactBody body = impact_body(rigid);
  impacts_.clear();
  add_impacts(0, impacts_);
  return longest_for_impacts({&body, 1}, impacts_, options_.step, false) < options_.step;
}

// A point farther than the reach of gather() cannot be missed while the body travels no farther
// than predicted there.
bool ContactStep::went_far(const Pose& end, const VectorXd& q) const {
  const double bent = (q - eq_.q0).cwiseAbs().dot(eq_.points().reach);
  return bent + frame_reach({gathered_.poses.start, end},
                            gathered_.ball.radius + gathered_.ball.deformed) >
         2.0 * gathered_.ball.travel;
}

Pose ContactStep::end_pose() const {
  if (free_ == nullptr) return gathered_.poses.end;
  const Eigen::Quaterniond rotation(eq_.motion.R1);
  return {eq_.motion.c1 - eq_.motion.R1 * eq_.motion.origin, rotation};
}

bool ContactStep::find_missed(const Pose& end, const VectorXd& q) {
  if (!went_far(end, q)) return false;
  const double deformed = q.cwiseAbs().dot(eq_.points().reach);
  const std::size_t known = candidates_.size();
  for (std::size_t c = 0; c < gathered_.colliders.size(); ++c) {
    const PlacedCollider& collider = gathered_.colliders[c];
    const auto distance = [&collider](const Vector3d& x) {
      return signed_distance(collider.shape,
                             collider.end.rotation.conjugate() * (x - collider.end.position))
          .distance;
    };
    std::fill(listed_.begin(), listed_.end(), 0);
    turns_[c] = turns_of(collider);
    for (std::size_t k = 0; k < known; ++k)
      if (candidates_[k].collider == c) listed_[candidates_[k].point] = 1;
    for (const PointGroup& group : eq_.points().groups) {
      if (!on_bones() &&
          distance(end * group.centre) > group.radius + deformed + surface().law.margin)
        continue;
      for (std::size_t i = group.first; i < group.first + group.count; ++i)
        if (listed_[i] == 0 && eq_.points().meets(i, true) &&
            distance(place_of(i, end, true, q)) - eq_.points().radius_of(i) < surface().law.margin)
          candidates_.push_back(make_candidate(i, c, start_of_point(i)));
    }
    set_levels(c, known);
  }
  return candidates_.size() != known;
}

bool ContactStep::add_missed() {
  if (!kHasColliders) return false;
  const std::size_t known = candidates_.size();
  if (!find_missed(end_pose(), eq_.q1)) return false;
  for (std::size_t k = known; k < candidates_.size(); ++k) begin_candidate(candidates_[k]);
  return true;
}

// Kept values start from those of the last step.
void ContactStep::begin_candidate(Candidate& candidate) {
  hold_normal(candidate.start.normal, candidate.memory, candidate.held);
  candidate.held.limit = candidate.memory.limit;
  candidate.y0 = eq_.place_in_body(candidate.point, eq_.q0);
}

}  // namespace tremolo
