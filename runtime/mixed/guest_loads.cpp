// MixedGuests: loads in time on guests.
#include <algorithm>
#include <cmath>

#include "runtime/mixed/mixed_guests.h"

namespace tremolo {
namespace {

using Eigen::Vector3d;

Error bad_load(const std::string& name, const std::string& what) {
  return usage_error("body '" + name + "': " + what);
}

}  // namespace

Status MixedGuests::check_load(const GuestLoad& load) const {
  const GuestStep& step = *guests_[load.guest]->step;
  const std::string& of = guests_[load.guest]->name;
  bool any = false;
  for (const PointPush& push : load.pushes) {
    if (push.point >= step.points())
      return bad_load(of, "there is no point " + std::to_string(push.point));
    if (!push.force.allFinite()) return bad_load(of, "the force is not finite");
    any = any || !step.is_fixed(push.point);
  }
  return any ? Status(Success{})
             : bad_load(of, "a load needs a point that moves: here they are fixed");
}

Status MixedGuests::add_load(GuestLoad load) {
  if (Status s = check_load(load); !s) return s;
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
  if (Status s = check_load(load); !s) return s;
  const auto free =
      std::find_if(applied_.begin(), applied_.end(), [](const Loaded& one) { return !one.used; });
  if (free == applied_.end())
    applied_.push_back({true, std::move(load), {}});
  else
    *free = {true, std::move(load), {}};
  return Success{};
}

bool MixedGuests::has_load(std::size_t i) const {
  const auto is_on = [i](const Loaded& loaded) { return loaded.used && loaded.load.guest == i; };
  return std::any_of(loads_.begin(), loads_.end(), is_on) ||
         std::any_of(applied_.begin(), applied_.end(), is_on);
}

// Of the load in the present part of the step, dimensionless.
double MixedGuests::average_of(const GuestLoad& load) const {
  if (load.steps > 0) return 1.0;
  const Guest& guest = *guests_[load.guest];
  const std::int64_t steps =
      guest.tets != nullptr ? guest.tets->body().steps() : guest.cloth->body().steps();
  const double begins = (static_cast<double>(steps) + from_) * step_;
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
  const double mass = of.tets != nullptr ? of.tets->body().model().mass() : of.cloth->body().mass();
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
  of.step->set_load(sum);
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
