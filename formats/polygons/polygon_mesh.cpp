#include "formats/polygons/polygon_mesh.h"

#include <algorithm>
#include <array>
#include <span>
#include <utility>

#include "common/mesh/polygon_cut.h"

namespace tremolo {
namespace {

// Empty if it is a polygon of a clean surface.
std::string polygon_problem(std::span<const PolygonCorner> polygon) {
  if (polygon.size() < 3) return "a face of fewer than three corners";
  std::vector<VertexId> sorted;
  for (const PolygonCorner& corner : polygon) sorted.push_back(corner.vertex);
  std::sort(sorted.begin(), sorted.end());
  if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end())
    return "a corner stands twice in a face";
  return {};
}

}  // namespace

void PolygonMesh::end_polygon(std::uint32_t object, std::uint32_t material) {
  first.push_back(corners.size());
  object_of.push_back(object);
  material_of.push_back(material);
}

Result<SurfaceMesh> triangles_of(PolygonMesh mesh, const std::string& name) {
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    if (!mesh.vertices[v].allFinite())
      return content_error(name + ": vertex " + std::to_string(v) + " is not finite");
  SurfaceMesh triangles;
  std::vector<Eigen::Vector3d> outline;
  std::vector<std::array<std::size_t, 3>> cut;
  for (std::size_t f = 0; f < mesh.polygons(); ++f) {
    const std::span polygon(mesh.corners.data() + mesh.first[f], mesh.first[f + 1] - mesh.first[f]);
    if (const std::string problem = polygon_problem(polygon); !problem.empty())
      return content_error(name + ": face " + std::to_string(f) + ": " + problem);
    outline.clear();
    cut.clear();
    for (const PolygonCorner& corner : polygon) outline.push_back(mesh.vertices[corner.vertex]);
    cut_polygon(outline, cut);
    for (const auto& [a, b, c] : cut)
      triangles.triangles.push_back({polygon[a].vertex, polygon[b].vertex, polygon[c].vertex});
  }
  if (triangles.triangles.empty()) return content_error(name + ": it has no triangles");
  triangles.vertices = std::move(mesh.vertices);
  return triangles;
}

}  // namespace tremolo
