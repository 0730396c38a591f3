// A whole file in memory, for the readers of mesh and text files.
#pragma once

#include <string>

#include "common/result.h"

namespace tremolo {

// The bytes of a regular file, unchanged. Errors: kSystem if it cannot be opened or read or is not
// a regular file, kContent if it is empty; both name the path.
Result<std::string> read_whole_file(const std::string& path);

}  // namespace tremolo
