// Whole files, and what tells two of them apart.
#pragma once

#include <string>
#include <string_view>

#include "common/result.h"

namespace tremolo::reproduce {

// The bytes of a file. Errors: kSystem if it cannot be read.
Result<std::string> file_bytes(const std::string& path);

// XXH3-64, 16 hexadecimal digits.
std::string checksum(std::string_view bytes);

}  // namespace tremolo::reproduce
