// ContactStep: the end of a step, its energy balance, and the memory of contacts.
#include <algorithm>

#include "runtime/contact/solve/contact_step.h"

namespace tremolo {

using Eigen::Vector3d;
using Eigen::VectorXd;

// A grab's work; for a driven body the work on the motion relative to the frame.
void ContactStep::settle_grips() {
  for (std::size_t i = 0; i < grips_.size(); ++i) {
    Grip& grip = grips_[i];
    const ContactTouch& touch = held_[i];
    const Vector3d way = touch.x1 - touch.x0 - (grip.end - grip.start);
    grip.damped = grip.damping / options_.step * way.squaredNorm();
    const StepMotion& at = motion_of_grip(i);
    const Vector3d mean_force = 0.5 * (at.R0 + at.R1).transpose() * grip.force;
    grip.work = free_ != nullptr ? grip.force.dot(touch.x1 - touch.x0)
                                 : (grip.place.rows * eq_.z.head(model_->modes())).dot(mean_force);
    record_.account.hand_work += grip.work;
    record_.account.hand_damped += grip.damped;
  }
}

void ContactStep::settle_account(const ContactAccount& pairs, double start) {
  const double before = record_.account.energy;
  record_.begin(pairs);
  ContactAccount& account = record_.account;
  for (const Candidate& candidate : touching()) {
    const ContactForce& now = candidate.now;
    start +=
        candidate.start.energy + 0.5 * candidate.law.shear * candidate.memory.slip.squaredNorm();
    account.energy += now.energy;
    account.lost += now.lost;
    account.friction_loss += now.friction_loss;
    account.work += now.force.dot(candidate.touch.x1 - candidate.touch.x0);
    const bool round = candidate.law.radius > 0.0;
    if (round) account.work += now.rub.dot(eq_.motion.turn_in_step().cross(surface_of(candidate)));
    account.penetration = std::max(account.penetration, -now.distance);
    account.slip = std::max(account.slip, held_slip(candidate.law, now));
    bool through = false;
    const double way = contact_passage(gathered_.colliders[candidate.collider], candidate.start,
                                       candidate.end, through);
    account.way = std::max(account.way, way);
    account.passed += through ? 1 : 0;
    if (now.pressure == 0.0) continue;
    const double impulse = options_.step * now.force.norm();
    record_.impulses[candidate.collider] += impulse;
    record_.collider_impulses[candidate.collider] -= options_.step * now.force;
    const Pose& frame = gathered_.colliders[candidate.collider].end;
    record_.contacted.push_back(
        {.vertex = eq_.points().ids[candidate.point],
         .obstacle = candidate.collider,
         .position =
             round ? Vector3d(candidate.touch.x1 + surface_of(candidate)) : candidate.touch.x1,
         .normal = frame.rotation * candidate.held.normal.normalized(),
         .impulse = options_.step * now.force});
    account.impulse += impulse;
    account.impulse_vector += options_.step * now.force;
    ++account.active;
  }
  settle_grips();
  if (free_ == nullptr)
    account.work =
        eq_.pushed.dot(eq_.z.head(model_->modes())) - account.hand_work - account.joint_work;
  account.surplus = start - before;
  account.given = account.work + account.energy - start + account.lost + account.friction_loss;
}

// After a step: remembers the points that ended it within the margin, in order.
void ContactStep::remember() {
  memories_.clear();
  pair_memories_.clear();
  for (const Candidate& candidate : touching()) {
    const ContactForce& now = candidate.now;
    if (!(now.distance < surface().law.margin) || now.released) continue;
    const double length = candidate.held.normal.norm();
    memories_.add({.obstacle = candidate.collider,
                   .point = candidate.point,
                   .begins = candidate.law.begins,
                   .limit = now.limit,
                   .slip = now.slip,
                   .normal = length > 0.0 ? Vector3d(candidate.held.normal / length)
                                          : Vector3d(Vector3d::UnitZ()),
                   .side = candidate.end.side,
                   .depth = candidate.end.side.counts() ? now.distance : 0.0});
  }
  memories_.sort();
}

// The state at the end, with the contact forces that were found: omega1 last and to rounding.
void ContactStep::finish(State& state, StepReport& report, const ContactAccount& pairs,
                         double start) {
  const double h = options_.step;
  const VectorXd& n = damping_.n;
  VectorXd& d = middle_;
  d = eq_.z.head(model_->modes());
  settle_account(pairs, start);
  record_.rounding = work_of_rounding();
  remember();
  if (free_ != nullptr) {
    free_->set_contact(eq_.force, eq_.torque);
    dp_ = S_.cwiseProduct(n.cwiseProduct(d) / h - v0_);
    force_ = G_ - load_->average;
    if (strain_.present()) force_ += rest_ / h;
    free_->evaluate(d, S_, dp_, force_);
    force_ -= eq_.pushed;
  }
  const double defect =
      (2.0 / (h * h)) * d.dot((0.5 * h) * n.cwiseProduct(dp_) + (0.5 * h * h) * force_ +
                              (0.5 * h) * damping_.D.cwiseProduct(d));
  report.dissipated = damping_.D.dot(d.cwiseAbs2()) / h +
                      h * damping_.theta.cwiseProduct(damping_.D).dot(dp_.cwiseAbs2()) + rest_work_;
  state.q = eq_.q1;
  if (load_->coupling == nullptr || !load_->coupling->finish(d, defect, state.p)) {
    state.p += dp_;
    give_back(defect, 0.5 * state.p.squaredNorm(), state.p);
  }
}

void ContactStep::carry(StateStream& stream) {
  stream(record_.account, gathered_.poses.start, gathered_.poses.end, gathered_.ball.centre,
         gathered_.ball.radius, gathered_.ball.deformed);
  stream(gathered_.ball.travel, eq_.q0, eq_.u0);
  stream.sized(record_.impulses);
  stream.sized(record_.collider_impulses);
  stream(record_.held_steps);
  memories_.carry(stream);
  pair_memories_.carry(stream);
}

}  // namespace tremolo
