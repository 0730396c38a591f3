// Geomview's OFF as text: vertices, polygons of any number of corners, and what belongs to them.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "common/mesh/tet_mesh.h"
#include "common/result.h"

namespace tremolo {

using OffNumbers = std::array<float, 4>;

// coordinates: of n vertices, as they are written, each a number; views into the text. normals (x,
// y, z, 0), uvs (u, v, 0, 0), colours (red, green, blue, alpha from 0 to 1): n each, or none.
// Polygon f has corners[first[f]] to corners[first[f + 1] - 1], indices below n, perhaps fewer than
// three. face_colours: one a polygon, or none. notes: what the file says and is not taken.
struct OffMesh {
  std::vector<std::array<std::string_view, 3>> coordinates;
  std::vector<OffNumbers> normals;
  std::vector<OffNumbers> uvs;
  std::vector<OffNumbers> colours;
  std::vector<std::size_t> first{0};
  std::vector<VertexId> corners;
  std::vector<OffNumbers> face_colours;
  std::vector<std::string> notes;
};

// text: OFF, or COFF, NOFF, STOFF and what else combines them, or the counts at once; comments and
// empty lines may stand anywhere. Colours are taken as parts of 255 if one of them is above 1.
// Errors (kContent, "line 12: expected ..."): binary and four-dimensional files, what is no number,
// a corner that is no vertex, fewer vertices or faces than the counts say.
Result<OffMesh> parse_off(std::string_view text);

}  // namespace tremolo
