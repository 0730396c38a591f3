#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "common/text.h"
#include "formats/polygons/off_text.h"
#include "formats/polygons/polygon_mesh.h"

namespace tremolo {
namespace {

// A vertex of the surface: one of the file's, with one copy for each colour that a face gives it.
struct Corners {
  std::vector<VertexId> source;     // of each vertex: the file's
  std::vector<OffNumbers> colours;  // of each vertex, or none
  std::vector<VertexId> vertex;     // of each corner
};

Corners take_corners(const OffMesh& off) {
  Corners corners;
  corners.vertex.reserve(off.corners.size());
  if (off.face_colours.empty()) {
    for (std::size_t v = 0; v < off.coordinates.size(); ++v)
      corners.source.push_back(static_cast<VertexId>(v));
    corners.colours = off.colours;
    corners.vertex.assign(off.corners.begin(), off.corners.end());
    return corners;
  }
  std::map<std::pair<VertexId, OffNumbers>, VertexId> taken;
  for (std::size_t f = 0; f + 1 < off.first.size(); ++f)
    for (std::size_t i = off.first[f]; i < off.first[f + 1]; ++i) {
      const OffNumbers& colour = off.face_colours[f];
      const auto [at, fresh] =
          taken.try_emplace({off.corners[i], colour}, static_cast<VertexId>(corners.source.size()));
      if (fresh) {
        corners.source.push_back(off.corners[i]);
        corners.colours.push_back(colour);
      }
      corners.vertex.push_back(at->second);
    }
  return corners;
}

double number_of(std::string_view written) {
  if (written.size() > 1 && written.front() == '+') written.remove_prefix(1);
  double value = std::nan("");
  read_decimal(written.data(), written.data() + written.size(), value);
  return value;
}

Colour bytes_of(const OffNumbers& colour) {
  Colour bytes;
  for (std::size_t k = 0; k < 4; ++k)
    bytes[k] = static_cast<std::uint8_t>(
        colour[k] > 0 ? std::lround(std::min(colour[k], 1.0F) * 255.0F) : 0);
  return bytes;
}

}  // namespace

Result<PolygonMesh> parse_off_polygons(std::string_view text) {
  Result<OffMesh> off = parse_off(text);
  if (!off) return off.error();
  const Corners corners = take_corners(*off);
  PolygonMesh mesh;
  mesh.objects = mesh.materials = {""};
  for (std::size_t v = 0; v < corners.source.size(); ++v) {
    const std::size_t source = corners.source[v];
    const auto& written = off->coordinates[source];
    mesh.vertices.emplace_back(number_of(written[0]), number_of(written[1]), number_of(written[2]));
    if (!corners.colours.empty()) mesh.colours.push_back(bytes_of(corners.colours[v]));
    if (!off->normals.empty()) mesh.normals.emplace_back(off->normals[source].data());
    if (!off->uvs.empty()) mesh.uvs.emplace_back(off->uvs[source].data());
  }
  for (std::size_t f = 0; f + 1 < off->first.size(); ++f) {
    for (std::size_t i = off->first[f]; i < off->first[f + 1]; ++i) {
      const VertexId v = corners.vertex[i];
      mesh.corners.push_back(
          {v, mesh.uvs.empty() ? kNoEntry : v, mesh.normals.empty() ? kNoEntry : v});
    }
    mesh.end_polygon(0, 0);
  }
  if (mesh.corners.empty()) return content_error("it holds no faces");
  mesh.notes = std::move(off->notes);
  return mesh;
}

}  // namespace tremolo
