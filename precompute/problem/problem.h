// Stage "mesh": what the user asked for, read and checked, before any matrix is made.
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

// Free parts that do not touch: every one has six rigid motions to be kept out of the modes, and as
// many frequencies as there are parts may lie at one place.
inline constexpr std::size_t kMostFreeParts = 1'000;

struct Problem {
  TetMesh mesh;
  MeshReport report;
  std::vector<VertexId> fixed;                // ascending
  std::array<std::vector<VertexId>, 3> held;  // ascending; do not move along x, y, z
  bool free_body = false;
  DefaultLoad load;
  std::optional<RenderSurface> render;  // what is drawn; none: the boundary of the tetrahedra
  Embedding embedding;                  // of its vertices
  MaterialTable materials;
  std::vector<PointMass> point_masses;
  std::string mesh_format;
  std::string mesh_hash;           // XXH3-64 of vertices and tetrahedra, after repair
  std::vector<std::string> notes;  // for the user: repairs, oddities
};

// Reads, checks and selects; with request.select nothing is fixed or loaded yet. Throws Failure:
// kSystem for unreadable files, kContent and kUsage for everything that is wrong in them or in the
// options.
Problem load_problem(const ProblemRequest& request);

// Makes the surface (m, in the mesh's place) what is drawn: embeds its vertices, adds its colours,
// objects and materials to the mesh for selectors, and tells in problem.notes. To be called once
// the mesh is checked and before anything is selected; load_problem does.
void attach_render(Problem& problem, RenderSurface surface, unsigned threads);

// The default load that is asked for; free vertices only. Throws Failure (kContent).
DefaultLoad make_load(const ProblemRequest& request, const Problem& problem);

}  // namespace tremolo
