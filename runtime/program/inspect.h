// `tremolo inspect`.
#pragma once

#include <string>

namespace tremolo {

// Prints the contents of a basis file and verifies every checksum; with a selector, prints its
// vertices instead. Returns the exit code; errors are printed on stderr.
int inspect_command(const std::string& path, const std::string& select, bool json);

}  // namespace tremolo
