// run.csv of a reference: one row for each recorded instant, with columns as in that of `tremolo
// run`.
#pragma once

#include <optional>
#include <string>

#include "precompute/reference/comparison.h"
#include "precompute/reference/time_integration.h"

namespace tremolo {

// Columns: t (s), kinetic, potential, total, work, dissipated (J); u<v>x u<v>y u<v>z of the probes
// (m); for a comparison reduced_total (J), norm, difference, projection (kg^1/2 m), mac, tip,
// tip_difference (m) and r<v>x r<v>y r<v>z, the probes in the reduced model; the same names with
// suffix _2, _3 ... for the second and further files. Kept in memory until written.
struct ReferenceTable {
  std::vector<VertexId> probes;
  std::string text;
};

// Returns a table with its header line. compared: number of comparison files.
ReferenceTable begin_table(std::vector<VertexId> probes, std::size_t compared);

// Values of a reduced model in a row. total: J; field: 3n, m.
struct ReducedRow {
  Moment moment;
  double total = 0;
  Vector field;
};

// field: 3n, m. reduced: as many entries as given to begin_table; an empty one gives nan.
void add_row(const Motion& motion, const Vector& field,
             const std::vector<std::optional<ReducedRow>>& reduced, ReferenceTable& table);

}  // namespace tremolo
