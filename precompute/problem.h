// Stage "mesh": what the user asked for, read and checked, before any matrix is made.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/mesh_check.h"
#include "formats/basis_data.h"
#include "formats/basis_writer.h"
#include "precompute/assembly.h"
#include "precompute/mesher/surface_mesher.h"

namespace tremolo {

// The command line of tremolo-precompute as values. Units SI.
struct PrecomputeOptions {
  std::string mesh_path;
  std::string output_path;
  std::string unit;            // of a surface's coordinates; empty: what its file says
  SurfaceMeshOptions meshing;  // of a surface
  Material material;
  std::vector<std::string> fix;                          // selectors; {"none"} asks for a free body
  std::string load_at;                                   // selector; empty: no default load
  Eigen::Vector3d load_force = Eigen::Vector3d::Zero();  // N, shared by the selected vertices
  std::optional<int> linear_modes;                       // k; default 20 or what the mesh has
  std::optional<int> modes;                              // r; default 30 or what k allows
  bool linear = false;  // the linear modes are the basis; no derivatives, no C, no Q
  BasisEncoding encoding = BasisEncoding::kFull;
  MassKind mass = MassKind::kConsistent;
  bool certify = true;
  unsigned threads = 1;
  bool limits = false;       // measure the machine, print each stage's shortest possible time
  std::string command_line;  // for the file's provenance
};

struct Problem {
  TetMesh mesh;
  MeshReport report;
  std::vector<VertexId> fixed;  // ascending
  bool free_body = false;
  DefaultLoad load;
  std::string mesh_format;
  std::string mesh_hash;           // XXH3-64 of vertices and tetrahedra, after repair
  std::vector<std::string> notes;  // for the user: repairs, oddities
};

// Reads, checks and selects. Throws Failure: kSystem for unreadable files, kContent and kUsage for
// everything that is wrong in them or in the options.
Problem load_problem(const PrecomputeOptions& options);

// k and r, defaults cut to what `free_dofs` (rigid motions taken off) allows; what was asked for
// explicitly and is not there is a Failure (kContent).
struct ModeCounts {
  int linear = 0;
  int modes = 0;
};
ModeCounts choose_mode_counts(const PrecomputeOptions& options, int free_dofs);

}  // namespace tremolo
