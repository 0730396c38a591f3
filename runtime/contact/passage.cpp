#include "runtime/contact/passage.h"

#include <algorithm>
#include <limits>

namespace tremolo {

bool goes_through(const Collider& shape, const PassagePoint& from, const PassagePoint& to) {
  if (from.distance <= 0.0 || !(from.normal.dot(to.normal) < 0.0)) return false;
  const Eigen::Vector3d way = to.place - from.place;
  if (from.normal.dot(way) >= 0.0 || to.normal.dot(way) <= 0.0) return false;
  return to.distance <= 0.0 || first_hit(shape, from.place, to.place).has_value();
}

double least_passage(const Collider& shape) {
  struct Least {
    double operator()(const PlaneShape&) const { return std::numeric_limits<double>::infinity(); }
    double operator()(const SphereShape& sphere) const { return sphere.radius; }
    double operator()(const CapsuleShape& capsule) const { return capsule.radius; }
    double operator()(const BoxShape& box) const { return box.half_extents.minCoeff(); }
    double operator()(const CylinderShape& cylinder) const {
      return std::min(cylinder.radius, cylinder.half_length);
    }
    double operator()(const GridShape&) const { return 0.0; }
  };
  return std::visit(Least{}, shape);
}

}  // namespace tremolo
