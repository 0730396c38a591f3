// What the numbers of a surface's vertices mean in the mesh that was cut from it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace tremolo {

// The mesh has vertices of its own, so a number of the file names a place. A set of numbers means
// the boundary vertices over triangles, edges and corners of the surface whose corners are all in
// the set. A vertex of no such triangle means the boundary vertex nearest to it.
struct GivenVertices {
  std::size_t count = 0;                             // vertices of the file
  std::vector<std::int32_t> nearest;                 // s, of each the mesh's boundary vertex
  std::vector<std::int32_t> first_at;                // s, of each the lowest number at its position
  std::vector<std::array<std::int32_t, 3>> corners;  // of the surface's triangles, by first_at
  std::vector<std::int32_t> boundary;                // vertices of the mesh
  // Of each of `boundary`: the corners of what is closest to it, by first_at; -1 where that is an
  // edge or a corner.
  std::vector<std::array<std::int32_t, 3>> below;

  // Vertices of the mesh, ascending and each once. ids: below `count`.
  std::vector<std::int32_t> meant_by(const std::vector<std::int32_t>& ids) const;
};

}  // namespace tremolo
