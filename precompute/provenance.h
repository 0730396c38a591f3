// Where a basis file comes from.
#pragma once

#include <string>

#include "precompute/options/precompute_options.h"
#include "precompute/pipeline.h"

namespace tremolo {

// The JSON object kept in the file. No times: the same input gives the same file.
std::string provenance_json(const PrecomputeOptions& options, const PrecomputeResult& result);

}  // namespace tremolo
