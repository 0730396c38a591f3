// What a reference run says: its JSON and its lines on stderr.
#pragma once

#include <nlohmann/json.hpp>

#include "common/energy_drift.h"
#include "precompute/reference/comparison.h"
#include "precompute/reference/statics.h"
#include "precompute/reference/time_integration.h"

namespace tremolo {

using Json = nlohmann::ordered_json;

// The displacement (m) of each probe, and of the vertex that moved farthest. field: 3n.
Json probe_json(const std::vector<VertexId>& probes, const Vector& field);
Json largest_json(const Vector& field);

// Each adds its keys to the object and says the most important.
void report_statics(const StaticSolution& solution, double seconds, Json& json);
void report_motion(const Motion& motion, const DriftMeter& drift, double seconds, Json& json);

// unseen: unseen_load(); seconds: that the reduced model took.
Json comparison_json(const std::string& file, const ReducedBody& reduced,
                     const ComparisonSummary& summary, double unseen, double seconds);

void say_progress(const Motion& motion, std::int64_t steps, double seconds);
void say_comparison(const std::string& file, const ReducedBody& reduced,
                    const ComparisonSummary& summary, double unseen);

}  // namespace tremolo
