// Provenance of a basis file.
#pragma once

#include <string>

#include "precompute/pipeline.h"

namespace tremolo {

// Returns the JSON object stored in the file. It has no times, so the same input gives the same
// file.
std::string provenance_json(const PrecomputeRequest& request, const Problem& problem,
                            const PrecomputeResult& result);

}  // namespace tremolo
