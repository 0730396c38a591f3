// Output of a reference run: JSON, lines on stderr, and run.csv.
#pragma once

#include <optional>
#include <string>

#include <nlohmann/json.hpp>

#include "common/energy.h"
#include "precompute/reference/comparison.h"
#include "precompute/reference/full/step_equation.h"
#include "precompute/reference/time_integration.h"

namespace tremolo {

// Output of a reference run: JSON, and lines on stderr.

using Json = nlohmann::ordered_json;

// Return the displacement (m) of each probe, and of the vertex with the largest one. field: 3n, m.
Json probe_json(const std::vector<VertexId>& probes, const Vector& field);
Json largest_json(const Vector& field);

// Add results to the object and print the most important ones.
void report_statics(const StaticSolution& solution, double seconds, Json& json);
void report_motion(const Motion& motion, const DriftMeter& drift, double seconds, Json& json);

// unseen: see unseen_load(). seconds: computing time of the reduced model.
Json comparison_json(const std::string& file, const ReducedBody& reduced,
                     const ComparisonSummary& summary, double unseen, double seconds);

// Print progress, and a comparison, on stderr.
void print_progress(const Motion& motion, std::int64_t steps, double seconds);
void print_comparison(const std::string& file, const ReducedBody& reduced,
                      const ComparisonSummary& summary, double unseen);

// run.csv of a reference: one row for each recorded instant, with columns as in that of `tremolo
// run`.

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
