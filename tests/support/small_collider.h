// A collider file of a few hundred nodes.
#pragma once

#include <string>

#include "formats/collider/collider_file.h"
#include "tests/support/distance_fields.h"

namespace tremolo::testing {

// A ball of radius 1.
inline ColliderData small_collider() {
  GridNodes nodes = cube_of_nodes(1.5, 4);
  nodes.counts = {5, 6, 5};
  return {nodes, values_at_nodes(nodes, sphere_formula(1.0)), "{\"generator\": \"a test\"}"};
}

}  // namespace tremolo::testing
