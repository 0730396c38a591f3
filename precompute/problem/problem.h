// Stage "mesh": reads and checks the user's input before any matrix is assembled.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "common/mesh/mesh_check.h"
#include "formats/basis/basis_data.h"
#include "precompute/embedding/embedding.h"
#include "precompute/problem/point_mass.h"
#include "precompute/problem/problem_request.h"

namespace tremolo {

// Most disconnected parts of a free body: each has six rigid motions to be kept out of the modes,
// and a frequency may be repeated as often as there are parts.
inline constexpr std::size_t kMostFreeParts = 1'000;

// Held vertices that selectors chose by where they lie rather than as a piece of the surface:
// edges between them are held (common/mesh/edge_points.h). Ascending; along: x, y, z.
struct HeldByPlace {
  std::vector<VertexId> fixed;
  std::array<std::vector<VertexId>, 3> along;
};

struct Problem {
  TetMesh mesh;   // of order 2 with edge points
  int order = 1;  // of the elements
  std::optional<bool>
      subdivide;  // whether the drawn boundary uses the edge points; none: automatic
  MeshReport report;
  std::vector<VertexId> fixed;                // ascending, held edge points among them
  std::array<std::vector<VertexId>, 3> held;  // held along x, y, z only; ascending
  HeldByPlace by_place;
  bool free_body = false;
  DefaultLoad load;
  std::optional<RenderSurface>
      render;           // the surface that is drawn; none: the boundary of the tetrahedra
  Embedding embedding;  // of the render surface's vertices in the tetrahedra
  MaterialTable materials;
  std::vector<PointMass> point_masses;
  std::string mesh_format;
  std::string mesh_hash;           // XXH3-64 of vertices and tetrahedra, after repair
  std::vector<std::string> notes;  // for the user: repairs and peculiarities
};

// Reads and checks the files and assigns materials; nothing is fixed or loaded. Throws Failure:
// kSystem for unreadable files, kContent and kUsage for wrong content and options.
Problem load_solid(const ProblemRequest& request);

// Does the same, selects the vertices that are fixed, loaded and weighed, and makes the elements
// quadratic or smaller as requested.
Problem load_problem(const ProblemRequest& request);

// Returns a hint if a selector takes the low end of z of files that appear to have y up; else an
// empty string, also if --up y was given.
std::string up_axis_hint(const SolidFiles& files, const std::vector<Selector>& selectors,
                         const TetMesh& mesh);

// Sets the render surface (m, in the mesh's coordinates): embeds its vertices, adds its colours,
// objects and materials to the mesh for selectors, and appends to problem.notes. load_solid calls
// it after the mesh is checked and before anything is selected.
void attach_render(Problem& problem, RenderSurface surface, unsigned threads);

// Returns the load's forces, on free vertices only. Throws Failure (kContent).
DefaultLoad make_load(const LoadRequest& request, const Problem& problem);

}  // namespace tremolo
