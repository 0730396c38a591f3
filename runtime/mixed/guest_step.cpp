#include "runtime/mixed/guest_step.h"

#include <algorithm>

namespace tremolo {

std::optional<BlockCholesky> make_guest_factor(const BlockPatternPointer& pattern) {
  constexpr std::size_t kMostBytes = std::size_t{1} << 30;
  Result<BlockCholesky> made = BlockCholesky::create(pattern, kMostBytes);
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

void GuestStep::start() {
  part_ = {};
  prepare();
  ball_ = find_ball();
  ball_.travel += pull_;
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

void GuestStep::take_account(const ContactAccount& account, double start) {
  const double before = account_.energy;
  account_ = account;
  account_.surplus = start - before;
  account_.given = account.work + account.energy - start + account.lost + account.friction_loss;
  memories_.clear();
  contacted_.clear();
}

void GuestStep::sort_memories() {
  std::sort(memories_.begin(), memories_.end(), is_before);
}

}  // namespace tremolo
