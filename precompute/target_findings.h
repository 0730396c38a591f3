// What `--target-error` measured.
#pragma once

#include <limits>
#include <string>
#include <vector>

namespace tremolo {

// A candidate: the static displacement of a basis of `modes` coordinates under the default load
// beside that of the whole mesh, dimensionless. error: |u - Uq| / |u| in the M norm; infinite when
// the reduced model has no equilibrium. projection: the least that any q could leave. tip: the
// largest distance of the loaded vertices over their largest displacement. unseen: the part of the
// load's linear compliance that the basis leaves out.
struct TargetRow {
  int modes = 0;
  double error = std::numeric_limits<double>::infinity();
  double projection = 0;
  double tip = 0;
  double unseen = 0;
};

// load_vectors: columns of the basis that are the load's own static response.
struct TargetFindings {
  double asked = 0;
  int linear_modes = 0;
  int load_vectors = 0;
  std::string load;             // selector and force
  std::vector<TargetRow> rows;  // ascending modes, of the last series
  TargetRow chosen;             // modes 0: none
  bool kept() const { return chosen.modes > 0; }
};

}  // namespace tremolo
