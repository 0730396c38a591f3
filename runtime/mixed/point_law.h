// The law of contact_law.h at points of a body whose boundary is divided among them.
#pragma once

#include <vector>

#include "runtime/contact/contact_law.h"
#include "runtime/contact/contact_values.h"

namespace tremolo {

// Areas and masses of the contact points of a body.
struct PointAreas {
  std::vector<double> areas;   // of the boundary nearest to each, m^2
  std::vector<double> masses;  // that move with each, kg
  double area = 0.0;           // sum of areas, m^2
  double extent = 0.0;         // longest side of the box at rest, m
};

// The law for a unit of area. mass: of the body, kg. options.shape and options.points are not used.
ContactLaw area_law(const PointAreas& points, double mass, const ContactOptions& options);

// The law of a point with that friction and restitution. law: for a unit of area. rounding:
// ContactLaw::rounding of the body, distance_rounding(extent, distance of the body from the world's
// origin), m.
ContactLaw point_law(const PointAreas& points, const ContactLaw& law, std::size_t point,
                     double friction, double restitution, double rounding);

}  // namespace tremolo
