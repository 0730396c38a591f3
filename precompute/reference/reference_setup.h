// Common start of every run of the reference: checks, watched vertices, the path of its output.
#pragma once

#include <string>
#include <vector>

#include "common/mesh/tet_mesh.h"
#include "precompute/reference/reference_options.h"

namespace tremolo {

// Returns the vertices of --probe, each once, in the order of the flags. Throws Failure.
std::vector<VertexId> probe_vertices(const ReferenceOptions& options, const TetMesh& mesh);

// Returns the path of run.csv in the folder of --out.
std::string table_path(const ReferenceOptions& options);

// Checks the output before hours of computation: it is no input, and can be written. Makes the
// folder. Throws Failure.
void require_output(const ReferenceOptions& options);

}  // namespace tremolo
