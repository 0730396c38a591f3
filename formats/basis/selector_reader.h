// A selector -> vertices, including those that a file lists.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "common/mesh/selector.h"
#include "common/mesh/tet_mesh.h"
#include "common/result.h"

namespace tremolo {

// Ids from 0 to vertex_count - 1, separated by blanks, commas or line ends; # begins a comment.
// Sorted, without repeats. Errors: kSystem for a file that is missing or unreadable, kContent with
// the line for anything that is not such an id and for a file without ids.
Result<std::vector<VertexId>> read_id_list(const std::string& path, std::size_t vertex_count);
// The same for the file's contents; `path` is for errors.
Result<std::vector<VertexId>> parse_id_list(std::string_view text, const std::string& path,
                                            std::size_t vertex_count);

// select_vertices(), and read_id_list() for `file:PATH`; the same errors. Of a text: those of
// parse_selector() too.
Result<std::vector<VertexId>> resolve_selector(Selector selector, const TetMesh& mesh);
Result<std::vector<VertexId>> resolve_selector(const std::string& text, const TetMesh& mesh);

// Describes for the user which vertex each `near:` of a selector found, and how far away it is.
std::vector<std::string> near_notes(const Selector& selector, const TetMesh& mesh);

}  // namespace tremolo
