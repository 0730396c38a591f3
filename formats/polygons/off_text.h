// Geomview's OFF as text: vertices, polygons of any number of corners, and their attributes.
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

// The contents of a file with n vertices.
struct OffMesh {
  std::vector<std::array<std::string_view, 3>> coordinates;  // n, numbers as text in the file
  std::vector<OffNumbers> normals;                           // n or empty; x, y, z, 0
  std::vector<OffNumbers> uvs;                               // n or empty; u, v, 0, 0
  std::vector<OffNumbers> colours;  // n or empty; red, green, blue, alpha from 0 to 1
  // Polygon f has corners[first[f]] to corners[first[f + 1] - 1], indices below n, perhaps fewer
  // than three.
  std::vector<std::size_t> first{0};
  std::vector<VertexId> corners;
  std::vector<OffNumbers> face_colours;  // one per polygon, or empty
  std::vector<std::string> notes;        // parts of the file that are ignored
};

// text: OFF, or COFF, NOFF, STOFF and further combinations, or the counts directly; comments and
// empty lines may be anywhere. Colours are parts of 255 if one of them is above 1. Errors
// (kContent, "line 12: expected ..."): binary and four-dimensional files, text that is not a
// number, a corner that is not a vertex, fewer vertices or faces than the counts.
Result<OffMesh> parse_off(std::string_view text);

}  // namespace tremolo
