// `tremolo export`: models and what moves go into files that other programs open.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "common/result.h"
#include "runtime/apps/tremolo/export/animate.h"
#include "runtime/apps/tremolo/export/motion_source.h"
#include "runtime/io/exchange/animation.h"

namespace tremolo {

// Paths; empty: not requested.
struct ExportOptions {
  std::string model;
  std::string cub;  // VegaFEM's polynomials of the reduced forces
  std::string u;    // VegaFEM's basis: a row a dof of all the mesh's vertices, in the mesh's order
  std::string vtu;  // the modes on the surface, for ParaView and meshio
  std::string light;     // a basis file without the vertices inside (formats/basis/derived_basis.h)
  std::string rescaled;  // a basis file of the material that `rescale` gives (run/run_body.h)
  std::string rescale;

  bool any() const {
    return !cub.empty() || !u.empty() || !vtu.empty() || !light.empty() || !rescaled.empty();
  }
};

// An imported model gives its original .cub and .U; another model gives its numbers, with zero rows
// for fixed vertices. Returns the exit code; errors are printed.
int export_command(const ExportOptions& options);

// Parts of the page besides the motion; all are optional.
struct PageExtras {
  std::vector<std::string> runs;  // folders of `tremolo run --out`
  std::string note;               // a paragraph; `code` between backticks
  std::string live;  // path, as the page names it, of a page of the engine; shown first

  bool any() const { return !runs.empty() || !note.empty() || !live.empty(); }
};

// position_error: as PageMotion has it (runtime/io/page/document.h).
struct PageReport {
  std::uint64_t bytes = 0;
  double position_error = 0.0;
};

// subtitle: a description of the motion. Errors: page_motion's; read_energies' for a run; kSystem.
Result<PageReport> write_page_report(const std::string& path, const Animation& animation,
                                     const PageExtras& extras, const std::string& subtitle,
                                     bool z_up);

// Options of the export; the undocumented ones are as in GlbOptions.
struct MotionOutputs {
  std::string glb, pc2, mdd, pvd, usda, series, page;  // paths; empty: not requested
  PageExtras extras;                                   // of the page
  FrameRange range;
  std::size_t modes = 0;  // coordinates kept in the files; 0: all; the motion always has all
  bool plain_weights = false;
  bool no_normals = false;
  std::size_t normal_targets = 0;
  bool no_colliders = false;
  std::vector<std::string> textures;  // "MATERIAL=IMAGE" or "IMAGE"
  std::string up = "z";               // or "y", of the world
  std::string beside;                 // of cloth: a second scene, next to the first
  bool json = false;

  bool any() const {
    return !glb.empty() || !pc2.empty() || !mdd.empty() || !pvd.empty() || !usda.empty() ||
           !series.empty() || !page.empty();
  }
};

// Runs the motion and writes the files; prints their names on stdout. Returns the exit code. Errors
// are printed; after one no new file remains, except complete files of a series.
int export_motion_command(const MotionOutputs& outputs, const MotionSource& source);

}  // namespace tremolo
