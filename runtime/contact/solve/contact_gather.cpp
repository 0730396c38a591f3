// ContactStep: finds points that may be in contact in a step and points that were missed, and keeps
// the memory of contacts between steps.
#include <algorithm>
#include <cmath>

#include "runtime/contact/solve/contact_step.h"

namespace tremolo {
namespace {

using Eigen::Index;
using Eigen::Vector3d;
using Eigen::VectorXd;

// Bound of the displacement in the world of a ball's points about `place` between the poses, m.
// radius: m.
double reach_of(const StepPoses& poses, const Vector3d& place, double radius) {
  const double angle = turn_of(poses.start.rotation.conjugate() * poses.end.rotation).norm();
  return (poses.end * place - poses.start * place).norm() + angle * radius;
}

bool is_before(const ContactMemory& x, const ContactMemory& y) {
  return x.obstacle < y.obstacle || (x.obstacle == y.obstacle && x.point < y.point);
}

// memories: sorted by these numbers. Null: there is none.
const ContactMemory* find_memory(const std::vector<ContactMemory>& memories, std::size_t obstacle,
                                 std::size_t point) {
  const ContactMemory wanted{.obstacle = obstacle, .point = point};
  const auto found = std::lower_bound(memories.begin(), memories.end(), wanted, is_before);
  return found != memories.end() && !is_before(wanted, *found) ? &*found : nullptr;
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
    way += eq_.points->reach[k] * (own + half * std::abs((*push.force)[k]));
  }
  return way;
}

bool ContactStep::gather(std::span<const PlacedCollider> colliders, const StepPoses& poses,
                         const VectorXd& q, const VectorXd& v, const StepPush& push) {
  if (!kHasColliders || !feels_) colliders = {};
  colliders_ = colliders;
  poses_ = poses;
  candidates_.clear();
  candidates_.reserve(eq_.points->size() * colliders.size());
  memories_.reserve(eq_.points->size() * colliders.size());
  listed_.resize(eq_.points->size());
  record_.impulses.resize(colliders.size());
  rates_.resize(colliders.size());
  turns_.resize(colliders.size());
  taken_push_.resize(model_->modes() + 6, static_cast<Index>(colliders.size()));
  taken_growth_.resize(taken_push_.rows(), taken_push_.cols());
  record_.collider_impulses.resize(colliders.size());
  record_.contacted.reserve(eq_.points->size() * (colliders.size() + 1));
  eq_.q0 = q;
  if (eq_.shape) eq_.points->displacement(q, eq_.u0);
  // Displacements by the coordinates: so far, and in the step.
  ball_.centre = poses.start * eq_.points->centre;
  ball_.radius = eq_.points->radius;
  ball_.deformed = q.cwiseAbs().dot(eq_.points->reach);
  ball_.travel = options_.step * v.cwiseAbs().dot(eq_.points->reach) +
                 reach_of(poses, eq_.points->centre, ball_.radius + ball_.deformed) +
                 acceleration_reach(q, push);
  for (std::size_t c = 0; c < colliders.size(); ++c) {
    const PlacedCollider& collider = colliders[c];
    const Vector3d centre = ball_.centre;
    const double radius = ball_.radius + ball_.deformed;
    // The collider's own motion near the body.
    const StepPoses its{collider.start, collider.end};
    const Vector3d local = collider.start.rotation.conjugate() * (centre - collider.start.position);
    // Twice, because contact may accelerate a point.
    const double reach = law_.margin + 2.0 * (ball_.travel + reach_of(its, local, radius));
    const double far = signed_distance(collider.shape, local).distance - radius;
    if (far > reach) continue;
    turns_[c] = turns_of(collider);
    add_candidates(collider, c, q, reach);
  }
  held_.resize(grips_.size());
  return !touching().empty() || !grips_.empty();
}

const ContactMemory* ContactStep::pair_memory(std::size_t body, std::size_t point) const {
  return find_memory(pair_memories_, body, point);
}

void ContactStep::sort_pair_memories() {
  std::sort(pair_memories_.begin(), pair_memories_.end(), is_before);
}

// x: position of the point at the start, world, m.
ContactStep::Candidate ContactStep::make_candidate(std::size_t point, std::size_t index,
                                                   const Vector3d& x) const {
  const PlacedCollider& collider = colliders_[index];
  Candidate candidate{.point = point,
                      .collider = index,
                      .law = law_of(point, collider.friction, collider.restitution)};
  candidate.start = contact_start(candidate.law, collider, x);
  const ContactMemory* memory = find_memory(memories_, index, point);
  if (memory != nullptr)
    candidate.memory = *memory;
  else
    candidate.memory.begins = std::min(law_.margin, candidate.start.distance);
  candidate.law.begins = candidate.memory.begins;
  candidate.start.energy = candidate.law.energy(candidate.start.distance);
  return candidate;
}

void ContactStep::add_candidates(const PlacedCollider& collider, std::size_t index,
                                 const VectorXd& q, double reach) {
  const double deformed = q.cwiseAbs().dot(eq_.points->reach);
  const auto distance = [&collider](const Vector3d& x) {
    return signed_distance(collider.shape,
                           collider.start.rotation.conjugate() * (x - collider.start.position))
        .distance;
  };
  for (const PointGroup& group : eq_.points->groups) {
    if (distance(poses_.start * group.centre) > group.radius + deformed + reach) continue;
    for (std::size_t i = group.first; i < group.first + group.count; ++i) {
      if (!eq_.points->meets(i, true)) continue;
      const Vector3d x = poses_.start * eq_.points->place(i, q);
      if (distance(x) - eq_.points->radius_of(i) <= reach)
        candidates_.push_back(make_candidate(i, index, x));
    }
  }
}

// A point farther than the reach of gather() cannot be missed while the body travels no farther
// than predicted there.
bool ContactStep::went_far(const Pose& end, const VectorXd& q) const {
  const double bent = (q - eq_.q0).cwiseAbs().dot(eq_.points->reach);
  return bent + reach_of({poses_.start, end}, eq_.points->centre, ball_.radius + ball_.deformed) >
         2.0 * ball_.travel;
}

Pose ContactStep::end_pose() const {
  if (free_ == nullptr) return poses_.end;
  const Eigen::Quaterniond rotation(eq_.motion.R1);
  return {eq_.motion.c1 - eq_.motion.R1 * eq_.motion.origin, rotation};
}

bool ContactStep::find_missed(const Pose& end, const VectorXd& q) {
  if (!went_far(end, q)) return false;
  const double deformed = q.cwiseAbs().dot(eq_.points->reach);
  const std::size_t known = candidates_.size();
  for (std::size_t c = 0; c < colliders_.size(); ++c) {
    const PlacedCollider& collider = colliders_[c];
    const auto distance = [&collider](const Vector3d& x) {
      return signed_distance(collider.shape,
                             collider.end.rotation.conjugate() * (x - collider.end.position))
          .distance;
    };
    std::fill(listed_.begin(), listed_.end(), 0);
    turns_[c] = turns_of(collider);
    for (std::size_t k = 0; k < known; ++k)
      if (candidates_[k].collider == c) listed_[candidates_[k].point] = 1;
    for (const PointGroup& group : eq_.points->groups) {
      if (distance(end * group.centre) > group.radius + deformed + law_.margin) continue;
      for (std::size_t i = group.first; i < group.first + group.count; ++i)
        if (listed_[i] == 0 && eq_.points->meets(i, true) &&
            distance(end * eq_.points->place(i, q)) - eq_.points->radius_of(i) < law_.margin)
          candidates_.push_back(make_candidate(i, c, poses_.start * eq_.points->place(i, eq_.q0)));
    }
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

// After a step: remembers the points that ended it within the margin, in order.
void ContactStep::remember() {
  memories_.clear();
  pair_memories_.clear();
  for (const Candidate& candidate : touching()) {
    const ContactForce& now = candidate.now;
    if (!(now.distance < law_.margin)) continue;
    const double length = candidate.held.normal.norm();
    memories_.push_back({.obstacle = candidate.collider,
                         .point = candidate.point,
                         .begins = std::max(candidate.law.begins, now.distance),
                         .limit = now.limit,
                         .slip = now.slip,
                         .normal = length > 0.0 ? Vector3d(candidate.held.normal / length)
                                                : Vector3d(Vector3d::UnitZ())});
  }
  std::sort(memories_.begin(), memories_.end(), is_before);
}

}  // namespace tremolo
