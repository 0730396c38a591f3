// --fit and --sensitivities: the modes alone, with what the materials change in them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "precompute/pipeline.h"
#include "precompute/sensitivity/damping_fit.h"
#include "precompute/sensitivity/material_fit.h"

namespace tremolo {

struct SolidFit {
  std::vector<FitUnknown> unknowns;
  MaterialFit materials;
  std::optional<DampingFit> damping;
};

// Fits the problem's materials to the measurements of request.fit, in place. Throws Failure. In one
// process.
SolidFit fit_solid(const PrecomputeRequest& request, LoadedProblem& loaded, StageLog& log);

// The modes' frequencies and derivatives, a line a mode and material, on stderr and as JSON.
void print_sensitivities(const ModeSensitivities& found, const MaterialTable& materials);
nlohmann::ordered_json sensitivities_json(const ModeSensitivities& found,
                                          const MaterialTable& materials);

// The fitted constants with their deviations, and measured beside fitted frequencies.
void print_fit(const SolidFit& fit);
nlohmann::ordered_json fit_json(const SolidFit& fit);

}  // namespace tremolo
