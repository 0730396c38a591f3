// The solid as requested on the command line, before anything is read. SI units.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "precompute/fem/assembly.h"
#include "precompute/mesher/mesher_answer.h"

namespace tremolo {

// Refined more often than this a mesh has over 32 768 times its tetrahedra.
inline constexpr int kMostRefine = 5;

struct ProblemRequest {
  std::string mesh_path;
  // Unit of surface coordinates, or of the tetrahedral mesh if no surface is read; empty: as the
  // files say.
  std::string unit;
  std::string mesh_unit;       // of the tetrahedral mesh, overrides `unit`
  bool merge = false;          // join vertices of the tetrahedral mesh that lie at one place
  SurfaceMeshOptions meshing;  // options for meshing a surface
  Material material;           // the default, for tetrahedra that no entry of `materials` covers
  std::vector<std::string> materials;     // see material_rules.h, in order
  std::vector<std::string> point_masses;  // SELECTOR=KG
  MassKind mass = MassKind::kConsistent;
  int refine = 0;                 // how often each tetrahedron is cut into eight, 0 to kMostRefine
  std::optional<int> order = 1;   // of the elements, 1 or 2; none: a rule of the mesh decides
  std::optional<bool> subdivide;  // draw the boundary with edge points; none: where it is coarse
  std::vector<std::string> fix;   // selectors; {"none"}: a free body
  std::array<std::vector<std::string>, 3> fix_axis;  // selectors; held along x, y, z only
  std::string load_at;                               // selector; empty: no default load
  Eigen::Vector3d load_force =
      Eigen::Vector3d::Zero();  // N, distributed over the selected vertices
  std::string render_path;      // surface to be drawn; empty: the surface that was meshed, if any
  std::string preview;          // .ply of the fixed and loaded vertices; empty: not written
  std::string select;           // selector to be shown; nothing is fixed or loaded then
  bool y_up = false;            // the files have y up: rotate them to z up (up_axis.h)
  bool imported = false;  // the basis is imported, not computed, and defines the fixed vertices
  unsigned threads = 1;
};

}  // namespace tremolo
