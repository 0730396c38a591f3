// Computes shapes of several quadratic elements at once, one in each lane of a register. It finds
// the same minimum over rotations as tet_shape() (tet_element.h), by Newton's method from each
// element's previous rotation.
//
// Near rest there is one minimum within reach from any start. The following elements are left to
// tet_shape(): those strained by more than half of their size, those that rotate by more than
// Newton's method allows or meet a stiffness that is not positive, and those of anisotropic
// materials.
#pragma once

#include <array>
#include <cstddef>

#include "runtime/tets/elements/tet_element.h"

namespace tremolo {

inline constexpr std::size_t kElementLanes = 8;

// One element of a group.
struct LaneElement {
  const TetElement* element = nullptr;
  const Elasticity* elasticity = nullptr;
  std::array<const double*, kMostNodes> nodes{};  // its ten control points, m, three numbers each
  // In: its rotation is the start of the search. Out: the shape, if it was found.
  TetShape* shape = nullptr;
};

// group: quadratic and isotropic elements, at most kElementLanes. Returns a bit for each element
// whose shape was not found and is unchanged. Allocates nothing.
unsigned shapes_in_lanes(const LaneElement* group, std::size_t count);

}  // namespace tremolo
