#include "formats/mesh/mesh_cells.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <numeric>
#include <span>
#include <utility>

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

namespace {

// Corners of a face in order, counter-clockwise seen from outside; -1 after the corners of a
// triangle.
using CellFace = std::array<int, 4>;
constexpr std::array<CellFace, 6> kHexahedron = {
    {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}}};
constexpr std::array<CellFace, 5> kWedge = {
    {{0, 2, 1, -1}, {3, 4, 5, -1}, {0, 1, 4, 3}, {1, 2, 5, 4}, {2, 0, 3, 5}}};
constexpr std::array<CellFace, 5> kPyramid = {
    {{0, 3, 2, 1}, {0, 1, 4, -1}, {1, 2, 4, -1}, {2, 3, 4, -1}, {3, 0, 4, -1}}};

std::span<const CellFace> faces_of(CellKind::Role role) {
  if (role == CellKind::Role::kWedge) return kWedge;
  if (role == CellKind::Role::kPyramid) return kPyramid;
  return kHexahedron;
}

bool repeats(const Tetrahedron& tet) {
  for (int a = 0; a < 4; ++a)
    for (int b = 0; b < a; ++b)
      if (tet[a] == tet[b]) return true;
  return false;
}

}  // namespace

std::string cut_cell(const CellKind& kind, std::span<const VertexId> corners,
                     std::span<const VertexId> rank, TetMesh& mesh) {
  const auto lower = [&](VertexId a, VertexId b) {
    return std::pair(rank[a], a) < std::pair(rank[b], b);
  };
  const VertexId apex = *std::min_element(corners.begin(), corners.end(), lower);
  const std::size_t before = mesh.tetrahedra.size();
  int positive = 0;
  int negative = 0;
  for (const CellFace& face : faces_of(kind.role)) {
    std::array<VertexId, 4> around{};
    const std::size_t count = face[3] < 0 ? 3 : 4;
    for (std::size_t n = 0; n < count; ++n) around[n] = corners[face[n]];
    const auto end = around.begin() + count;
    if (std::find(around.begin(), end, apex) != end) continue;
    std::rotate(around.begin(), std::min_element(around.begin(), end, lower), end);
    for (std::size_t n = 2; n < count; ++n) {
      Tetrahedron tet = {around[0], around[n - 1], around[n], apex};
      if (repeats(tet)) continue;
      const double volume = signed_volume(mesh, tet);
      positive += volume > 0 ? 1 : 0;
      negative += volume < 0 ? 1 : 0;
      if (volume < 0) std::swap(tet[2], tet[3]);
      mesh.tetrahedra.push_back(tet);
    }
  }
  if (positive == 0 || negative == 0) return "";
  mesh.tetrahedra.resize(before);
  return "is so distorted that the tetrahedra it is cut into overlap: mesh with tetrahedra, or "
         "with better shapes";
}

std::vector<VertexId> ranks_by_place(const std::vector<Eigen::Vector3d>& vertices) {
  std::vector<VertexId> order(vertices.size());
  std::iota(order.begin(), order.end(), VertexId{0});
  const auto less = [&](VertexId a, VertexId b) {
    const Eigen::Vector3d& x = vertices[a];
    const Eigen::Vector3d& y = vertices[b];
    if (x != y) return std::lexicographical_compare(x.begin(), x.end(), y.begin(), y.end());
    return a < b;
  };
  std::sort(order.begin(), order.end(), less);
  std::vector<VertexId> rank(vertices.size());
  for (std::size_t n = 0; n < order.size(); ++n) {
    const bool again = n > 0 && vertices[order[n]] == vertices[order[n - 1]];
    rank[order[n]] = again ? rank[order[n - 1]] : order[n];
  }
  return rank;
}

}  // namespace tremolo
