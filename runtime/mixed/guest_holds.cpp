// MixedGuests: hands that hold guests, joints between guests and other bodies, loads in time.
#include <algorithm>
#include <cmath>

#include "common/overflow.h"
#include "common/text.h"
#include "runtime/mixed/mixed_guests.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

Error refused(const std::string& name, const std::string& what) {
  return usage_error("body '" + name + "': " + what);
}

}  // namespace

Result<std::size_t> MixedGuests::hold(std::size_t i, std::size_t point, const HandSpring& spring) {
  const GuestStep& step = *guests_[i]->step;
  const std::string& of = guests_[i]->name;
  if (point >= step.points()) return refused(of, "there is no point " + std::to_string(point));
  if (step.is_fixed(point)) return refused(of, "point " + std::to_string(point) + " is fixed");
  for (const double value : {spring.stiffness, spring.damping})
    if (!(value >= 0.0) || !std::isfinite(value))
      return refused(of, "the stiffness and the damping of a hand must be finite and not negative");
  const Vector3d place = step.start_of(point);
  const auto free =
      std::find_if(hands_.begin(), hands_.end(), [](const Hand& one) { return !one.used; });
  const auto number = static_cast<std::size_t>(free - hands_.begin());
  if (free == hands_.end()) hands_.emplace_back();
  hands_[number].used = true;
  hands_[number].hand = {i, point, spring.stiffness, spring.damping, place, place};
  return number;
}

Status MixedGuests::move_hand(std::size_t hand, const Vector3d& place) {
  if (hand >= hands_.size() || !hands_[hand].used)
    return usage_error("there is no hand " + std::to_string(hand));
  if (!place.allFinite()) return usage_error("the hand's place is not finite");
  if (const double far = place.lpNorm<Eigen::Infinity>(); overflows(far))
    return usage_error(overflow_text("the hand's place", far, "m"));
  hands_[hand].hand.end = place;
  return Success{};
}

void MixedGuests::let_go(std::size_t hand) {
  if (hand < hands_.size()) hands_[hand].used = false;
}

const GuestHand* MixedGuests::hand(std::size_t hand) const {
  return hand < hands_.size() && hands_[hand].used ? &hands_[hand].hand : nullptr;
}

Vector3d MixedGuests::hands_force(std::size_t i) const {
  Vector3d sum = Vector3d::Zero();
  for (const Hand& held : hands_)
    if (held.used && held.hand.guest == i) sum += held.hand.force;
  return sum;
}

bool MixedGuests::is_pushed(std::size_t i) const {
  const ContactAccount& account = guests_[i]->step->account();
  return has_load(i) || account.load_work != 0.0 || account.active > 0 ||
         account.hand_work != 0.0 || account.joint_work != 0.0 ||
         std::any_of(hands_.begin(), hands_.end(),
                     [i](const Hand& held) { return held.used && held.hand.guest == i; }) ||
         is_joined(i);
}

bool MixedGuests::is_joined(std::size_t i) const {
  return std::any_of(joined_.begin(), joined_.end(), [i](const Link& link) {
    return link.used && (link.joint.guest == i || (link.joint.to_guest && link.joint.other == i));
  });
}

std::size_t MixedGuests::join(GuestJoint joint) {
  Link& link = joined_.emplace_back();
  link.used = true;
  link.joint = std::move(joint);
  return joined_.size() - 1;
}

void MixedGuests::separate(std::size_t joint) {
  if (joint < joined_.size()) joined_[joint].used = false;
}

const GuestJoint* MixedGuests::joint(std::size_t joint) const {
  return joint < joined_.size() && joined_[joint].used ? &joined_[joint].joint : nullptr;
}

Result<std::size_t> MixedGuests::point_of_vertex(std::size_t i, VertexId vertex) const {
  const std::string number = std::to_string(vertex);
  if (const ClothStep* cloth = this->cloth(i)) {
    const ClothParts& parts = cloth->body().model().parts();
    if (vertex < 0 || static_cast<std::size_t>(vertex) >= parts.vertices())
      return content_error("there is no particle " + number + ": it has " +
                           std::to_string(parts.vertices()) + ", counted from 0");
    return parts.particle_of_vertex(static_cast<std::size_t>(vertex));
  }
  const TetStep& tets = *this->tets(i);
  const std::size_t vertices = tets.body().model().vertices();
  if (vertex < 0 || static_cast<std::size_t>(vertex) >= vertices)
    return content_error("there is no vertex " + number + ": it has " + std::to_string(vertices) +
                         ", counted from 0");
  if (const std::optional<std::size_t> point = tets.point_of(vertex)) return *point;
  return content_error("vertex " + number +
                       " is inside: a body of tetrahedra is held and loaded at its surface");
}

