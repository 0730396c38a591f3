#include "formats/mesh/mesh_cells.h"

#include <algorithm>
#include <span>

namespace tremolo {
namespace {

using Role = CellKind::Role;

struct NumberedKind {
  int type;
  CellKind kind;
};

constexpr NumberedKind kMshKinds[] = {
    {1, {"lines", 2}},
    {2, {"triangles", 3}},
    {3, {"quadrangles", 4}},
    {4, {"tetrahedra", 4, Role::kTetrahedron}},
    {5, {"hexahedra", 8, Role::kHexahedron}},
    {6, {"prisms", 6, Role::kWedge}},
    {7, {"pyramids", 5, Role::kPyramid}},
    {8, {"3-node lines", 3}},
    {9, {"6-node triangles", 6}},
    {10, {"9-node quadrangles", 9}},
    {11, {"10-node tetrahedra", 10, Role::kGmshQuadraticTetrahedron}},
    {12, {"27-node hexahedra", 27, Role::kHexahedron}},
    {13, {"18-node prisms", 18, Role::kWedge}},
    {14, {"14-node pyramids", 14, Role::kPyramid}},
    {15, {"points", 1}},
    {16, {"8-node quadrangles", 8}},
    {17, {"20-node hexahedra", 20, Role::kHexahedron}},
    {18, {"15-node prisms", 15, Role::kWedge}},
    {19, {"13-node pyramids", 13, Role::kPyramid}},
    {20, {"9-node triangles", 9}},
    {21, {"10-node triangles", 10}},
    {22, {"12-node triangles", 12}},
    {23, {"15-node triangles", 15}},
    {24, {"15-node triangles", 15}},
    {25, {"21-node triangles", 21}},
    {26, {"4-node lines", 4}},
    {27, {"5-node lines", 5}},
    {28, {"6-node lines", 6}},
    {29, {"20-node tetrahedra", 20, Role::kHigherTetrahedron}},
    {30, {"35-node tetrahedra", 35, Role::kHigherTetrahedron}},
    {31, {"56-node tetrahedra", 56, Role::kHigherTetrahedron}},
    {92, {"64-node hexahedra", 64, Role::kHexahedron}},
    {93, {"125-node hexahedra", 125, Role::kHexahedron}},
};

constexpr NumberedKind kVtkKinds[] = {
    {0, {"empty cells", 0}},
    {1, {"points", 1}},
    {2, {"point sets", 0}},
    {3, {"lines", 2}},
    {4, {"polylines", 0}},
    {5, {"triangles", 3}},
    {6, {"triangle strips", 0}},
    {7, {"polygons", 0}},
    {8, {"pixels", 4}},
    {9, {"quadrangles", 4}},
    {10, {"tetrahedra", 4, Role::kTetrahedron}},
    {11, {"voxels", 8, Role::kVoxel}},
    {12, {"hexahedra", 8, Role::kHexahedron}},
    {13, {"prisms", 6, Role::kWedge}},
    {14, {"pyramids", 5, Role::kPyramid}},
    {21, {"3-node lines", 3}},
    {22, {"6-node triangles", 6}},
    {23, {"8-node quadrangles", 8}},
    {24, {"10-node tetrahedra", 10, Role::kQuadraticTetrahedron}},
    {25, {"20-node hexahedra", 20, Role::kHexahedron}},
    {26, {"15-node prisms", 15, Role::kWedge}},
    {27, {"13-node pyramids", 13, Role::kPyramid}},
    {28, {"9-node quadrangles", 9}},
    {29, {"27-node hexahedra", 27, Role::kHexahedron}},
    {42, {"polyhedra", 0}},
    {68, {"curves of any order", 0}},
    {69, {"triangles of any order", 0}},
    {70, {"quadrangles of any order", 0}},
    {71, {"tetrahedra of any order", 0, Role::kHigherTetrahedron}},
    {72, {"hexahedra of any order", 0}},
    {73, {"prisms of any order", 0}},
    {78, {"Bezier tetrahedra", 0, Role::kHigherTetrahedron}},
};

const CellKind* find(std::span<const NumberedKind> kinds, std::int64_t type) {
  const auto found = std::find_if(kinds.begin(), kinds.end(),
                                  [type](const NumberedKind& row) { return row.type == type; });
  return found == kinds.end() ? nullptr : &found->kind;
}

}  // namespace

const CellKind* msh_cell(std::int64_t type) {
  return find(kMshKinds, type);
}

const CellKind* vtk_cell(std::int64_t type) {
  return find(kVtkKinds, type);
}

}  // namespace tremolo
