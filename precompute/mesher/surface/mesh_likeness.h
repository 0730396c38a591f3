// A mesh of tetrahedra against the solid that it should fill.
#pragma once

#include <cstddef>

#include "common/mesh/tet_mesh.h"
#include "precompute/mesher/surface/surface_solid.h"

namespace tremolo {

// volume_share: the mesh's volume over the solid's. unsure: of that share, since the volume of a
// solid that is not closed is an estimate; 0 for a closed one. parts: of the mesh. most_parts: that
// the solid can consist of.
struct Likeness {
  double volume_share = 1;
  double unsure = 0;
  std::size_t parts = 0;
  std::size_t most_parts = 0;

  // True if the mesh is another body: crumbs of a wall, for example.
  bool is_lost() const;
  // True if the volume is off by so much that masses and frequencies suffer.
  bool is_poor() const;
};

// solid_volume: as volume(solid). mesh: in the solid's units.
Likeness compare_with_solid(const SurfaceSolid& solid, double solid_volume, const TetMesh& mesh);

}  // namespace tremolo
