// Checks a tetrahedral mesh: repairs orientation, refuses meshes that cannot be computed with.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "common/mesh/tet_mesh.h"
#include "common/result.h"

namespace tremolo {

// A tetrahedron is degenerate if its volume is at most this times its longest edge cubed. A regular
// one has 0.118; rounding of coordinates leaves a flat one near 1e-16. Larger values refuse
// slivers that still can be computed with.
inline constexpr double kDegenerateVolume = 1e-12;

// Findings and repairs of check_mesh().
struct MeshReport {
  std::size_t flipped = 0;                // inverted tetrahedra, repaired
  std::size_t unreferenced_vertices = 0;  // kept, belong to no tetrahedron
  std::size_t parts = 0;                  // connected through shared vertices
  std::vector<int> part_of_vertex;        // one per vertex; -1 for unreferenced vertices
  double volume = 0;                      // m^3
  std::vector<std::string> notes;         // a sentence for each thing the user should know
};

// Afterwards all tetrahedra are positively oriented (the last two vertices of inverted ones are
// swapped). Parts are numbered by their first vertex. Errors (kContent; the mesh is as it was) name
// the first few elements or vertices and how many there are: no tetrahedra, coordinates that are
// not finite, indices out of range (also in node sets and regions), repeated vertices in a
// tetrahedron, degenerate tetrahedra, two tetrahedra with the same four vertices. Elements and
// vertices count from 0.
Result<MeshReport> check_mesh(TetMesh& mesh);

}  // namespace tremolo
