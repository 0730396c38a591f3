// A selector as the user wrote it -> vertices, including those listed in a file.
#pragma once

#include <string>
#include <vector>

#include "common/mesh/selector.h"
#include "common/mesh/tet_mesh.h"
#include "common/result.h"

namespace tremolo {

// parse_selector() and select_vertices(), and read_id_list() for `file:PATH`; the same errors.
Result<std::vector<VertexId>> resolve_selector(const std::string& text, const TetMesh& mesh);

// For the user: what each `near:` of a selector that resolve_selector() took found, and how far
// away.
std::vector<std::string> near_notes(const std::string& text, const TetMesh& mesh);

}  // namespace tremolo
