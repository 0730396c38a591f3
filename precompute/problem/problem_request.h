// What solid it is: asked for on the command line, not yet read. Units SI.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "precompute/fem/assembly.h"
#include "precompute/mesher/surface_mesh_options.h"

namespace tremolo {

struct ProblemRequest {
  std::string mesh_path;
  std::string unit;                       // of surfaces' coordinates; empty: what their files say.
                                          // Where no surface is read, of the tetrahedral mesh's
  std::string mesh_unit;                  // of a tetrahedral mesh's, whatever `unit` says
  SurfaceMeshOptions meshing;             // of a surface
  Material material;                      // of what no entry of `materials` is of
  std::vector<std::string> materials;     // material_rules.h, in order
  std::vector<std::string> point_masses;  // SELECTOR=KG
  MassKind mass = MassKind::kConsistent;
  std::vector<std::string> fix;                          // selectors; {"none"} asks for a free body
  std::array<std::vector<std::string>, 3> fix_axis;      // selectors: held along x, y, z only
  std::string load_at;                                   // selector; empty: no default load
  Eigen::Vector3d load_force = Eigen::Vector3d::Zero();  // N, shared by the selected vertices
  std::string render_path;  // surface that is drawn; empty: the one that was meshed, if one was
  std::string preview;      // .ply of what is held and loaded; empty: not written
  std::string select;       // selector to be shown; nothing is fixed or loaded then
  bool y_up = false;        // of the files: turned so that z is up (up_axis.h)
  bool imported = false;    // a basis that is read, not solved for, says itself what is held
  unsigned threads = 1;
};

}  // namespace tremolo
