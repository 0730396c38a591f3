// Polygons as the files of modelling programs have them, one reader a format, and the way to a
// RenderSurface.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "common/mesh/render_surface.h"
#include "common/mesh/surface_mesh.h"
#include "common/result.h"

namespace tremolo {

// A surface in the form of its file: vertices, and polygons whose corners refer to them.
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

// Wavefront's .obj as text -> PolygonMesh. Reads v (followed by w or a colour), vt, vn, f, o, g,
// usemtl; counts p and l; skips the rest. Corners count from 1, or from the end if they are
// negative, and may name vertices that follow later in the file. An object is the part below an `o`
// or a `g` of one name. A backslash joins lines. A corner's vt or vn that does not exist is left
// out and noted. Errors (kContent, with `name` and line): something that is not a number, a corner
// that is not a vertex.
Result<PolygonMesh> parse_obj_polygons(std::string_view text, const std::string& name);

// Geomview's .off -> PolygonMesh. A vertex whose faces have several colours becomes one vertex for
// each. Errors: those of parse_off(), and kContent for a file without faces; without a file name.
Result<PolygonMesh> parse_off_polygons(std::string_view text);

// A .ply file, as text or in bytes of either order -> PolygonMesh. Elements may be in any order,
// and unknown ones are skipped, with or without lists. Reads vertices with normals, texture
// coordinates and colours, faces with texture coordinates of their corners, and triangle strips.
// Errors (kContent, with `name`): those of the header, an early end, something that is not a
// number, a corner that is not a vertex.
Result<PolygonMesh> parse_ply_polygons(std::string_view bytes, const std::string& name);

// Reads an .stl file, text or binary, as a PolygonMesh with three vertices for each triangle. Text:
// keywords in any case, numbers and lines in any layout, a name with blanks up to the end of its
// line; each solid is an object. Binary, also if it begins with "solid": one object, colours of
// VisCAM and Materialise; bytes after the last triangle are noted. Errors (kContent, with `name`
// and line or byte): a file of neither form, or an early end.
Result<PolygonMesh> parse_stl_polygons(std::string_view bytes, const std::string& name);

// Errors: kSystem for a file that cannot be read; kUsage for another ending; those of
// parse_obj_polygons() and parse_ply_polygons().
Result<PolygonMesh> read_polygons(const std::string& path);

// Only positions and triangles, in the file's order. Errors also those of triangles_of().
Result<SurfaceMesh> read_surface_triangles(const std::string& path);

// Polygons as a file has them -> RenderSurface. Vertices keep the file's order and numbers, also
// those without a triangle. A vertex whose corners have several normals or texture coordinates gets
// copies for all but the first, after the file's vertices; RenderSurface::sources maps them back. A
// vertex that is not finite keeps its number and gets the position of the first finite one; its
// triangles are left out. Appends notes for the user.
RenderSurface render_surface_of(PolygonMesh mesh, std::vector<std::string>& notes);

// Bytes of a vertex and of a triangle in a RenderSurface.
inline constexpr std::uint64_t kVertexBytes = 48;
inline constexpr std::uint64_t kTriangleBytes = 20;

// Numbers of things that do not become triangles.
struct LeftOut {
  std::uint64_t points = 0;
  std::uint64_t lines = 0;
  std::uint64_t polygons = 0;    // that cannot be cut
  std::uint64_t not_finite = 0;  // triangles with coordinates that are no numbers
};

void note_left_out(const LeftOut& left_out, std::vector<std::string>& notes);

// Vertices whose flag is false get the normal of their triangles, weighted by area; if all flags
// are false, the surface keeps no normals.
void fill_missing_normals(RenderSurface& surface, const std::vector<bool>& has_normal);

}  // namespace tremolo
