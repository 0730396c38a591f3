#include "common/mesh/coincident_vertices.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>

#include "common/index.h"
#include "common/mesh/point_cells.h"

namespace tremolo {
namespace {

constexpr double kOfShortestEdge = 1e-3;

std::vector<bool> used_vertices(const TetMesh& mesh) {
  std::vector<bool> used(mesh.vertices.size(), false);
  const auto use = [&](VertexId v) {
    if (is_index(v, used.size())) used[v] = true;
  };
  for (const Tetrahedron& tet : mesh.tetrahedra) std::for_each(tet.begin(), tet.end(), use);
  for (const MeshEdge& edge : mesh.edges) use(edge.point);
  return used;
}

// Zero if an edge has no length.
double shortest_edge(const TetMesh& mesh) {
  double shortest = std::numeric_limits<double>::infinity();
  for (const Tetrahedron& tet : mesh.tetrahedra)
    for (const auto& [a, b] : kTetEdges)
      if (is_index(tet[a], mesh.vertices.size()) && is_index(tet[b], mesh.vertices.size()))
        shortest = std::min(shortest, (mesh.vertices[tet[a]] - mesh.vertices[tet[b]]).norm());
  return shortest;
}

}  // namespace

Coincidences find_coincidences(const TetMesh& mesh) {
  Coincidences found;
  found.first_at.resize(mesh.vertices.size());
  std::iota(found.first_at.begin(), found.first_at.end(), VertexId{0});
  const std::vector<bool> used = used_vertices(mesh);
  std::vector<Eigen::Vector3d> points;
  for (std::size_t v = 0; v < used.size(); ++v)
    if (used[v]) points.push_back(mesh.vertices[v]);
  const BoundingBox box = bounding_box(points);
  const double width =
      std::min(kCoincident * box.diagonal(), kOfShortestEdge * shortest_edge(mesh));
  // Cells are counted from the corner of the box, at most 1e9 of them unless edges are absurdly
  // short.
  if (!(width > 1e-15 * box.diagonal()) || !std::isfinite(box.diagonal())) return found;
  PointCells cells(width);
  std::vector<VertexId> vertex_of_point;
  for (std::size_t v = 0; v < used.size(); ++v) {
    if (!used[v]) continue;
    const Eigen::Vector3d x = mesh.vertices[v] - box.low;
    const std::int32_t point = cells.near(x, width);
    if (point >= 0) {
      found.first_at[v] = vertex_of_point[point];
      ++found.pairs;
      continue;
    }
    cells.add(x);
    vertex_of_point.push_back(static_cast<VertexId>(v));
  }
  return found;
}

void merge_vertices(const Coincidences& found, TetMesh& mesh) {
  if (found.pairs == 0) return;
  const auto first = [&](VertexId v) {
    return is_index(v, found.first_at.size()) ? found.first_at[v] : v;
  };
  for (Tetrahedron& tet : mesh.tetrahedra)
    for (VertexId& v : tet) v = first(v);
  for (auto& [name, set] : mesh.node_sets) {
    for (VertexId& v : set) v = first(v);
    std::sort(set.begin(), set.end());
    set.erase(std::unique(set.begin(), set.end()), set.end());
  }
  for (MeshEdge& edge : mesh.edges) {
    edge.point = first(edge.point);
    std::tie(edge.a, edge.b) = std::minmax({first(edge.a), first(edge.b)});
  }
  const auto key = [](const MeshEdge& edge) { return std::tie(edge.point, edge.a, edge.b); };
  std::sort(mesh.edges.begin(), mesh.edges.end(),
            [&](const MeshEdge& x, const MeshEdge& y) { return key(x) < key(y); });
  mesh.edges.erase(
      std::unique(mesh.edges.begin(), mesh.edges.end(),
                  [&](const MeshEdge& x, const MeshEdge& y) { return key(x) == key(y); }),
      mesh.edges.end());
}

}  // namespace tremolo
