#include "formats/mesh/cut_cells.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <numeric>
#include <utility>

namespace tremolo {
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
