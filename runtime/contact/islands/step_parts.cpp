#include "runtime/contact/islands/step_parts.h"

#include <algorithm>
#include <cmath>

#include "common/state_stream.h"
#include "runtime/contact/solve/contact_step.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

// Halvings of a step whose solve failed, and of one with an impact, which has at most so many parts
// for its impacts.
constexpr int kMostCuts = 5;
constexpr int kMostForImpact = 10;
constexpr int kMostParts = 200;

}  // namespace

bool ImpactSearch::divides(std::span<const IslandMember> members, std::span<const PairPoint> points,
                           double h, bool inside) {
  bodies_.assign(members.size(), {});
  points_.clear();
  const auto rigid = [&](std::size_t m) {
    return members[m].free != nullptr && members[m].contact->surface().points->rigid();
  };
  for (std::size_t m = 0; m < members.size(); ++m) {
    if (!rigid(m)) continue;
    bodies_[m] = members[m].contact->impact_body(members[m].free->rigid());
    members[m].contact->add_impacts(m, points_);
  }
  for (const PairPoint& pair : points)
    if (rigid(pair.a) && rigid(pair.b))
      points_.push_back(impact_point(pair, *members[pair.b].contact));
  return longest_for_impacts(bodies_, points_, h, inside) < h;
}

bool StepParts::step(const PartIsland& island, double h, std::span<StepReport> reports,
                     PartReason reason) {
  reason_ = reason;
  made_ = 0;
  of_ = island;
  step_ = h;
  reports_ = reports;
  touched_.clear();
  wholes_.resize(of_.bodies.size());
  part_reports_.resize(of_.bodies.size());
  for (std::size_t i = 0; i < of_.bodies.size(); ++i) keep(i);
  joints_before_.clear();
  for (const IslandJoint& joint : of_.joints) joints_before_.push_back(*joint.joint);
  joint_forces_.assign(of_.joints.size(), Eigen::Vector3d::Zero());
  if (of_.guests != nullptr) of_.guests->start_parts();
  const bool made = reason == PartReason::kImpact ? part(0.0, 1.0, 0) : halves(0.0, 1.0, 1);
  for (std::size_t i = 0; i < of_.bodies.size(); ++i) finish(i, made);
  if (of_.guests != nullptr) of_.guests->end_parts(made);
  if (!made) put_back();
  for (std::size_t k = 0; made && k < of_.joints.size(); ++k)
    of_.joints[k].joint->force = joint_forces_[k];
  return made;
}

// Stores a body before the first part.
void StepParts::keep(std::size_t i) {
  ContactBody& body = *of_.bodies[i].body;
  Whole& whole = wholes_[i];
  whole.bytes = state_bytes(body);
  whole.load = body.step_load_;
  whole.q_before = body.q_before_;
  whole.from.clear();
  whole.to.clear();
  whole.sums.assign(body.grips_.size(), Grip{});
  for (const Grip& grip : body.grips_) {
    whole.from.push_back(grip.start);
    whole.to.push_back(grip.end);
  }
  whole.record = {};
  if (body.driven_) body.driven_->start_parts();
  reports_[i].parts = 0;
  reports_[i].dissipated = 0.0;
}

// Gives a body the step's length and load again and, after a step that was made, its sums.
void StepParts::finish(std::size_t i, bool made) {
  ContactBody& body = *of_.bodies[i].body;
  const Whole& whole = wholes_[i];
  body.options_.step = step_;
  body.contact_->set_options(body.options_);
  body.step_load_ = whole.load;
  body.q_before_ = whole.q_before;
  if (body.driven_) body.driven_->end_parts();
  reports_[i].converged = made;
  if (!made) return;
  body.contact_->record() = whole.record;
  for (std::size_t k = 0; k < whole.sums.size(); ++k) {
    body.grips_[k].force = whole.sums[k].force;
    body.grips_[k].work = whole.sums[k].work;
    body.grips_[k].damped = whole.sums[k].damped;
  }
}

void StepParts::put_back() {
  for (std::size_t i = 0; i < of_.bodies.size(); ++i) {
    ContactBody& body = *of_.bodies[i].body;
    (void)restore_state(body, wholes_[i].bytes);
    for (std::size_t k = 0; k < body.grips_.size(); ++k) body.grips_[k].end = wholes_[i].to[k];
  }
  for (std::size_t k = 0; k < of_.joints.size(); ++k) *of_.joints[k].joint = joints_before_[k];
}

