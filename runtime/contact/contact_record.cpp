#include "runtime/contact/contact_record.h"

#include <algorithm>

namespace tremolo {
namespace {

using Eigen::Vector3d;

// Adds a part of a step. The energy is that at the end of the part.
void add_account(ContactAccount& sum, const ContactAccount& part) {
  const ContactAccount before = sum;
  sum = part;
  for (double ContactAccount::*each :
       {&ContactAccount::work, &ContactAccount::lost, &ContactAccount::friction_loss,
        &ContactAccount::given, &ContactAccount::surplus, &ContactAccount::hand_work,
        &ContactAccount::hand_damped, &ContactAccount::joint_work, &ContactAccount::load_work,
        &ContactAccount::impulse})
    sum.*each += before.*each;
  sum.penetration = std::max(sum.penetration, before.penetration);
  sum.slip = std::max(sum.slip, before.slip);
  sum.way += before.way;
  sum.active = std::max(sum.active, before.active);
  sum.passed += before.passed;
  sum.impulse_vector += before.impulse_vector;
}

// A point that had a force in an earlier part too is listed once, with the sum of its impulses.
void add_point(std::vector<ContactedPoint>& points, const ContactedPoint& point) {
  const auto found =
      std::find_if(points.begin(), points.end(), [&point](const ContactedPoint& other) {
        return other.vertex == point.vertex && other.on_body == point.on_body &&
               other.obstacle == point.obstacle;
      });
  if (found == points.end()) return points.push_back(point);
  const Vector3d before = found->impulse;
  *found = point;
  found->impulse += before;
}

}  // namespace

void ContactRecord::reserve(std::size_t points, std::size_t colliders) {
  impulses.resize(colliders);
  collider_impulses.resize(colliders);
  contacted.reserve(points * (colliders + 1));
}

void ContactRecord::clear_contacts() {
  std::fill(impulses.begin(), impulses.end(), 0.0);
  std::fill(collider_impulses.begin(), collider_impulses.end(), Vector3d::Zero());
  contacted.clear();
}

void ContactRecord::reset() {
  const double left = account.energy;
  begin({});
  account.surplus = -left;
}

void ContactRecord::begin(const ContactAccount& begun) {
  clear_contacts();
  account = begun;
  rounding = 0.0;
}

void ContactRecord::add_part(const ContactRecord& part) {
  add_account(account, part.account);
  impulses.resize(part.impulses.size(), 0.0);
  collider_impulses.resize(part.impulses.size(), Vector3d::Zero());
  for (std::size_t c = 0; c < part.impulses.size(); ++c) {
    impulses[c] += part.impulses[c];
    collider_impulses[c] += part.collider_impulses[c];
  }
  for (const ContactedPoint& point : part.contacted) add_point(contacted, point);
  held_steps = part.held_steps;
  rounding += part.rounding;
}

}  // namespace tremolo
