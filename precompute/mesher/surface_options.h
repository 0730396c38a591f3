// The options of meshing a surface, the same in tremolo-mesh and tremolo-precompute.
#pragma once

#include <string>

#include <CLI/CLI.hpp>

#include "common/units.h"
#include "precompute/mesher/mesher_answer.h"
#include "precompute/system/option_checks.h"

namespace tremolo {

// unit: as the user wrote it; empty: the file's.
inline void add_surface_options(CLI::App& app, SurfaceMeshOptions& mesh, std::string& unit) {
  CLI::Option* size =
      app.add_option(
             "--size", mesh.size,
             "wanted edge, m: the mean of 1 to 1.35 of it, the longest up to 3 (thin walls: less)")
          ->check(above_zero());
  app.add_option("--tets", mesh.tets,
                 "wanted number of tetrahedra, met within 10 % (default 10 000; thin walls more)")
      ->check(at_least_one())
      ->excludes(size);
  app.add_option("--error", mesh.error,
                 "wanted distance to the surface, m (default 0.3 % of the diagonal)")
      ->check(above_zero());
  app.add_option("--unit", unit, std::string("of the surface's coordinates: ") + kLengthUnits);
  app.add_option("--thicken", mesh.thicken, "take the surface for a sheet so thick, m")
      ->check(above_zero());
  app.add_flag("--fill-holes", mesh.fill_holes, "close holes however large they are");
  app.add_flag("--keep-crumbs", mesh.keep_crumbs, "keep parts far smaller than the largest");
}

}  // namespace tremolo
