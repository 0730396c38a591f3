// Measurements of `--target-error`.
#pragma once

#include <limits>
#include <string>
#include <vector>

namespace tremolo {

// A candidate: the static displacement of a basis of `modes` coordinates under the default load,
// compared with the whole mesh; dimensionless. error: |u - Uq| / |u| in the M norm; infinite if the
// reduced model has no equilibrium. projection: lower bound over all q. tip: largest distance at
// the loaded vertices, relative to their largest displacement. unseen: the part of the load's
// linear compliance that the basis leaves out.
struct TargetRow {
  int modes = 0;
  double error = std::numeric_limits<double>::infinity();
  double projection = 0;
  double tip = 0;
  double unseen = 0;
};

// load_vectors: number of basis columns for the load's own static response.
struct TargetFindings {
  double asked = 0;
  int linear_modes = 0;
  int load_vectors = 0;
  std::string load;             // selector and force
  std::vector<TargetRow> rows;  // ascending modes, of the last series
  TargetRow chosen;             // modes = 0: none
  bool kept() const { return chosen.modes > 0; }
};

}  // namespace tremolo