// Takes [from, to] in two parts, which are the result of `depth` halvings.
bool StepParts::halves(double from, double to, int depth) {
  const double middle = 0.5 * (from + to);
  return part(from, middle, depth) && part(middle, to, depth);
}

// Takes [from, to] as a step of its own, or in two parts.
bool StepParts::part(double from, double to, int depth) {
  const bool last = depth >= (reason_ == PartReason::kImpact ? kMostForImpact : kMostCuts);
  begin_part(from, to);
  if (last || !hits_hard(step_ * (to - from))) {
    if (take_part(from, to, last)) return true;
    if (last) return false;
  }
  return halves(from, to, depth + 1);
}

bool StepParts::hits_hard(double h) {
  return reason_ == PartReason::kImpact && made_ < kMostParts &&
         impacts_.divides(members_, std::span(points_).first(used_), h, true);
}

// Prepares the bodies for the part [from, to].
void StepParts::begin_part(double from, double to) {
  colliders_.assign(of_.colliders.begin(), of_.colliders.end());
  for (PlacedCollider& collider : colliders_) {
    const Pose start = collider.start, end = collider.end;
    collider.start = pose_between(start, end, from);
    collider.end = pose_between(start, end, to);
  }
  members_.clear();
  for (std::size_t i = 0; i < of_.bodies.size(); ++i) {
    begin(i, from, to);
    ContactBody& body = *of_.bodies[i].body;
    members_.push_back({body.contact_.get(), &body.state_, &body.step_load_, body.free_.get(),
                        of_.bodies[i].number});
  }
  find_points();
  part_joints_.assign(of_.joints.begin(), of_.joints.end());
}

// last: the part is not divided again.
bool StepParts::take_part(double from, double to, bool last) {
  const bool made = solve_part(from, to, last);
  for (std::size_t i = 0; i < of_.bodies.size(); ++i) {
    reports_[i].iterations += part_reports_[i].iterations;
    reports_[i].residual = part_reports_[i].residual;
    if (made) book(i, part_reports_[i], to - from);
  }
  if (!made) return false;
  ++made_;
  for (std::size_t k = 0; k < of_.joints.size(); ++k)
    joint_forces_[k] += (to - from) * of_.joints[k].joint->force;
  for (std::size_t k = 0; k < used_; ++k) {
    touched_.push_back(points_[k]);
    touched_.back().now.force *= to - from;
  }
  return true;
}

bool StepParts::solve_part(double from, double to, bool last) {
  if (of_.guests != nullptr)
    return of_.guests->step_part({from, to, colliders_},
                                 {members_, points_, used_, part_joints_, part_reports_});
  island_.step(members_, points_, used_, part_joints_, step_ * (to - from), last, part_reports_);
  return part_reports_.front().converged;
}

void StepParts::begin(std::size_t i, double from, double to) {
  ContactBody& body = *of_.bodies[i].body;
  const Whole& whole = wholes_[i];
  body.options_.step = step_ * (to - from);
  body.contact_->set_options(body.options_);
  restrict_load(whole.load, from, to, body.step_load_);
  if (body.free_) body.free_->prepare_again();
  if (body.driven_) body.driven_->take_part(from, to);
  body.q_before_ = body.state_.q;
  for (std::size_t k = 0; k < body.grips_.size(); ++k)
    body.grips_[k].end = whole.from[k] + to * (whole.to[k] - whole.from[k]);
  (void)body.near_something(colliders_);
}

void StepParts::find_points() {
  used_ = 0;
  for (const PartPair& pair : of_.pairs) {
    const ContactStep& first = *members_[pair.a].contact;
    const ContactStep& second = *members_[pair.b].contact;
    const PairNames forth{pair.a, pair.b, of_.bodies[pair.b].number};
    const PairNames back{pair.b, pair.a, of_.bodies[pair.a].number};
    used_ = add_pair_points(first, second, forth, points_, used_);
    used_ = add_pair_points(second, first, back, points_, used_);
  }
}

// Adds a part that succeeded to the sums. share: fraction of the step.
void StepParts::book(std::size_t i, const StepReport& report, double share) {
  ContactBody& body = *of_.bodies[i].body;
  wholes_[i].record.add_part(body.contact_->record());
  for (std::size_t k = 0; k < body.grips_.size(); ++k) {
    Grip& sum = wholes_[i].sums[k];
    sum.force += share * body.grips_[k].force;
    sum.work += body.grips_[k].work;
    sum.damped += body.grips_[k].damped;
  }
  body.end_contact();
  body.book_step(report);
  reports_[i].dissipated += report.dissipated;
  ++reports_[i].parts;
}

}  // namespace tremolo
