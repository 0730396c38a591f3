#include "runtime/contact/islands/body_group.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tremolo {
namespace {

using Eigen::Vector3d;

// True if a moving collider comes near the body.
bool is_disturbed(const ContactStep& contact, std::span<const PlacedCollider> colliders) {
  const ContactBall& ball = contact.gathered().ball;
  return moves_near(colliders, ball.centre,
                    ball.radius + ball.deformed + 2.0 * contact.surface().law.margin);
}

}  // namespace

bool BodyGroup::has_to_wake(std::size_t i) const {
  const ContactBody& body = *bodies_[i];
  return !body.grips_.empty() || body.load_to_come() || body.gravity() != rest_[i].gravity ||
         body.options().alpha != rest_[i].alpha || body.options().beta != rest_[i].beta ||
         body.options().ratios != rest_[i].ratios || is_disturbed(*body.contact_, colliders_);
}

// Begins the step of an awake body, and finds the colliders that it may be in contact with.
void BodyGroup::begin(std::size_t i) {
  ContactBody& body = *bodies_[i];
  if (const std::optional<StepReport> failed = body.begin_step()) {
    reports_[i] = *failed;
    return;
  }
  near_[i] = body.near_something(colliders_) ? 1 : 0;
  begun_[i] = 1;
}

// Begins the next step; a body that sleeps only checks for what may wake it.
void BodyGroup::begin_or_sleep(std::size_t i) {
  reports_[i] = {};
  reports_[i].converged = true;
  if (bodies_[i] == nullptr) return;
  // One that was moved between two steps wakes.
  if (std::exchange(bodies_[i]->moved_, false) || (rest_[i].asleep && has_to_wake(i)))
    rest_[i] = {};
  if (!rest_[i].asleep) begin(i);
}

std::size_t BodyGroup::join(std::size_t a, std::size_t b, Joint joint) {
  Link link{std::min(a, b), std::max(a, b), next_joint_++, b < a, std::move(joint)};
  const auto after =
      std::upper_bound(links_.begin(), links_.end(), link, [](const Link& x, const Link& y) {
        return x.a < y.a || (x.a == y.a && (x.b < y.b || (x.b == y.b && x.number < y.number)));
      });
  links_.insert(after, std::move(link));
  wake(a);
  wake(b);
  return next_joint_ - 1;
}

bool BodyGroup::separate(std::size_t number) {
  for (const Link& link : links_)
    if (link.number == number) {
      wake(link.a);
      wake(link.b);
    }
  return std::erase_if(links_, [number](const Link& link) { return link.number == number; }) != 0;
}

const Joint* BodyGroup::joint(std::size_t number) const {
  for (const Link& link : links_)
    if (link.number == number) return &link.joint;
  return nullptr;
}

bool BodyGroup::is_joined(std::size_t i) const {
  return std::any_of(links_.begin(), links_.end(),
                     [i](const Link& link) { return link.a == i || link.b == i; });
}

// False: the bodies are joined by a joint that lets them pass through each other, or the filter
// does.
bool BodyGroup::may_touch(std::size_t a, std::size_t b) const {
  if (filter_ && !filter_(a, b)) return false;
  return std::none_of(links_.begin(), links_.end(), [a, b](const Link& link) {
    return link.a == a && link.b == b && !link.joint.touch;
  });
}

// If one of two bodies is awake, wakes the other. True if it was asleep.
bool BodyGroup::wake_pair(std::size_t a, std::size_t b) {
  bool woke = false;
  if (begun_[a] == 0 && begun_[b] == 0) return false;
  for (const std::size_t i : {a, b}) {
    if (begun_[i] != 0 || !rest_[i].asleep) continue;
    rest_[i] = {};
    begin(i);
    woke = true;
  }
  return woke;
}

// Finds the points of a and b that may be in contact, and wakes the body that sleeps.
void BodyGroup::look_at(std::size_t a, std::size_t b) {
  const ContactStep& first = *bodies_[a]->contact_;
  const ContactStep& second = *bodies_[b]->contact_;
  const ContactBall &left = first.gathered().ball, &right = second.gathered().ball;
  const double reach =
      left.radius + left.deformed + right.radius + right.deformed +
      std::max(first.surface().law.margin, second.surface().law.margin) +
      std::max(first.pair_memories().farthest(), second.pair_memories().farthest()) +
      2.0 * (left.travel + right.travel);
  const double apart = (left.centre - right.centre).norm();
  if (apart > reach) return;
  if (!passing_ && first.surface().shape_or_null() == nullptr &&
      second.surface().shape_or_null() == nullptr && apart < std::max(left.radius, right.radius))
    passing_.emplace(a, b);
  Pair pair{a, b, used_, 0};
  used_ = add_pair_points(first, second, {a, b, b}, points_, used_);
  used_ = add_pair_points(second, first, {b, a, a}, points_, used_);
  pair.count = used_ - pair.first;
  if (pair.count != 0) pairs_.push_back(pair);
}

