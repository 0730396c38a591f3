// OBJ, PLY and STL -> polygons -> the surface that is drawn. The first byte chooses the format.
#include "formats/polygons/polygon_mesh.h"
#include "tests/fuzz/harness.h"

void tremolo::fuzz::read_input(std::string_view bytes) {
  if (bytes.empty()) return;
  const int format = static_cast<unsigned char>(bytes.front()) % 3;
  bytes.remove_prefix(1);
  Result<PolygonMesh> mesh = format == 0   ? parse_obj_polygons(bytes, "file")
                             : format == 1 ? parse_ply_polygons(bytes, "file")
                                           : parse_stl_polygons(bytes, "file");
  check_error(mesh);
  if (!mesh) return;
  const auto is_entry = [](std::int32_t index, std::size_t size) {
    return index == kNoEntry || (index >= 0 && static_cast<std::size_t>(index) < size);
  };
  for (const PolygonCorner& corner : mesh->corners)
    if (corner.vertex < 0 || static_cast<std::size_t>(corner.vertex) >= mesh->vertices.size() ||
        !is_entry(corner.uv, mesh->uvs.size()) || !is_entry(corner.normal, mesh->normals.size()))
      finding("a corner that is not there");
  if (mesh->first.back() != mesh->corners.size() || mesh->object_of.size() != mesh->polygons() ||
      mesh->material_of.size() != mesh->polygons() ||
      (!mesh->colours.empty() && mesh->colours.size() != mesh->vertices.size()))
    finding("polygons whose parts do not fit");
  const std::size_t vertices = mesh->vertices.size();
  std::vector<std::string> notes;
  const RenderSurface surface = render_surface_of(std::move(*mesh), notes);
  if (!surface.sources_hold() || surface.authored() != vertices)
    finding("a surface that lost the file's vertices");
  for (const Triangle& triangle : surface.triangles)
    for (const VertexId v : triangle)
      if (v < 0 || static_cast<std::size_t>(v) >= surface.vertices.size())
        finding("a triangle's corner that is not there");
}
