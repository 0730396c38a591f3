#include "formats/polygons/polygon_mesh.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <span>
#include <string_view>
#include <utility>

#include "common/mesh/surface_mesh.h"
#include "formats/file/input_file.h"

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

namespace {

bool ends_in(std::string_view path, std::string_view ending) {
  if (path.size() <= ending.size()) return false;
  return std::equal(
      ending.begin(), ending.end(), path.end() - std::ssize(ending),
      [](char a, char b) { return a == std::tolower(static_cast<unsigned char>(b)); });
}

}  // namespace

Result<PolygonMesh> read_polygons(const std::string& path) {
  const bool obj = ends_in(path, ".obj");
  if (!obj && !ends_in(path, ".ply"))
    return usage_error(path + ": its ending must be .obj or .ply");
  const Result<std::string> text = read_whole_file(path);
  if (!text) return text.error();
  return obj ? parse_obj_polygons(*text, path) : parse_ply_polygons(*text, path);
}

Result<SurfaceMesh> read_surface_triangles(const std::string& path) {
  Result<PolygonMesh> polygons = read_polygons(path);
  if (!polygons) return polygons.error();
  return triangles_of(std::move(*polygons), path);
}

}  // namespace tremolo
