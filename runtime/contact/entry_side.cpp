#include "runtime/contact/entry_side.h"

#include <algorithm>
#include <cmath>

namespace tremolo {
namespace {

// Two distances of one point agree up to this fraction: surfaces are curved.
constexpr double kAgree = 0.25;

}  // namespace

CollisionDistance distance_by(const Collider& shape, const EntrySide& side,
                              const Eigen::Vector3d& x) {
  if (side.counts()) return {side.at(x), side.normal};
  return signed_distance(shape, x);
}

bool is_behind(const Collider& shape, const EntrySide& side, const Eigen::Vector3d& x) {
  const double deep = side.at(x);
  return std::abs(signed_distance(shape, x - deep * side.normal).distance) <=
         kAgree * std::abs(deep);
}

EntrySide side_at(const Collider& shape, const EntrySide& before, const PassagePoint& from,
                  const Eigen::Vector3d& to, const CollisionDistance& found) {
  if (before.counts()) {
    const double deep = before.at(to);
    const bool agree = found.normal.dot(before.normal) > 0.0 &&
                       std::abs(found.distance - deep) <= kAgree * std::abs(deep);
    return deep >= 0.0 || agree ? EntrySide{} : before;
  }
  if (!(found.normal.dot(from.normal) < 0.0)) return {};
  const Eigen::Vector3d normal = from.normal.normalized();
  const EntrySide side{normal, from.distance - normal.dot(from.place)};
  const bool deeper = side.at(to) < std::min(0.0, found.distance);
  return deeper && is_behind(shape, side, to) ? side : EntrySide{};
}

}  // namespace tremolo
