// --preview: writes the fixed and loaded vertices as a coloured surface, before any computation.
#pragma once

#include <string>

#include "common/mesh/surface_mesh.h"
#include "precompute/problem/problem.h"

namespace tremolo {

// Blue: fixed; light blue: held along single axes; red: loaded; green: selected by --select; grey:
// all others.
inline constexpr Colour kHeldColour = {40, 90, 220, 255};
inline constexpr Colour kPartlyHeldColour = {120, 190, 255, 255};
inline constexpr Colour kLoadedColour = {220, 40, 30, 255};
inline constexpr Colour kSelectedColour = {40, 170, 60, 255};
inline constexpr Colour kFreeColour = {200, 200, 200, 255};

// The boundary of the mesh, coloured, with a red arrow along the load, a quarter of the body's
// diagonal long. Its head lies at the centre of the loaded vertices if the load pushes into the
// body, its tail if the load pulls.
struct Preview {
  SurfaceMesh surface;
  std::vector<Colour> colours;  // one a vertex
};
Preview make_preview(const Problem& problem, const std::vector<VertexId>& selected = {});

// Writes the preview unless the path is empty. Throws Failure.
void write_preview(const std::string& path, const Problem& problem,
                   const std::vector<VertexId>& selected = {});

}  // namespace tremolo