// Finds all pairs of bodies that may be in contact, one of them awake. A body that wakes is checked
// again.
void BodyGroup::find_pairs() {
  const auto low = [this](std::size_t i) {
    const ContactBall& ball = bodies_[i]->contact_->gathered().ball;
    return ball.centre.x() - ball.radius - ball.deformed - 2.0 * ball.travel -
           bodies_[i]->contact_->surface().law.margin -
           bodies_[i]->contact_->pair_memories().farthest();
  };
  const auto high = [this](std::size_t i) {
    const ContactBall& ball = bodies_[i]->contact_->gathered().ball;
    return ball.centre.x() + ball.radius + ball.deformed + 2.0 * ball.travel +
           bodies_[i]->contact_->surface().law.margin +
           bodies_[i]->contact_->pair_memories().farthest();
  };
  for (bool again = true; again;) {
    again = false;
    pairs_.clear();
    used_ = 0;
    by_place_.clear();
    for (std::size_t i = 0; i < bodies_.size(); ++i)
      if (bodies_[i] != nullptr && bodies_[i]->contact_ && bodies_[i]->contact_->surface().feels &&
          (begun_[i] != 0 || rest_[i].asleep))
        by_place_.push_back(i);
    std::sort(by_place_.begin(), by_place_.end(), [&](std::size_t a, std::size_t b) {
      const double x = low(a), y = low(b);
      return x < y || (x == y && a < b);
    });
    for (std::size_t m = 0; m < by_place_.size(); ++m) {
      const double end = high(by_place_[m]);
      for (std::size_t n = m + 1; n < by_place_.size() && low(by_place_[n]) <= end; ++n) {
        const auto [a, b] = std::minmax(by_place_[m], by_place_[n]);
        if ((begun_[a] != 0 || begun_[b] != 0) && may_touch(a, b)) look_at(a, b);
      }
    }
    for (const Pair& pair : pairs_) again = wake_pair(pair.a, pair.b) || again;
    for (const Link& link : links_) again = wake_pair(link.a, link.b) || again;
    if (guests_ != nullptr) again = meet_guests() || again;
  }
  std::sort(pairs_.begin(), pairs_.end(),
            [](const Pair& x, const Pair& y) { return x.a < y.a || (x.a == y.a && x.b < y.b); });
}

// Finds the contacts of guests. True if one of two that are in contact slept and woke.
bool BodyGroup::meet_guests() {
  met_.assign(bodies_.size(), nullptr);
  for (const std::size_t i : by_place_) met_[i] = bodies_[i]->contact_.get();
  guests_->find_contacts(met_, begun_);
  bool woke = false;
  for (const auto& link : guests_->links())
    for (const std::size_t i : {link.first, link.second}) {
      // A joint's body may have failed.
      if (i < bodies_.size()) {
        if (begun_[i] != 0 || !rest_[i].asleep) continue;
        rest_[i] = {};
        begin(i);
      } else {
        if (!guests_->asleep(i - bodies_.size())) continue;
        guests_->wake(i - bodies_.size());
      }
      woke = true;
    }
  return woke;
}

// Bodies that have been quiet long enough fall asleep with their whole island. A grabbed or loaded
// body, or one that nothing can wake, does not.
void BodyGroup::put_to_sleep() {
  restless_.assign(parent_.size(), 0);
  for (const std::size_t i : islands_) {
    ContactBody& body = *bodies_[i];
    Rest& rest = rest_[i];
    bool quiet = reports_[i].converged && body.frame() == FrameKind::kFree && body.contact_ &&
                 (body.contact_account().active > 0 || is_joined(i) ||
                  (guests_ != nullptr && guests_->holds_body(i)));
    const double slow = quiet ? slow_speed(body.contact_->surface().law.margin) : 0.0;
    if (quiet) {
      const double speed2 = 2.0 * body.free_->kinetic(body.state_.q, body.state_.p);
      quiet = speed2 <= body.contact_->surface().mass * slow * slow && !has_to_wake(i);
    }
    if (quiet) {
      const GatheredStep& at = body.contact_->gathered();
      rest.time.count(body.options_.step,
                      {at.ball.centre, at.poses.start.rotation.toRotationMatrix(), at.ball.radius},
                      slow);
    } else {
      rest.time.restart();
    }
    rest.gravity = body.gravity();
    rest.alpha = body.options().alpha;
    rest.beta = body.options().beta;
    rest.ratios = body.options().ratios;
    if (!rest.time.is_over()) restless_[parent_[i]] = 1;
  }
  const std::size_t guests = guests_ != nullptr ? guests_->size() : 0;
  for (std::size_t g = 0; g < guests; ++g)
    if (!guests_->asleep(g) && !guests_->note_rest(g)) restless_[parent_[bodies_.size() + g]] = 1;
  for (const std::size_t i : islands_) {
    if (restless_[parent_[i]] != 0) continue;
    bodies_[i]->fall_asleep();
    rest_[i].asleep = true;
  }
  for (std::size_t g = 0; g < guests; ++g)
    if (!guests_->asleep(g) && restless_[parent_[bodies_.size() + g]] == 0) guests_->fall_asleep(g);
}

}  // namespace tremolo
