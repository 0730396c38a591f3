// Output of a reference run: JSON, and lines on stderr.
#pragma once

#include <nlohmann/json.hpp>

#include "common/energy_drift.h"
#include "precompute/reference/comparison.h"
#include "precompute/reference/full/statics.h"
#include "precompute/reference/time_integration.h"

namespace tremolo {

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

}  // namespace tremolo
