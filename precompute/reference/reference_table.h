// run.csv of a reference: a row for each recorded moment, columns as in `tremolo run`'s.
#pragma once

#include <optional>
#include <string>

#include "precompute/reference/comparison.h"
#include "precompute/reference/time_integration.h"

namespace tremolo {

// Columns: t (s), kinetic, potential, total, work, dissipated (J); u<v>x u<v>y u<v>z of the probes
// (m); with a comparison reduced_total (J), norm, difference, projection (kg^1/2 m), mac, tip,
// tip_difference (m) and r<v>x r<v>y r<v>z, the probes in the reduced model; of the second file and
// of those after it the same names with _2, _3 ... behind. In memory until it is written.
struct ReferenceTable {
  std::vector<VertexId> probes;
  std::string text;
};

ReferenceTable begin_table(std::vector<VertexId> probes, std::size_t compared);

// A reduced model's side of a row. total: J; field: 3n, m.
struct ReducedRow {
  Moment moment;
  double total = 0;
  Vector field;
};

// field: 3n, m. reduced: as many as the table was begun with; none: nan in its columns.
void add_row(const Motion& motion, const Vector& field,
             const std::vector<std::optional<ReducedRow>>& reduced, ReferenceTable& table);

}  // namespace tremolo
