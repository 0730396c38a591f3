// Checksums as the program writes and compares them: XXH3-64, 16 hexadecimal digits.
#pragma once

#include <string>
#include <string_view>

#include "common/result.h"

namespace tremolo {

std::string checksum(std::string_view bytes);

// The checksum of the running program's file, which distinguishes results of other builds. Errors:
// kSystem if the file cannot be read.
Result<std::string> program_checksum();

}  // namespace tremolo
