// Lists of vertex ids in text files.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "common/mesh/tet_mesh.h"
#include "common/result.h"

namespace tremolo {

// Ids from 0 to vertex_count - 1, separated by blanks, commas or line ends; # begins a comment.
// Sorted, without repeats. Errors: kSystem for a file that is missing or unreadable, kContent with
// the line for anything that is not such an id and for a file without ids.
Result<std::vector<VertexId>> read_id_list(const std::string& path, std::size_t vertex_count);
// The same of the file's contents; `path` stands in errors.
Result<std::vector<VertexId>> parse_id_list(std::string_view text, const std::string& path,
                                            std::size_t vertex_count);

}  // namespace tremolo
