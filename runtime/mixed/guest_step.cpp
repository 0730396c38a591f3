#include "runtime/mixed/guest_step.h"

#include <algorithm>
#include <cmath>

#include "runtime/contact/contact_memories.h"

namespace tremolo {

static void carry(StateStream& stream, ContactedPoint& point) {
  stream(point.vertex, point.on_body, point.obstacle, point.position, point.normal, point.impulse);
}

std::optional<QuickFactor> make_guest_factor(const BlockPatternPointer& pattern) {
  constexpr std::size_t kMostBytes = std::size_t{1} << 30;
  Result<QuickFactor> made = QuickFactor::create(pattern, kMostBytes);
  if (!made) return std::nullopt;
  return std::move(*made);
}
namespace {

bool is_before(const ContactMemory& x, const ContactMemory& y) {
  return x.obstacle < y.obstacle || (x.obstacle == y.obstacle && x.point < y.point);
}

}  // namespace

const ContactMemory* GuestStep::memory(std::size_t obstacle, std::size_t point) const {
  const ContactMemory wanted{.obstacle = obstacle, .point = point};
  const auto found = std::lower_bound(memories_.begin(), memories_.end(), wanted, is_before);
  return found != memories_.end() && !is_before(wanted, *found) ? &*found : nullptr;
}

double GuestStep::reach_of_sides(std::size_t obstacle) const {
  return tremolo::reach_of_sides(memories_, obstacle);
}

void GuestStep::start() {
  part_ = {};
  prepare();
  ball_ = find_ball();
  ball_.travel += pull_;
}

void GuestStep::carry(StateStream& stream) {
  carry_body(stream);
  tremolo::carry(stream, account_);
  stream(account_.slip, account_.load_work);
  stream.sized(memories_);
  stream.sized(contacted_);
  if (!stream.reads()) return;
  stream.require(std::isfinite(account_.energy) && account_.impulse_vector.allFinite());
  for (const ContactMemory& memory : memories_)
    stream.require(memory.point < points() && std::isfinite(memory.begins) &&
                   std::isfinite(memory.limit) && memory.slip.allFinite() &&
                   memory.normal.allFinite() && memory.side.normal.allFinite() &&
                   std::isfinite(memory.side.offset) && std::isfinite(memory.side.beyond) &&
                   std::isfinite(memory.depth));
  stream.require(std::is_sorted(memories_.begin(), memories_.end(), is_before));
}

void GuestStep::start_parts() {
  before_ = {memories_, contacted_, account_};
  sum_ = {};
  parts_ = 0;
  keep_whole();
}

void GuestStep::start_part(double from, double to) {
  part_ = {from, to, false};
  begin_part();
  ball_ = find_ball();
  ball_.travel += pull_;
}

void GuestStep::end_part() {
  ++parts_;
  ContactRecord part;
  part.account = account_;
  part.contacted = contacted_;
  sum_.add_part(part);
}

void GuestStep::end_parts(bool made) {
  part_ = {};
  if (made) {
    account_ = sum_.account;
    contacted_ = sum_.contacted;
  } else {
    memories_ = before_.memories;
    contacted_ = before_.contacted;
    account_ = before_.account;
  }
  end_whole(made ? parts_ : 0);
}

void GuestStep::forget_contact() {
  account_ = {};
  memories_.clear();
  contacted_.clear();
}

void GuestStep::take_account(const ContactAccount& account, double start, bool jumped) {
  const double before = account_.energy;
  account_ = account;
  account_.surplus = start - before;
  account_.given = account.work + account.energy - start + account.lost + account.friction_loss;
  if (jumped) account_.give_surplus();
  memories_.clear();
  contacted_.clear();
}

void GuestStep::sort_memories() {
  std::sort(memories_.begin(), memories_.end(), is_before);
}

}  // namespace tremolo
