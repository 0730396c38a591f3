// ContactIsland: which members are coupled, and which move together.
#include <algorithm>

#include "common/union_find.h"
#include "runtime/contact/islands/contact_island.h"

namespace tremolo {

ContactIsland::Coupling& ContactIsland::add_coupling(std::size_t low, std::size_t high) {
  if (coupled_ == couplings_.size()) couplings_.emplace_back();
  Coupling& coupling = couplings_[coupled_++];
  coupling.a = low;
  coupling.b = high;
  coupling.first = coupling.count = coupling.first_joint = coupling.joints = 0;
  coupling.touches = coupling.looked = false;
  coupling.blocks.clear(members_[low].contact->equations().unknowns(),
                        members_[high].contact->equations().unknowns());
  return coupling;
}

// Points and joints are sorted by pairs of members.
void ContactIsland::couple() {
  coupled_ = 0;
  Coupling* last = nullptr;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const auto [low, high] = std::minmax(points_[i].a, points_[i].b);
    if (last == nullptr || last->a != low || last->b != high) {
      last = &add_coupling(low, high);
      last->first = i;
    }
    ++last->count;
  }
  const std::size_t touching = coupled_;
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    const std::size_t low = std::min(joints_[i].a, joints_[i].b);
    const std::size_t high = std::max(joints_[i].a, joints_[i].b);
    const auto same = [low, high](const Coupling& coupling) {
      return coupling.a == low && coupling.b == high;
    };
    if (coupled_ > touching && same(couplings_[coupled_ - 1])) {
      ++couplings_[coupled_ - 1].joints;
      continue;
    }
    const auto end = couplings_.begin() + static_cast<std::ptrdiff_t>(touching);
    const auto found = std::find_if(couplings_.begin(), end, same);
    Coupling& coupling = found != end ? *found : add_coupling(low, high);
    if (coupling.joints == 0) coupling.first_joint = i;
    ++coupling.joints;
  }
  list_couplings();
}

void ContactIsland::list_couplings() {
  const std::span couplings = std::span(couplings_).first(coupled_);
  first_coupling_.assign(members_.size() + 1, 0);
  for (const Coupling& coupling : couplings) {
    ++first_coupling_[coupling.a + 1];
    ++first_coupling_[coupling.b + 1];
  }
  for (std::size_t i = 0; i < members_.size(); ++i) first_coupling_[i + 1] += first_coupling_[i];
  coupling_of_.resize(2 * coupled_);
  by_group_.assign(first_coupling_.begin(), first_coupling_.end() - 1);
  for (std::size_t k = 0; k < coupled_; ++k) {
    coupling_of_[by_group_[couplings[k].a]++] = k;
    coupling_of_[by_group_[couplings[k].b]++] = k;
  }
}

void ContactIsland::choose_none() {
  for (const std::size_t i : looked_at_) looked_[i] = 0;
  for (const std::size_t i : moving_) place_[i] = kStill;
  for (const std::size_t k : seen_) couplings_[k].looked = false;
  looked_at_.clear();
  seen_.clear();
  moving_.clear();
  diagonal_.clear();
  first_.assign(1, 0);
}

void ContactIsland::look(std::size_t member) {
  if (looked_[member] != 0) return;
  looked_[member] = 1;
  looked_at_.push_back(member);
}

void ContactIsland::look_at_couplings(std::size_t member) {
  for (const std::size_t k : couplings_of(member)) {
    if (couplings_[k].looked) continue;
    couplings_[k].looked = true;
    seen_.push_back(k);
  }
}

// The member's unknowns follow those of the members that move so far.
void ContactIsland::move_with(std::size_t member) {
  place_[member] = moving_.size();
  moving_.push_back(member);
  const ContactStep& contact = *members_[member].contact;
  scale_.segment(first_.back(), contact.equations().unknowns()) =
      contact.equations().row_scale.head(contact.equations().unknowns());
  diagonal_.push_back(&contact.equations().jacobian);
  first_.push_back(first_.back() + contact.equations().unknowns());
}

// All members are evaluated, and move.
void ContactIsland::choose_all() {
  looked_.assign(members_.size(), 0);
  place_.assign(members_.size(), kStill);
  looked_at_.clear();
  seen_.clear();
  moving_.clear();
  choose_none();
  for (std::size_t i = 0; i < members_.size(); ++i) {
    look(i);
    move_with(i);
  }
  for (std::size_t k = 0; k < coupled_; ++k) {
    couplings_[k].looked = true;
    seen_.push_back(k);
  }
}

// The members of a group move; the members in contact with them are evaluated.
void ContactIsland::choose(std::span<const std::size_t> group) {
  choose_none();
  for (const std::size_t i : group) {
    move_with(i);
    look(i);
  }
  for (const std::size_t i : group)
    for (const std::size_t k : couplings_of(i)) {
      look(couplings_[k].a);
      look(couplings_[k].b);
    }
  for (const std::size_t i : looked_at_) look_at_couplings(i);
  // Sorted, because sums follow this order.
  std::sort(seen_.begin(), seen_.end());
  std::sort(looked_at_.begin(), looked_at_.end());
}

// One member moves and is the only one that is evaluated.
void ContactIsland::choose_one(std::size_t member) {
  choose_none();
  move_with(member);
  look(member);
  look_at_couplings(member);
}

bool ContactIsland::is_converged(std::size_t i) const {
  return sizes_[i] <= kConverged * enough_[i];
}

// Members that are not converged form groups with the members in contact with them. group_ is the
// lowest member of a group, or kStill. False: all are converged.
bool ContactIsland::find_groups() {
  parent_.resize(members_.size());
  group_.assign(members_.size(), kStill);
  bool any = false;
  for (std::size_t i = 0; i < members_.size(); ++i) {
    parent_[i] = i;
    if (is_converged(i)) continue;
    group_[i] = i;
    any = true;
  }
  for (const Coupling& coupling : std::span(couplings_).first(coupled_)) {
    const auto [x, y] = std::pair{coupling.a, coupling.b};
    if (!coupling.touches || (is_converged(x) && is_converged(y))) continue;
    group_[x] = group_[y] = 0;
    join_sets(parent_, x, y);
  }
  by_group_.clear();
  for (std::size_t i = 0; i < members_.size(); ++i) {
    if (group_[i] == kStill) continue;
    group_[i] = root_of(parent_, i);
    by_group_.push_back(i);
  }
  std::sort(by_group_.begin(), by_group_.end(), [this](std::size_t x, std::size_t y) {
    return group_[x] < group_[y] || (group_[x] == group_[y] && x < y);
  });
  return any;
}

}  // namespace tremolo
