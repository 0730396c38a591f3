// MixedGuests: guests that come to rest take no steps until something wakes them.
#include <algorithm>
#include <utility>

#include "runtime/mixed/mixed_guests.h"

namespace tremolo {

bool MixedGuests::has_to_wake(std::size_t i) const {
  const Guest& guest = *guests_[i];
  const StepBall ball = guest.step->ball();
  const double reach = ball.radius + 2.0 * guest.step->area_law().margin;
  return guest.step->is_driven() || guest.step->gravity_to_come() != guest.rest.gravity ||
         load_to_come(i) || moves_near(colliders_, ball.centre, reach) ||
         std::any_of(hands_.begin(), hands_.end(),
                     [i](const Hand& held) { return held.used && held.hand.guest == i; });
}

void MixedGuests::wake(std::size_t i) {
  Guest& guest = *guests_[i];
  if (!std::exchange(guest.rest, {}).asleep || guest.failed) return;
  start(i);
}

bool MixedGuests::note_rest(std::size_t i) {
  Guest& guest = *guests_[i];
  if (guest.failed) return false;
  const GuestStep& step = *guest.step;
  const double slow = step.slow();
  const bool quiet = (step.account().active > 0 || is_joined(i)) &&
                     2.0 * step.kinetic_energy() <= step.mass() * slow * slow && !has_to_wake(i);
  const StepBall ball = step.ball();
  if (quiet)
    guest.rest.time.count(step_, {.centre = ball.centre, .radius = ball.radius}, slow);
  else
    guest.rest.time.restart();
  guest.rest.gravity = step.gravity_to_come();
  return guest.rest.time.is_over();
}

void MixedGuests::fall_asleep(std::size_t i) {
  Guest& guest = *guests_[i];
  const double taken = guest.step->kinetic_energy();
  guest.step->stop();
  guest.sums.lost += taken;
  guest.sums.work -= taken;
  guest.rest.asleep = true;
  guest.started = false;
}

bool MixedGuests::holds_body(std::size_t i) const {
  return std::any_of(joined_.begin(), joined_.end(), [i](const Link& link) {
    return link.used && !link.joint.to_guest && link.joint.other == i;
  });
}

void MixedGuests::wake_all() {
  for (const auto& guest : guests_) guest->rest = {};
}

}  // namespace tremolo
