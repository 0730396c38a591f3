// BodyGroup: makes islands and steps them.
#include <algorithm>
#include <numeric>
#include <string>
#include <system_error>
#include <thread>
#include <type_traits>

#include "common/processor.h"
#include "common/union_find.h"
#include "runtime/contact/islands/body_group.h"

namespace tremolo {

Status BodyGroup::set_threads(unsigned threads) {
  if (threads == 0) threads = std::max(1U, std::thread::hardware_concurrency());
  if (threads > kMostThreads)
    return content_error(std::to_string(threads) + " threads: at most " +
                         std::to_string(kMostThreads));
  if (threads == this->threads()) return Success{};
  try {
    pool_ = threads > 1 ? std::make_unique<ThreadPool>(threads) : nullptr;
  } catch (const std::system_error& error) {
    return system_error(std::string("threads cannot be had: ") + error.what());
  }
  return Success{};
}

// Calls work(index, thread) for each index below count.
template <class Work>
void BodyGroup::share(std::size_t count, Work&& work) {
  if (jobs_) {
    const auto job = [](void* at, std::size_t index, unsigned worker) {
      (*static_cast<std::remove_reference_t<Work>*>(at))(index, worker);
    };
    return jobs_->run(count, job, &work);
  }
  if (pool_) return pool_->run(count, work);
  for (std::size_t i = 0; i < count; ++i) work(i, 0U);
}

// Fills islands_ with the bodies of this step, sorted by island and number.
// Roots of guests are in parent_ after those of bodies.
void BodyGroup::make_islands() {
  parent_.resize(bodies_.size() + (guests_ != nullptr ? guests_->size() : 0));
  std::iota(parent_.begin(), parent_.end(), std::size_t{0});
  const auto unite = [this](std::size_t a, std::size_t b) {
    if (begun_[a] == 0 || begun_[b] == 0) return;
    join_sets(parent_, a, b);
  };
  for (const Pair& pair : pairs_) unite(pair.a, pair.b);
  for (const Link& link : links_) unite(link.a, link.b);
  if (guests_ != nullptr)
    for (const auto& [guest, other] : guests_->links())
      if (other >= bodies_.size() || begun_[other] != 0) join_sets(parent_, guest, other);
  // Parents are lower, so theirs are roots already.
  for (std::size_t i = 0; i < parent_.size(); ++i) parent_[i] = parent_[parent_[i]];
  hosts_.assign(parent_.size(), 0);
  for (std::size_t i = bodies_.size(); i < parent_.size(); ++i) hosts_[parent_[i]] = 1;
  islands_.clear();
  for (std::size_t i = 0; i < bodies_.size(); ++i)
    if (begun_[i] != 0) islands_.push_back(i);
  const auto before = [this](std::size_t a, std::size_t b) {
    return parent_[a] < parent_[b] || (parent_[a] == parent_[b] && a < b);
  };
  std::sort(islands_.begin(), islands_.end(), before);
  by_island_.clear();
  for (std::size_t k = 0; k < pairs_.size(); ++k)
    if (begun_[pairs_[k].a] != 0 && begun_[pairs_[k].b] != 0) by_island_.push_back(k);
  std::sort(by_island_.begin(), by_island_.end(), [this](std::size_t k, std::size_t l) {
    const std::size_t x = parent_[pairs_[k].a], y = parent_[pairs_[l].a];
    return x < y || (x == y && k < l);
  });
  list_islands();
}

void BodyGroup::list_islands() {
  listed_.clear();
  std::size_t pair = 0;
  for (std::size_t first = 0; first < islands_.size();) {
    Island island{first, 1, pair, 0};
    const std::size_t here = parent_[islands_[first]];
    while (first + island.count < islands_.size() &&
           parent_[islands_[first + island.count]] == here)
      ++island.count;
    while (pair < by_island_.size() && parent_[pairs_[by_island_[pair]].a] == here) ++pair;
    island.pairs = pair - island.first_pair;
    listed_.push_back(island);
    first += island.count;
  }
}

// Steps a body without contact with others.
void BodyGroup::step_alone(std::size_t i) {
  ContactBody& body = *bodies_[i];
  StepReport report;
  report = body.advance_near(near_[i] != 0);
  reports_[i] = body.end_step(report);
}

void BodyGroup::step_island(const Island& island, Worker& worker) {
  const std::span<const std::size_t> who(islands_.data() + island.first, island.count);
  const bool hosting = hosts(who[0]);
  if (island.count == 1 && !hosting) return step_alone(who[0]);
  worker.members.clear();
  for (std::size_t m = 0; m < island.count; ++m) {
    ContactBody& body = *bodies_[who[m]];
    worker.members.push_back(
        {body.contact_.get(), &body.state_, &body.step_load_, body.free_.get(), who[m]});
    member_of_[who[m]] = m;
  }
  std::size_t used = 0;
  for (std::size_t p = island.first_pair; p < island.first_pair + island.pairs; ++p) {
    const Pair& pair = pairs_[by_island_[p]];
    for (std::size_t k = pair.first; k < pair.first + pair.count; ++k, ++used) {
      if (used == worker.points.size()) worker.points.emplace_back();
      PairPoint& point = worker.points[used];
      std::swap(point, points_[k]);
      point.a = member_of_[point.a];
      point.b = member_of_[point.b];
    }
  }
  gather_joints(parent_[who[0]], worker.joints);
  std::vector<StepReport>& reports = worker.reports;
  reports.assign(island.count, StepReport{});  // parts add to them
  const bool parts = !hosting && step_impact(island, used, worker);
  if (parts)
    note_touches(worker.parts.points(), who, worker.touches);
  else if (hosting)
    guests_->step_island(std::span(parent_).subspan(bodies_.size()),
                         {worker.members, worker.points, used, worker.joints, reports});
  else
    worker.island.step(worker.members, worker.points, used, worker.joints,
                       bodies_[who[0]]->options_.step, false, reports);
  const bool whole = !parts && reports[0].converged;
  if (whole)
    note_touches(std::span(worker.points).first(used), who, worker.touches);
  else if (!parts && step_in_parts(island, worker, PartReason::kFailure))
    note_touches(worker.parts.points(), who, worker.touches);
  for (std::size_t m = 0; m < island.count; ++m) {
    ContactBody& body = *bodies_[who[m]];
    if (whole) body.end_contact();
    reports_[who[m]] = body.end_step(reports[m]);
  }
}

// Steps a small island in parts if rigid bodies of it hit hard. False: its step is still to be
// taken. points: number of entries in use of the worker's.
bool BodyGroup::step_impact(const Island& island, std::size_t points, Worker& worker) {
  // Parts cost up to 80 times the step, so that heaps take it whole.
  constexpr std::size_t kMostBodies = 16, kDeformable = 12;
  std::size_t bodies = 0;
  for (const IslandMember& member : worker.members) {
    const ContactPoints& solid = *member.contact->surface().points;
    if (solid.rigid())
      ++bodies;
    else if (solid.reach.maxCoeff() > 0.0)  // not the world's end of a joint
      bodies += kDeformable;
  }
  const double h = bodies_[islands_[island.first]]->options_.step;
  if (bodies > kMostBodies ||
      !worker.impacts.divides(worker.members, std::span(worker.points).first(points), h, false))
    return false;
  const bool made = step_in_parts(island, worker, PartReason::kImpact);
  for (StepReport& report : worker.reports) report.parts = 1;  // they are part of the plan
  if (!made)
    for (const PartBody& one : worker.bodies) (void)one.body->near_something(colliders_);
  return made;
}

// Steps the island in parts. After a failure of its whole step with guests that was the last one
// that they tried.
bool BodyGroup::step_in_parts(const Island& island, Worker& worker, PartReason reason) {
  worker.bodies.clear();
  worker.pairs.clear();
  for (std::size_t m = 0; m < island.count; ++m) {
    const std::size_t i = islands_[island.first + m];
    worker.bodies.push_back({bodies_[i], i});
  }
  for (std::size_t p = island.first_pair; p < island.first_pair + island.pairs; ++p) {
    const Pair& pair = pairs_[by_island_[p]];
    worker.pairs.push_back({member_of_[pair.a], member_of_[pair.b]});
  }
  IslandGuests* guests = hosts(islands_[island.first]) ? guests_ : nullptr;
  const double h = worker.bodies.front().body->options_.step;
  const bool made = worker.parts.step(
      {worker.bodies, colliders_, worker.pairs, worker.joints, guests}, h, worker.reports, reason);
  for (const PartBody& one : worker.bodies) one.body->booked_ = made;
  return made;
}

// Finds the joints of the island whose members member_of_ lists.
void BodyGroup::gather_joints(std::size_t root_here, std::vector<IslandJoint>& joints) {
  joints.clear();
  for (Link& link : links_) {
    if (begun_[link.a] == 0 || begun_[link.b] == 0 || parent_[link.a] != root_here) continue;
    const std::size_t a = member_of_[link.a], b = member_of_[link.b];
    joints.push_back({&link.joint, link.turned ? b : a, link.turned ? a : b});
  }
}

void BodyGroup::note_touches(std::span<const PairPoint> points, std::span<const std::size_t> who,
                             std::vector<Touch>& touches) const {
  for (const PairPoint& point : points) {
    if (point.now.pressure == 0.0) continue;
    const std::size_t a = std::min(who[point.a], who[point.b]);
    const std::size_t b = std::max(who[point.a], who[point.b]);
    const double impulse = bodies_[a]->options_.step * point.now.force.norm();
    const auto found = std::find_if(touches.begin(), touches.end(), [&](const Touch& touch) {
      return touch.a == a && touch.b == b;
    });
    if (found != touches.end())
      found->impulse += impulse;
    else
      touches.push_back({a, b, impulse});
  }
}

// A pair's contacts belong to one island, so that their order does not depend on the thread.
void BodyGroup::step_islands() {
  workers_.resize(threads());
  for (Worker& worker : workers_) worker.touches.clear();
  share(listed_.size(), [this](std::size_t k, unsigned thread) {
    if (!hosts(islands_[listed_[k].first])) step_island(listed_[k], workers_[thread]);
  });
  // Guests have the memory of one island.
  for (const Island& island : listed_)
    if (hosts(islands_[island.first])) step_island(island, workers_[0]);
  if (guests_ != nullptr) guests_->step_others(std::span(parent_).subspan(bodies_.size()));
  touches_.clear();
  for (const Worker& worker : workers_)
    touches_.insert(touches_.end(), worker.touches.begin(), worker.touches.end());
  std::sort(touches_.begin(), touches_.end(),
            [](const Touch& x, const Touch& y) { return x.a < y.a || (x.a == y.a && x.b < y.b); });
}

// Bodies that lay on a sleeping one that was moved have to fall: all wake.
void BodyGroup::wake_around_moved() {
  bool any = false;
  for (std::size_t i = 0; i < bodies_.size(); ++i)
    any = any || (bodies_[i] != nullptr && bodies_[i]->moved_ && rest_[i].asleep);
  if (!any) return;
  for (Rest& rest : rest_)
    if (rest.asleep) rest = {};
  if (guests_ != nullptr) guests_->wake_all();
}

void BodyGroup::step(std::span<ContactBody* const> bodies,
                     std::span<const PlacedCollider> colliders, std::span<StepReport> reports) {
  bodies_ = bodies;
  colliders_ = colliders;
  reports_ = reports;
  rest_.resize(bodies.size());
  begun_.assign(bodies.size(), 0);
  near_.assign(bodies.size(), 0);
  member_of_.resize(bodies.size());
  wake_around_moved();
  share(bodies.size(), [this](std::size_t i, unsigned) { begin_or_sleep(i); });
  if (guests_ != nullptr) guests_->start(colliders);
  find_pairs();
  make_islands();
  step_islands();
  for (std::size_t i = 0; i < bodies.size(); ++i)
    if (bodies[i] != nullptr && rest_[i].asleep) bodies[i]->rest_a_step();
  if (options_.sleep) put_to_sleep();
}

}  // namespace tremolo
