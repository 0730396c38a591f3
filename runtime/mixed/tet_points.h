// The contact points of bodies of tetrahedra of one kind under the law of contact_law.h.
#pragma once

#include <memory>
#include <vector>

#include "runtime/bodies/tets/contact/tet_contact.h"
#include "runtime/contact/contact_law.h"
#include "runtime/contact/contact_values.h"

namespace tremolo {

// The vertices of the mesh's boundary and the middles of its edges.
struct TetPoints {
  std::vector<TetPoint> points;
  std::vector<double> areas;   // of the boundary nearest to each, m^2
  std::vector<double> masses;  // that move with each, kg
  double area = 0.0;           // sum of areas, m^2
  double extent = 0.0;         // longest side of the box at rest, m
};

std::shared_ptr<const TetPoints> make_tet_points(const TetModel& model);

// The law for a unit of area. options.shape and options.points are not used.
ContactLaw area_law(const TetPoints& points, double mass, const ContactOptions& options);

// The law of a point with that friction and restitution. law: for a unit of area.
ContactLaw point_law(const TetPoints& points, const ContactLaw& law, std::size_t point,
                     double friction, double restitution);

}  // namespace tremolo
