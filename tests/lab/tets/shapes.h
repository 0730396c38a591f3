// Bodies of tetrahedra for experiments: meshes of cells of six tetrahedra, all fixed at one end.
//   bar       0.4 x 0.1 x 0.1 m, 4m x m x m cells, bends along all of its length;
//   mushroom  a stem of 0.3 x 0.05 x 0.05 m and a cap of 0.1 x 0.15 x 0.15 m on its free end, cells
//             of 0.05/m m: three quarters of the elements are the cap's, which does not bend;
//   coil      three turns of a square wire of 0.02 m around a cylinder of 0.12 m, 0.05 m a turn,
//             16m cells a turn, m x m over the wire: curved at rest, it twists everywhere.
#pragma once

#include <vector>

#include "common/mesh/tet_mesh.h"
#include "formats/tets/tets_file.h"

namespace tremolo::tets {

enum class ShapeKind { kBar, kMushroom, kCoil };
const char* shape_name(ShapeKind kind);

// held: vertices. size: its length, the coil's height, m. points: places of the surface that are
// compared, in elements that hold them: of the bar 17 x 3 x 3 that are the same for all meshes, of
// others the vertices and the middles of the boundary's edges.
struct Shape {
  TetMesh mesh;
  std::vector<VertexId> held;
  double size = 1.0;
  TetsSurface points;
};

// cells: m, at least 1.
Shape make_shape(ShapeKind kind, int cells);

}  // namespace tremolo::tets
