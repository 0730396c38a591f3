// The contact points of bodies of tetrahedra of one kind under the law of contact_law.h.
#pragma once

#include <memory>
#include <vector>

#include "runtime/bodies/tets/contact/tet_contact.h"
#include "runtime/mixed/point_law.h"

namespace tremolo {

// The vertices of the mesh's boundary and the middles of its edges.
struct TetPoints : PointAreas {
  std::vector<TetPoint> points;
};

std::shared_ptr<const TetPoints> make_tet_points(const TetModel& model);

}  // namespace tremolo
