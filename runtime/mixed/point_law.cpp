#include "runtime/mixed/point_law.h"

#include <algorithm>
#include <cmath>

namespace tremolo {

ContactLaw area_law(const PointAreas& points, double mass, const ContactOptions& options) {
  ContactLaw law;
  law.margin = law.begins = options.margin * points.extent;
  law.friction = options.friction;
  law.restitution = options.restitution;
  law.rebound_speed = 0.05 * law.margin / kContactTime;
  if (options.modulus) {
    law.linear_from = 0.1 * law.margin;
    law.stiffness = *options.modulus / (2.0 * law.linear_from * points.extent);
  } else {
    law.stiffness =
        options.stiffness * mass / (2.0 * kContactTime * kContactTime * points.area * law.margin);
  }
  return law;
}

ContactLaw point_law(const PointAreas& points, const ContactLaw& law, std::size_t point,
                     double friction, double restitution, double rounding) {
  ContactLaw made = law;
  made.rounding = rounding;
  made.friction = friction;
  made.restitution = restitution;
  made.stiffness *= points.areas[point];
  made.shear = made.stiffness * std::min(made.margin, 2.0 * made.linear_from);
  made.shear_damping = std::sqrt(points.masses[point] * made.shear);
  return made;
}

}  // namespace tremolo