bool MixedGuests::load_to_come(std::size_t guest) const {
  const auto is_on = [guest](const Loaded& loaded) {
    return loaded.used && loaded.load.guest == guest;
  };
  // As sample_signal does, an end within 1e-9 of a step from now counts as now.
  const double now = (static_cast<double>(steps_of(guest)) + 1e-9) * step_;
  return std::any_of(applied_.begin(), applied_.end(), is_on) ||
         std::any_of(loads_.begin(), loads_.end(), [&](const Loaded& loaded) {
           return is_on(loaded) && signal_end(loaded.load.signal) > now;
         });
}

// Other forces hold a point, so that its hands and joints move it by little more than the margin.
double MixedGuests::pull_of(std::size_t guest) const {
  const GuestStep& step = *guests_[guest]->step;
  const double most = step.area_law().margin;
  double way = 0.0;
  for (const Hand& held : hands_)
    if (held.used && held.hand.guest == guest)
      way += std::min(most, (held.hand.end - step.start_of(held.hand.point)).norm());
  for (const Link& link : joined_) {
    const GuestJoint& joint = link.joint;
    if (link.used && !joint.further &&
        (joint.guest == guest || (joint.to_guest && joint.other == guest)))
      way += most;
  }
  return way;
}

void MixedGuests::meet_hands(std::size_t guest) {
  for (Hand& held : hands_) {
    if (!held.used || held.hand.guest != guest) continue;
    held.pull.set(*guests_[guest]->step, held.hand, from_, to_, step_);
    met_.push_back({bodies_ + guest, PairForces::kNobody, &held.pull});
  }
}

// A joint belongs to the guest that has its point; a part of a step has both bodies or none.
void MixedGuests::meet_joints(std::size_t guest) {
  for (Link& link : joined_) {
    const GuestJoint& joint = link.joint;
    if (!link.used || joint.guest != guest) continue;
    if (joint.to_guest && guests_[joint.other]->failed) continue;
    if (asleep(guest) && (joint.to_guest ? asleep(joint.other) : awake_[joint.other] == 0))
      continue;
    link.pull.set(joint, link.joint.joint, *guests_[guest]->step,
                  joint.to_guest ? guests_[joint.other]->step.get() : nullptr,
                  joint.to_guest ? nullptr : &reduced_[joint.other], from_, to_, step_);
    const std::size_t other = joint.to_guest ? bodies_ + joint.other : joint.other;
    met_.push_back({bodies_ + guest, other, &link.pull});
    links_.emplace_back(bodies_ + guest, other);
  }
}

// False: a joint between the two lets them pass through each other, or the filter does.
bool MixedGuests::may_touch(std::size_t guest, bool to_guest, std::size_t other) const {
  if (filter_ && !filter_(kFirstGuest + guest, to_guest ? kFirstGuest + other : other))
    return false;
  return std::none_of(joined_.begin(), joined_.end(), [&](const Link& link) {
    const GuestJoint& joint = link.joint;
    if (!link.used || joint.joint.touch || joint.to_guest != to_guest) return false;
    return (joint.guest == guest && joint.other == other) ||
           (to_guest && joint.guest == other && joint.other == guest);
  });
}

// Joints are those of the world, which has them already, whether they hold or not; hands are those
// that were saved.
void MixedGuests::carry_links(StateStream& stream) {
  stream.sized(hands_);
  if (stream.reads())
    for (const Hand& held : hands_) {
      const GuestHand& hand = held.hand;
      stream.require(!held.used ||
                     (hand.guest < guests_.size() &&
                      hand.point < guests_[hand.guest]->step->points() && hand.stiffness >= 0.0 &&
                      hand.damping >= 0.0 && std::isfinite(hand.stiffness + hand.damping) &&
                      hand.start.allFinite() && hand.end.allFinite() && hand.force.allFinite()));
    }
  for (Link& link : joined_) stream(link.used, link.joint.joint);
}

// of_fixed: the kind of the error for a load on fixed points alone.
Status MixedGuests::check_load(const GuestLoad& load, ErrorKind of_fixed) const {
  const GuestStep& step = *guests_[load.guest]->step;
  const std::string& of = guests_[load.guest]->name;
  bool any = false;
  for (const PointPush& push : load.pushes) {
    if (push.point >= step.points())
      return refused(of, "there is no point " + std::to_string(push.point));
    if (!push.force.allFinite()) return refused(of, "the force is not finite");
    if (step.is_fixed(push.point)) continue;
    any = true;
    if (!std::isfinite((push.force / step.mass_at(push.point)).squaredNorm()))
      return refused(of, "the force of " + number_text(push.force.lpNorm<Eigen::Infinity>()) +
                             " N is so large that numbers overflow: make it smaller");
  }
  if (any) return Success{};
  return Error{of_fixed,
               refused(of, "the force acts on fixed points alone, which do not move").message};
}

Status MixedGuests::add_load(GuestLoad load) {
  if (Status s = check_load(load, ErrorKind::kContent); !s) return s;
  load.steps = 0;
  load.signal.table = load.table.get();
  loads_.push_back({true, std::move(load), {}});
  return Success{};
}

