#include "formats/polygons/triangle_reader.h"

#include <algorithm>
#include <cctype>
#include <string_view>
#include <utility>

#include "formats/file/whole_file.h"
#include "formats/polygons/obj_text.h"
#include "formats/polygons/ply_text.h"

namespace tremolo {
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
