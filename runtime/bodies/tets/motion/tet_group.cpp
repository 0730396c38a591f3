#include "runtime/bodies/tets/motion/tet_group.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

#include "common/processor.h"
#include "common/union_find.h"

namespace tremolo {
namespace {

// Boxes nearer than this fraction of a body's size overlap.
constexpr double kBoxMargin = 0.02;
// Bodies of a heap have some hundred contact points each.
constexpr std::size_t kTouchesOfBody = 256;
constexpr std::size_t kMostNeighbours = 32;

}  // namespace

Status check(const TetGroupOptions& options) {
  if (!(options.sleep_speed >= 0.0 && std::isfinite(options.sleep_speed)))
    return content_error("sleep speed is " + std::to_string(options.sleep_speed) +
                         " m/s, expected at least 0");
  if (!(options.sleep_time >= 0.0 && std::isfinite(options.sleep_time)))
    return content_error("sleep time is " + std::to_string(options.sleep_time) +
                         " s, expected at least 0");
  if (options.threads < 1 || options.threads > kMostThreads)
    return content_error("threads: expected 1 to " + std::to_string(kMostThreads));
  return Success{};
}

TetGroup::TetGroup(std::vector<TetBody> bodies, std::vector<TetContact> contacts,
                   std::vector<double> frictions, const TetGroupOptions& options)
    : bodies_(std::move(bodies)),
      contacts_(std::move(contacts)),
      frictions_(std::move(frictions)),
      options_(options),
      pool_(std::make_unique<ThreadPool>(options.threads)),
      island_(pool_.get()) {
  const std::size_t count = bodies_.size();
  boxes_.resize(count);
  // Each body's box meets a few others; in a dense heap the list grows.
  pairs_.reserve(std::min(count * count / 2, kMostNeighbours * count));
  by_place_.resize(count);
  std::iota(by_place_.begin(), by_place_.end(), std::uint32_t{0});
  for (std::vector<std::uint32_t>* list : {&roots_, &naps_, &local_}) list->assign(count, 0);
  order_.reserve(count);
  starts_.reserve(count + 1);
  asleep_.assign(count, 0);
  wide_awake_.reserve(count);
  still_.assign(count, 0.0);
  speeds_.assign(count, 0.0);
  members_.reserve(count);
  island_reports_.reserve(count);
  island_.reserve(count, count * kTouchesOfBody);
}

std::size_t TetGroup::sleeping() const {
  return static_cast<std::size_t>(std::count(asleep_.begin(), asleep_.end(), 1));
}

bool TetGroup::touched(std::size_t i) const {
  if (!contacts_[i].touches().empty()) return true;
  for (std::size_t other = 0; other < contacts_.size(); ++other) {
    if (other == i || asleep_[other] != 0) continue;
    for (const TetTouch& touch : contacts_[other].touches())
      if (touch.partner != kNoPartner &&
          contacts_[other].partners()[touch.partner].contact == &contacts_[i])
        return true;
  }
  return false;
}

void TetGroup::find_boxes() {
  pool_->run(bodies_.size(), [this](std::size_t i, unsigned) {
    const TetBody& body = bodies_[i];
    if (asleep_[i] != 0 && !boxes_[i].isEmpty()) return;
    contacts_[i].fit(body.positions());
    const TetTree::Box& now = contacts_[i].box();
    double fastest = 0.0;
    for (Eigen::Index k = 0; k < body.velocities().size(); k += 3)
      fastest = std::max(fastest, body.velocities().segment<3>(k).norm());
    const double margin = kBoxMargin * now.diagonal().norm() + body.options().step * fastest;
    boxes_[i] = TetTree::Box(now.min().array() - margin, now.max().array() + margin);
  });
}

// Finds all pairs of boxes that meet and of which one is awake, in order: a sweep along x.
void TetGroup::find_pairs() {
  pairs_.clear();
  const auto low = [this](std::uint32_t i) { return boxes_[i].min().x(); };
  std::sort(by_place_.begin(), by_place_.end(), [&low](std::uint32_t a, std::uint32_t b) {
    return low(a) < low(b) || (low(a) == low(b) && a < b);
  });
  for (std::size_t m = 0; m < by_place_.size(); ++m) {
    const std::uint32_t one = by_place_[m];
    for (std::size_t n = m + 1; n < by_place_.size(); ++n) {
      const std::uint32_t other = by_place_[n];
      if (low(other) > boxes_[one].max().x()) break;
      if ((asleep_[one] == 0 || asleep_[other] == 0) && boxes_[one].intersects(boxes_[other]))
        pairs_.emplace_back(std::min(one, other), std::max(one, other));
    }
  }
  std::sort(pairs_.begin(), pairs_.end());
}

// True if a point of one body is in the other at the present positions.
bool TetGroup::touches(std::uint32_t a, std::uint32_t b) {
  for (const auto& [one, other] : {Pair{a, b}, Pair{b, a}}) {
    TetContact& contact = contacts_[one];
    if (!contacts_[other].hull().grid) continue;
    contact.clear_partners();
    const Eigen::VectorXd& at = bodies_[other].positions();
    contact.add_partner({0, other, &contacts_[other], &at, &at, 0.0});
    contact.find(bodies_[one].positions(), bodies_[one].positions());
    for (const TetTouch& touch : contact.touches())
      if (touch.partner != kNoPartner) return true;
  }
  return false;
}

void TetGroup::find_touches() {
  find_boxes();
  find_pairs();
  for (TetContact& contact : contacts_) contact.clear_partners();
  for (const auto& [a, b] : pairs_)
    for (const auto& [one, other] : {Pair{a, b}, Pair{b, a}})
      if (contacts_[other].hull().grid)
        contacts_[one].add_partner({other, other, &contacts_[other], &bodies_[other].positions(),
                                    &bodies_[other].positions(), 0.0});
  for (std::size_t i = 0; i < bodies_.size(); ++i)
    contacts_[i].find(bodies_[i].positions(), bodies_[i].positions());
}

void TetGroup::end_nap(std::uint32_t nap) {
  for (std::uint32_t i = 0; i < bodies_.size(); ++i)
    if (asleep_[i] != 0 && naps_[i] == nap) {
      asleep_[i] = 0;
      still_[i] = 0.0;
    }
}

Status TetGroup::set_state(std::size_t i, const Eigen::VectorXd& x, const Eigen::VectorXd& v) {
  const Eigen::VectorXd before = bodies_[i].positions();
  if (Status s = bodies_[i].set_state(x, v); !s) return s;
  if (bodies_[i].positions() != before) {
    contacts_[i].forget();
    for (TetContact& contact : contacts_) contact.forget_body(static_cast<std::uint32_t>(i));
  }
  if (asleep_[i] != 0) end_nap(naps_[i]);
  return Success{};
}

Status TetGroup::set_hand(std::size_t i, const std::optional<TetHand>& hand) {
  if (i >= bodies_.size())
    return usage_error("there are " + std::to_string(bodies_.size()) + " bodies, no body " +
                       std::to_string(i));
  if (Status s = bodies_[i].set_hand(hand); !s) return s;
  if (asleep_[i] != 0) end_nap(naps_[i]);
  return Success{};
}

// Repeats until no moving body is in contact with a sleeping one.
void TetGroup::wake() {
  bool woke = true;
  while (woke) {
    woke = false;
    for (const auto& [a, b] : pairs_) {
      if (asleep_[a] == asleep_[b] || !touches(a, b)) continue;
      end_nap(naps_[asleep_[a] != 0 ? a : b]);
      woke = true;
    }
    if (woke) find_pairs();
  }
}

// order_: moving bodies, island by island; starts_: index of each island's first body.
void TetGroup::join_islands() {
  std::iota(roots_.begin(), roots_.end(), 0U);
  for (const auto& [a, b] : pairs_) {
    if (asleep_[a] != 0 || asleep_[b] != 0) continue;
    join_sets(roots_, a, b);
  }
  order_.clear();
  for (std::uint32_t i = 0; i < bodies_.size(); ++i)
    if (asleep_[i] == 0) order_.push_back(i);
  // Sorted by the smallest body of an island, and then by number.
  std::sort(order_.begin(), order_.end(), [this](std::uint32_t a, std::uint32_t b) {
    return std::pair(root_of(roots_, a), a) < std::pair(root_of(roots_, b), b);
  });
  starts_.clear();
  for (std::uint32_t k = 0; k < order_.size(); ++k)
    if (k == 0 || root_of(roots_, order_[k]) != root_of(roots_, order_[k - 1]))
      starts_.push_back(k);
  starts_.push_back(static_cast<std::uint32_t>(order_.size()));
}

void TetGroup::take_island(std::span<const std::uint32_t> island,
                           std::span<TetStepReport> reports) {
  members_.clear();
  for (const std::uint32_t i : island) {
    local_[i] = static_cast<std::uint32_t>(members_.size());
    members_.push_back({&bodies_[i], &contacts_[i]});
  }
  for (const auto& [a, b] : pairs_) {
    if (asleep_[a] != 0 || asleep_[b] != 0 || root_of(roots_, a) != root_of(roots_, island[0]))
      continue;
    const double friction = std::sqrt(frictions_[a] * frictions_[b]);
    for (const auto& [one, other] : {Pair{a, b}, Pair{b, a}})
      if (contacts_[other].hull().grid)
        contacts_[one].add_partner({local_[other], other, &contacts_[other],
                                    &bodies_[other].trial_places(), &bodies_[other].positions(),
                                    friction});
  }
  island_reports_.assign(island.size(), {});
  island_.step(members_, island_reports_);
  for (std::size_t k = 0; k < island.size(); ++k) reports[island[k]] = island_reports_[k];
}

bool TetGroup::step(std::span<TetStepReport> reports) {
  find_boxes();
  find_pairs();
  wake();
  join_islands();
  for (TetContact& contact : contacts_) contact.clear_partners();
  std::fill(reports.begin(), reports.end(), TetStepReport{});
  // Threads divide single bodies among themselves; the bodies of an island are divided within it.
  pool_->run(starts_.size() - 1, [&](std::size_t k, unsigned) {
    if (starts_[k + 1] - starts_[k] > 1) return;
    const std::uint32_t i = order_[starts_[k]];
    reports[i] = bodies_[i].step(&contacts_[i]);
  });
  for (std::size_t k = 0; k + 1 < starts_.size(); ++k)
    if (starts_[k + 1] - starts_[k] > 1)
      take_island(std::span(order_).subspan(starts_[k], starts_[k + 1] - starts_[k]), reports);
  for (std::size_t i = 0; i < bodies_.size(); ++i)
    if (asleep_[i] != 0) bodies_[i].skip_step();
  fall_asleep();
  return std::all_of(reports.begin(), reports.end(),
                     [](const TetStepReport& report) { return report.converged; });
}

void TetGroup::fall_asleep() {
  if (!(options_.sleep_speed > 0.0)) return;
  // Joins moving bodies in contact.
  for (const std::uint32_t i : order_) roots_[i] = i;
  wide_awake_.assign(bodies_.size(), 0);
  for (const auto& [a, b] : pairs_) {
    if (asleep_[a] != 0 || asleep_[b] != 0) continue;
    for (const auto& [one, other] : {Pair{a, b}, Pair{b, a}})
      for (const TetTouch& touch : contacts_[one].touches()) {
        if (touch.partner == kNoPartner ||
            contacts_[one].partners()[touch.partner].contact != &contacts_[other])
          continue;
        join_sets(roots_, a, b);
        break;
      }
  }
  pool_->run(order_.size(), [this](std::size_t k, unsigned) {
    const TetBody& body = bodies_[order_[k]];
    speeds_[order_[k]] = std::sqrt(2.0 * body.kinetic_energy() / body.model().mass());
  });
  for (const std::uint32_t i : order_) {
    still_[i] = speeds_[i] < options_.sleep_speed ? still_[i] + bodies_[i].options().step : 0.0;
    if (still_[i] < options_.sleep_time || contacts_[i].touches().empty() || bodies_[i].hand())
      wide_awake_[root_of(roots_, i)] = 1;
  }
  for (const std::uint32_t i : order_) {
    if (wide_awake_[root_of(roots_, i)] != 0) continue;
    energy_of_sleep_ += bodies_[i].kinetic_energy();
    naps_[i] = root_of(roots_, i);
    asleep_[i] = 1;
    bodies_[i].stop();
  }
}

std::size_t TetGroup::bytes() const {
  std::size_t sum = 0;
  for (const TetBody& body : bodies_) sum += body.bytes();
  for (const TetContact& contact : contacts_) sum += contact.bytes();
  return sum;
}

namespace {

// A body that moves by less than this fraction of its size in a step is at rest up to rounding.
constexpr double kRoundingWay = 1e-9;

}  // namespace

bool TetBound::look(TetGroup& group) {
  double gravity = 0.0, rounding = 0.0;
  energy_ = 0.0;
  for (std::size_t i = 0; i < group.size(); ++i) {
    TetBody& body = group.body(i);
    energy_ += body.kinetic_energy() + body.elastic_energy() + group.contact(i).look().energy;
    gravity += body.gravity_energy();
    const double speed = kRoundingWay * body.model().rest_box().diagonal() / body.options().step;
    rounding += 0.5 * body.model().mass() * speed * speed;
  }
  if (!started_) bound_.start(energy_);
  bound_.put_in(started_ ? gravity_ - gravity : 0.0, rounding);
  started_ = true;
  gravity_ = gravity;
  if (!bound_.sound(energy_)) return false;
  bound_.take_off_what_is_lost(energy_, 0.0);
  return true;
}

}  // namespace tremolo