Status MixedGuests::apply_force(std::size_t i, std::size_t point, const Vector3d& force,
                                int steps) {
  if (steps < 1)
    return usage_error("a force acts for at least one step, got " + std::to_string(steps));
  GuestLoad load{.guest = i, .pushes = {{point, force}}, .signal = {}, .steps = steps};
  if (Status s = check_load(load, ErrorKind::kUsage); !s) return s;
  const auto free =
      std::find_if(applied_.begin(), applied_.end(), [](const Loaded& one) { return !one.used; });
  if (free == applied_.end())
    applied_.push_back({true, std::move(load), {}});
  else
    *free = {true, std::move(load), {}};
  return Success{};
}

Status MixedGuests::settle(std::size_t i) {
  GuestStep& step = *guests_[i]->step;
  Eigen::VectorXd forces = Eigen::VectorXd::Zero(row_of(step.points()));
  for (const Loaded& loaded : loads_) {
    if (!loaded.used || loaded.load.guest != i) continue;
    const double now = sample_signal(loaded.load.signal, 0.0, step_).start;
    for (const PointPush& push : loaded.load.pushes)
      forces.segment<3>(row_of(push.point)) += now * push.force;
  }
  if (const Status s = step.settle(forces); !s)
    return Error{s.error().kind, "body '" + guests_[i]->name + "': " + s.error().message};
  return Success{};
}

bool MixedGuests::has_load(std::size_t i) const {
  const auto is_on = [i](const Loaded& loaded) { return loaded.used && loaded.load.guest == i; };
  return std::any_of(loads_.begin(), loads_.end(), is_on) ||
         std::any_of(applied_.begin(), applied_.end(), is_on);
}

std::int64_t MixedGuests::steps_of(std::size_t guest) const {
  const Guest& of = *guests_[guest];
  return of.tets != nullptr ? of.tets->body().steps() : of.cloth->body().steps();
}

// Of the load in the present part of the step, dimensionless.
double MixedGuests::average_of(const GuestLoad& load) const {
  if (load.steps > 0) return 1.0;
  const double begins = (static_cast<double>(steps_of(load.guest)) + from_) * step_;
  return sample_signal(load.signal, begins, (to_ - from_) * step_).average;
}

template <class Visit>
void MixedGuests::for_loads_of(std::size_t guest, const Visit& visit) {
  for (std::vector<Loaded>* list : {&loads_, &applied_})
    for (Loaded& loaded : *list) {
      if (!loaded.used || loaded.load.guest != guest) continue;
      if (const double average = average_of(loaded.load); average != 0.0) visit(loaded, average);
    }
}

void MixedGuests::meet_loads(std::size_t guest) {
  for_loads_of(guest, [&](Loaded& loaded, double average) {
    loaded.push.set(*guests_[guest]->step, loaded.load, average);
    met_.push_back({bodies_ + guest, PairForces::kNobody, &loaded.push});
  });
}

// The body as a whole moves by h^2 F/M. Other forces hold a single point, so that its load moves it
// by little more than the margin.
void MixedGuests::prepare_loads(std::size_t guest) {
  const Guest& of = *guests_[guest];
  const double mass = of.step->mass();
  Vector3d sum = Vector3d::Zero();
  double most = 0.0;
  for_loads_of(guest, [&](const Loaded& loaded, double average) {
    for (const PointPush& push : loaded.load.pushes) {
      sum += average * push.force;
      if (!of.step->is_fixed(push.point))
        most = std::max(most, std::abs(average) * push.force.norm() / of.step->mass_at(push.point));
    }
  });
  const double square = step_ * step_;
  of.step->set_pull(pull_of(guest) + square * sum.norm() / mass +
                    std::min(of.step->area_law().margin, square * most));
}

// Counts a step that the guest has taken.
void MixedGuests::age_forces(std::size_t guest) {
  for (Loaded& loaded : applied_)
    if (loaded.used && loaded.load.guest == guest && --loaded.load.steps == 0) loaded.used = false;
}

void MixedGuests::forget_loads(std::size_t guest) {
  const auto is_on = [guest](const Loaded& loaded) { return loaded.load.guest == guest; };
  std::erase_if(loads_, is_on);
  std::erase_if(applied_, is_on);
}

// Loads in time are those of the world, which has them already.
void MixedGuests::carry_loads(StateStream& stream) {
  stream.sized(applied_);
  if (!stream.reads()) return;
  for (const Loaded& loaded : applied_) {
    const GuestLoad& load = loaded.load;
    stream.require(!loaded.used || (load.guest < guests_.size() && !guests_[load.guest]->removed &&
                                    load.steps > 0));
    if (!loaded.used || !stream.good()) continue;
    for (const PointPush& push : load.pushes)
      stream.require(push.point < guests_[load.guest]->step->points() && push.force.allFinite());
  }
}

}  // namespace tremolo
