// A surface in the form of its file: vertices, and polygons whose corners refer to them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "common/mesh/surface_mesh.h"
#include "common/result.h"

namespace tremolo {

inline constexpr std::int32_t kNoEntry = -1;

// A corner of a polygon: its vertex, and its entries in `uvs` and `normals` or kNoEntry.
struct PolygonCorner {
  VertexId vertex = 0;
  std::int32_t uv = kNoEntry;
  std::int32_t normal = kNoEntry;
};

// The readers of .obj, .ply, .stl and .off fill this. Every corner names something; coordinates
// need not be finite, polygons may have any number of corners.
struct PolygonMesh {
  std::vector<Eigen::Vector3d> vertices;   // in the file's order and unit, those without a face too
  std::vector<Colour> colours;             // one per vertex, or empty
  std::vector<Eigen::Vector2f> uvs;        // named by corners
  std::vector<Eigen::Vector3f> normals;    // named by corners, of any length
  std::vector<PolygonCorner> corners;      // of all polygons, in order
  std::vector<std::size_t> first{0};       // polygon f has corners first[f] to first[f + 1] - 1
  std::vector<std::uint32_t> object_of;    // of each polygon: index into objects
  std::vector<std::uint32_t> material_of;  // of each polygon: index into materials
  std::vector<std::string> objects;        // names as the file has them, perhaps empty or repeated
  std::vector<std::string> materials;
  std::uint64_t points = 0;  // statements that draw points and lines
  std::uint64_t lines = 0;
  std::vector<std::string> notes;  // contents of the file that are not read, for the user

  std::size_t polygons() const { return first.size() - 1; }
  // Ends a polygon, which has the corners since the last call.
  void end_polygon(std::uint32_t object, std::uint32_t material);
};

// Only the triangles. Errors (kContent), with `name` and the polygon's number: a vertex that is not
// finite, a polygon of fewer than three corners or with a repeated vertex, no triangles.
Result<SurfaceMesh> triangles_of(PolygonMesh mesh, const std::string& name);

}  // namespace tremolo
