// Stage "mesh": what the user asked for, read and checked, before any matrix is made.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "common/mesh/mesh_check.h"
#include "formats/basis/basis_data.h"
#include "formats/basis/basis_writer.h"
#include "precompute/embedding/embedding.h"
#include "precompute/fem/assembly.h"
#include "precompute/mesher/surface_mesh_options.h"
#include "precompute/problem/point_mass.h"
#include "precompute/solver/solver_choice.h"

namespace tremolo {

// The command line of tremolo-precompute as values. Units SI.
struct PrecomputeOptions {
  std::string mesh_path;
  std::string output_path;
  std::string config_path;                // of --config; empty: none
  std::string unit;                       // of surfaces' coordinates; empty: what their files say.
                                          // Where no surface is read, of the tetrahedral mesh's
  std::string mesh_unit;                  // of a tetrahedral mesh's, whatever `unit` says
  SurfaceMeshOptions meshing;             // of a surface
  Material material;                      // of what no entry of `materials` is of
  std::vector<std::string> materials;     // material_rules.h, in order
  std::vector<std::string> point_masses;  // SELECTOR=KG
  std::vector<std::string> fix;           // selectors; {"none"} asks for a free body
  std::array<std::vector<std::string>, 3> fix_axis;      // selectors: held along x, y, z only
  std::string load_at;                                   // selector; empty: no default load
  Eigen::Vector3d load_force = Eigen::Vector3d::Zero();  // N, shared by the selected vertices
  std::optional<int> linear_modes;                       // k; default 20 or what the mesh has
  std::optional<int> modes;            // r; default 30 or what k allows, all k of a linear model
  std::optional<double> target_error;  // r so that this is kept (target_error.h), dimensionless
  bool linear = false;                 // the linear modes are the basis; no derivatives, no C, no Q
  BasisEncoding encoding = BasisEncoding::kFull;
  MassKind mass = MassKind::kConsistent;
  bool mass_given = false;   // by the user: an import then makes its basis orthonormal in it
  std::string import_basis;  // VegaFEM's .U and .cub: nothing is solved (precompute/vega/import.h)
  std::string import_cubic;
  std::string modes_vtu;  // the modes on the tetrahedra, for ParaView; empty: not written
  bool certify = true;
  std::optional<LinearSolver> solver;  // none: what fits (solver_choice.h)
  std::optional<double> memory;        // bytes a rank may use; none: what is free
  unsigned threads = 1;
  bool checkpoint = false;   // keep finished stages (precompute/checkpoint/checkpoint.h)
  bool resume = false;       // and go on from those that are there
  bool limits = false;       // measure the machine, print each stage's shortest possible time
  std::string command_line;  // for the file's provenance
  std::string render_path;   // surface that is drawn; empty: the one that was meshed, if one was
  std::string preview;       // .ply of what is held and loaded; empty: not written
  bool y_up = false;         // of the files: turned so that z is up (precompute/problem/up_axis.h)
  std::string select;        // selector to be shown; nothing is computed then
};

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

// Reads, checks and selects; with options.select nothing is fixed or loaded yet. Throws Failure:
// kSystem for unreadable files, kContent and kUsage for everything that is wrong in them or in the
// options.
Problem load_problem(const PrecomputeOptions& options);

// Makes the surface (m, in the mesh's place) what is drawn: embeds its vertices, adds its colours,
// objects and materials to the mesh for selectors, and tells in problem.notes. To be called once
// the mesh is checked and before anything is selected; load_problem does.
void attach_render(Problem& problem, RenderSurface surface, unsigned threads);

// The default load that the options ask for; free vertices only. Throws Failure (kContent).
DefaultLoad make_load(const PrecomputeOptions& options, const Problem& problem);

// k and r, defaults cut to what `free_dofs` (rigid motions taken off) allows; what was asked for
// explicitly and is not there is a Failure (kContent).
struct ModeCounts {
  int linear = 0;
  int modes = 0;
};
ModeCounts choose_mode_counts(const PrecomputeOptions& options, int free_dofs);

}  // namespace tremolo
