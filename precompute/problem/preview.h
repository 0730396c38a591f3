// --preview: what is held and what is pushed, to be looked at before anything is computed.
#pragma once

#include <string>

#include "common/mesh/surface_mesh.h"
#include "precompute/problem/problem.h"

namespace tremolo {

// Blue: held; light blue: held along single axes; red: loaded; green: what --select chooses; grey:
// the rest.
inline constexpr Colour kHeldColour = {40, 90, 220, 255};
inline constexpr Colour kPartlyHeldColour = {120, 190, 255, 255};
inline constexpr Colour kLoadedColour = {220, 40, 30, 255};
inline constexpr Colour kSelectedColour = {40, 170, 60, 255};
inline constexpr Colour kFreeColour = {200, 200, 200, 255};

// The boundary of the mesh, painted, and a red arrow a quarter as long as the body is large, which
// points along the load: with its head on the loaded vertices' middle where the load pushes into
// the body, with its tail there where it pulls.
struct Preview {
  SurfaceMesh surface;
  std::vector<Colour> colours;  // a vertex
};
Preview make_preview(const ProblemRequest& request, const Problem& problem);

// Writes request.preview, if it is asked for. Throws Failure.
void write_preview(const ProblemRequest& request, const Problem& problem);

}  // namespace tremolo
