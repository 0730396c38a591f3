// Shapes of several quadratic elements at once, one in each lane of a register: the same minimum
// over rotations as tet_shape() finds (tet_element.h), by Newton's method from the rotation that
// each element had before.
//
// Near rest there is one minimum within reach, whatever it is sought from. Elements that are
// strained by more than half of their size, that turn by more than Newton's method may, or where it
// meets a stiffness that is not positive are left to tet_shape(), as are those of materials that
// are not isotropic.
#pragma once

#include <array>
#include <cstddef>

#include "runtime/tets/elements/tet_element.h"

namespace tremolo {

inline constexpr std::size_t kElementLanes = 8;

// One element of a group. nodes: its ten control points, m, three numbers each. shape: its rotation
// is where the search begins; becomes the shape where it was found.
struct LaneElement {
  const TetElement* element = nullptr;
  const Elasticity* elasticity = nullptr;
  std::array<const double*, kMostNodes> nodes{};
  TetShape* shape = nullptr;
};

// group: quadratic and isotropic elements, at most kElementLanes. Returns a bit for each that was
// not found, whose shape is as before. Allocates nothing.
unsigned shapes_in_lanes(const LaneElement* group, std::size_t count);

}  // namespace tremolo
