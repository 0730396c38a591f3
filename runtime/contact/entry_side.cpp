#include "runtime/contact/entry_side.h"

#include <algorithm>
#include <cmath>
#include <variant>

namespace tremolo {
namespace {

// Two distances of one point agree up to this fraction: surfaces are curved.
constexpr double kAgree = 0.25;
// Cosine below which two normals are those of different faces.
constexpr double kOtherFace = 0.5;
// A point is on an edge up to this fraction of the shape's largest extent.
constexpr double kOnEdge = 1e-4;
// The plane of an edge continues for this many times the largest depth by it: a point that slides
// at the speed of its approach goes three times as far.
constexpr double kBeyondEdge = 4.0;

}  // namespace

CollisionDistance distance_by(const Collider& shape, const EntrySide& side,
                              const Eigen::Vector3d& x) {
  if (side.counts()) return {side.at(x), side.normal};
  return signed_distance(shape, x);
}

bool is_behind(const Collider& shape, const EntrySide& side, const Eigen::Vector3d& x) {
  const double deep = side.at(x);
  return std::abs(signed_distance(shape, x - deep * side.normal).distance) <=
         std::max(kAgree * std::abs(deep), side.beyond);
}

bool is_through(const Collider& shape, const EntrySide& side, const Eigen::Vector3d& x) {
  return signed_distance(shape, x).normal.dot(side.normal) < -kOtherFace;
}

bool is_at_surface(const Collider& shape, double distance) {
  return !std::holds_alternative<PlaneShape>(shape) &&
         std::abs(distance) <= kOnEdge * largest_extent(shape);
}

EntrySide side_on_edge(const Collider& shape, const Eigen::Vector3d& x,
                       const CollisionDistance& found, const Eigen::Vector3d& inward) {
  if (inward.isZero(0.0) || !is_at_surface(shape, found.distance)) return {};
  const double reach = kOnEdge * largest_extent(shape);
  const Eigen::Vector3d normal = signed_distance(shape, x + reach * inward).normal.normalized();
  if (!(found.normal.dot(normal) < kOtherFace)) return {};
  return {normal, found.distance - normal.dot(x), reach};
}

EntrySide side_at(const Collider& shape, const EntrySide& before, const PassagePoint& from,
                  const Eigen::Vector3d& to, const CollisionDistance& found,
                  const Eigen::Vector3d& inward, double begins) {
  if (before.counts()) {
    const double deep = before.at(to);
    const bool edge = before.beyond > 0.0;
    const bool agree = found.normal.dot(before.normal) > 0.0 &&
                       std::abs(found.distance - deep) <= kAgree * std::abs(deep);
    if (agree || deep >= (edge ? begins : 0.0)) return {};
    EntrySide side = before;
    if (edge) side.beyond = std::max(side.beyond, -kBeyondEdge * deep);
    return side;
  }
  const double cosine = found.normal.dot(from.normal);
  const bool other_face = cosine < kOtherFace && !inward.isZero(0.0);
  if (!(cosine < 0.0) && !other_face) return {};
  Eigen::Vector3d normal = from.normal.normalized();
  if (!(cosine < 0.0)) {
    // A face beside the one of entry: the point is below that one where a little towards its body
    // along the face leads into the obstacle. At a point beside the edge the normal is not yet that
    // of the face.
    const Eigen::Vector3d along =
        kOnEdge * largest_extent(shape) * (inward - normal.dot(inward) * normal);
    if (signed_distance(shape, to + along).distance > 0.0) return {};
    normal = signed_distance(shape, from.place + along).normal.normalized();
  }
  EntrySide side{normal, from.distance - normal.dot(from.place)};
  const double deep = side.at(to);
  if (!(deep < std::min(0.0, found.distance)) || !is_behind(shape, side, to)) return {};
  if (!(cosine < 0.0)) side.beyond = -kBeyondEdge * deep;
  return side;
}

}  // namespace tremolo
